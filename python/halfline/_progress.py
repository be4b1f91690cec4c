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
    """The function to call: that of the caller, a bar for ``True``, or none."""
    if callable(progress):
        yield progress
    elif progress is True:
        bar = _Bar()
        try:
            yield bar
        finally:
            bar.close()
    elif progress is False or progress is None:
        yield None
    else:
        raise TypeError(
            f"progress is {progress!r}; give True, False or a function of step, done, total, unit"
        )


class _Bar:
    """A bar by tqdm, or a line on standard error without it."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._step = ""
        self._line = False
        try:
            self._tqdm: Any = import_module("tqdm.auto").tqdm
        except ImportError:
            self._tqdm = None

    def __call__(self, step: str, done: int, total: int, unit: str) -> None:
        if self._tqdm is None:
            self._line = True
            print(f"\r{step}: {done} of {total} {unit}\x1b[K", end="", file=sys.stderr, flush=True)
            return
        if step != self._step:
            self._end()
            self._step = step
            self._bar = self._tqdm(
                total=total or None, desc=step, unit=f" {unit}", unit_scale=True
            )
        self._bar.n = done
        self._bar.refresh()

    def _end(self) -> None:
        if self._bar is not None:
            self._bar.close()

    def close(self) -> None:
        self._end()
        if self._line:
            print(file=sys.stderr)
