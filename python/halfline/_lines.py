"""The options of a view in the words of the command."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from os import fspath
from typing import Any

import numpy as np

from ._source import Source


def lines(
    source: Source | None,
    options: Mapping[str, Any],
    lens: Mapping[str, float],
    renderer: Mapping[str, str],
) -> dict[str, Any]:
    """Those of every picture; and those in lines that are copied, which read the file and choose
    the renderer too.
    """
    reading = {} if source is None else {**source.options, "keep": None}
    # A corner has the option of the place, which has the right side as its default.
    names = {"legend": "legend_in", "cell": "outline", "focus": "focus_distance"}
    rendering = {names.get(name, name): value for name, value in {**options, **lens}.items()}
    pictures = list(_options(rendering))
    return {
        "source": None if source is None else fspath(source.path),
        "rendering": pictures,
        "copied": [*_options(reading), *pictures, *_options(renderer)],
    }


def _options(options: Mapping[str, Any]) -> Iterator[tuple[str, str | None]]:
    """Keywords as options of the command, with their values; a flag has none."""
    for name, value in options.items():
        if value is None or value is False:
            continue
        if value is True:
            yield name, None
        elif name == "columns" and isinstance(value, Mapping):
            yield name, ",".join(f"{meaning}={column}" for meaning, column in value.items())
        elif isinstance(value, Mapping):
            yield from ((name, f"{key}={_word(one)}") for key, one in value.items())
        elif name in ("select", "hide", "clip", "sun"):
            single = isinstance(value, str) or (name == "sun" and np.ndim(value) == 1)
            yield from ((name, _word(one)) for one in ([value] if single else value))
        else:
            yield name, _word(value)


def _word(value: Any) -> str:
    """A value of an option; several have commas between them."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        return str(_plain(value))
    return ",".join(str(_plain(one)) for one in value)


def _plain(value: Any) -> Any:
    """A number of NumPy, or a path, as one of Python."""
    if isinstance(value, np.generic):
        return value.item()
    return fspath(value) if hasattr(value, "__fspath__") else value
