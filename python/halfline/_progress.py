"""Progress: a function of the caller, or a bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

Callback = Callable[[str, int, int, str], object]
"""Called with the step, how many are done, how many there are (0 if not known), and what is
counted.
"""

Reporter = Callback | None


@contextmanager
def reporter(progress: bool | Callback) -> Iterator[Reporter]:
    """The function to call: the caller's own, a bar for ``True`` where somebody sees it, or
    none.
    """
    if callable(progress):
        yield progress
    elif progress is True:
        bar = _Bar() if _is_seen() else None
        try:
            yield bar
        finally:
            if bar is not None:
                bar.close()
    elif progress is False or progress is None:
        yield None
    else:
        raise TypeError(
            f"progress is {progress!r}; give True, False or a function of step, done, total, unit"
        )


def _is_seen() -> bool:
    """Whether a terminal or a notebook shows standard error; a log is no place for a bar."""
    return _in_notebook() or (sys.stderr is not None and sys.stderr.isatty())


def _in_notebook() -> bool:
    ipython: Any = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")


_MANY = 10_000


class _Bar:
    """One bar for all steps, by tqdm, or a line on standard error without it; it is gone at the
    end.
    """

    def __init__(self) -> None:
        self._bar: Any = None
        self._step = ""
        self._width = 0
        try:
            self._tqdm: Any = import_module("tqdm.auto").tqdm
        except ImportError:
            self._tqdm = None

    def __call__(self, step: str, done: int, total: int, unit: str) -> None:
        if self._tqdm is None:
            self._show(f"{step}: {done} of {total} {unit}")
            return
        if self._bar is None:
            self._bar = self._tqdm(total=total or None, desc=step, leave=False)
        if step != self._step:
            # Few are counted in full, many in thousands.
            self._bar.unit, self._bar.unit_scale = f" {unit}", total >= _MANY
            self._bar.set_description(step, refresh=False)
            self._bar.reset(total=total or None)
            self._step = step
        self._bar.n = done
        self._bar.refresh()

    def _show(self, line: str) -> None:
        # Blanks over the longer line before it: notebooks do not know the codes of terminals.
        print(f"\r{line}{' ' * (self._width - len(line))}", end="", file=sys.stderr, flush=True)
        self._width = len(line)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        if self._width:
            self._show("")
            print("\r", end="", file=sys.stderr, flush=True)
