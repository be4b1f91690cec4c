"""The picture of a request of the page, and its options in the words of the command."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import fspath
from typing import Any

import numpy as np

from . import _halfline
from ._source import Source
from .camera import Camera

SELECTED = "darkorange"
OTHERS = "silver"
"""The colour of spheres that are selected on the page, and that of the others."""


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture of the page."""

    pose: Mapping[str, Any]
    lens: Mapping[str, float]
    """Aperture and focus, if the lens has a size."""
    size: tuple[int, int]
    options: Mapping[str, Any]
    select: str | None
    renderer: Mapping[str, str]
    """The arguments of the renderer; empty for the usual one."""

    @property
    def camera(self) -> Camera:
        """The camera."""
        given: dict[str, Any] = {**self.pose, **self.lens}
        return Camera(given.pop("eye"), **given)


def rules(select: str) -> dict[str, str]:
    """The colours of a selection, as `Scene.with_colors` takes them."""
    return {f"not ({select})": OTHERS, f"({select})": SELECTED}


def commands(source: Source | None, shot: Shot) -> dict[str, str | None]:
    """The command, ``None`` for a scene that no command can read, and the lines of Python."""
    read = {} if source is None else {**source.options, "keep": None}
    render = dict(shot.options)
    # A corner has the option of the place, which has the right side as its default.
    render["legend_in"] = render.pop("legend", None)
    # Edges that are drawn already are not drawn again.
    drawn = read.get("cell", False) is not False
    edges = render.pop("cell", None)
    render["outline"] = None if drawn else edges
    options = [pair for given in (read, render, shot.renderer) for pair in _options(given)]
    lens = {"aperture": "aperture", "focus": "focus_distance"}
    options += _options({lens[name]: value for name, value in shot.lens.items()})
    frame = None if source is None or source.frame == 1 else source.frame
    request = {
        "camera": shot.pose,
        "size": shot.size,
        "frame": frame,
        "select": shot.select,
    }
    file = None if source is None else fspath(source.path)
    found: dict[str, str | None] = json.loads(
        _halfline.commands(file, options, json.dumps(request))
    )
    return found


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
