"""The lines of Python, and the command, that render a picture of the page again."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np

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


def python(source: Source | None, shot: Shot) -> str:
    """The lines of Python."""
    given = dict(shot.pose)
    camera = _call("hl.Camera", [given.pop("eye")], {**given, **shot.lens})
    renderer = _call("hl.Renderer", [], shot.renderer)
    render = f"{renderer}.render" if shot.renderer else "hl.render"
    scene = "scene" if shot.select is None else "shown"
    lines = ["import halfline as hl", ""]
    if source is None:
        lines.append("# scene is that of the view")
    else:
        lines.append(f"scene = {_call('hl.read', [source.path], source.keywords)}")
    if shot.select is not None:
        lines.append(f"shown = {_call('scene.with_colors', [rules(shot.select)], {})}")
    lines.append(f"camera = {camera}")
    options = {"size": shot.size, **shot.options}
    lines.append(f"frame = {render}({scene}, camera{_keywords(options)})")
    lines.append(f"frame.save({_literal(_output(source))})")
    return "\n".join(lines) + "\n"


def shell(source: Source | None, shot: Shot) -> str | None:
    """The command; ``None`` for a scene that no command can read."""
    if source is None:
        return None
    read, render = dict(source.options), dict(shot.options)
    # The command has one --cell for both.
    if _is_on(read.get("cell")) and _is_on(render.get("cell")):
        return None
    read.pop("keep", None)
    words = list(_options(read))
    if shot.select is not None:
        words += [
            f"--color={selection}={color}" for selection, color in rules(shot.select).items()
        ]
    # A corner has the option of the place, which has the right side as its default.
    render["legend_in"] = render.pop("legend", False)
    words += _options(render)
    words += _options(shot.renderer)
    words += _options({"aperture": None, "focus_distance": None} | _of_lens(shot.lens))
    if source.frame != 1:
        words.append(f"--frames={source.frame}")
    names = {"height": "ortho"}
    words += _options({names.get(name, name): value for name, value in shot.pose.items()})
    words.append(f"--size={shot.size[0]}x{shot.size[1]}")
    file = str(fspath(source.path))
    if file.startswith("-"):
        file = f"./{file}"
    words = ["halfline", "render", file, *words, "-o", _output(source)]
    return " ".join(map(_quoted, words))


def _quoted(word: str) -> str:
    """A word for a POSIX shell; by its bytes where it is not UTF-8."""
    try:
        word.encode()
    except UnicodeEncodeError:
        data = os.fsencode(word)
        return f"\"$(printf %b '{''.join(f'{chr(92)}0{byte:03o}' for byte in data)}')\""
    return shlex.quote(word)


def _of_lens(lens: Mapping[str, float]) -> dict[str, float]:
    names = {"focus": "focus_distance"}
    return {names.get(name, name): value for name, value in lens.items()}


def _output(source: Source | None) -> str:
    """The name of the file that is written: never that of the scene."""
    return f"{'view' if source is None else Path(fspath(source.path)).stem + '-view'}.png"


def _is_on(value: Any) -> bool:
    return value is not None and value is not False


def _options(options: Mapping[str, Any]) -> Iterator[str]:
    """Keywords as options, each one word."""
    for name, value in options.items():
        flag = f"--{name.replace('_', '-')}"
        if not _is_on(value):
            continue
        if value is True:
            yield flag
        elif name == "columns" and isinstance(value, Mapping):
            yield f"{flag}={','.join(f'{meaning}={column}' for meaning, column in value.items())}"
        elif isinstance(value, Mapping):
            yield from (f"{flag}={key}={_word(one)}" for key, one in value.items())
        elif name in ("select", "hide", "clip", "sun"):
            single = isinstance(value, str) or (name == "sun" and np.ndim(value) == 1)
            yield from (f"{flag}={_word(one)}" for one in ([value] if single else value))
        else:
            yield f"{flag}={_word(value)}"


def _word(value: Any) -> str:
    """A value of an option; several have commas between them."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        return str(_plain(value))
    return ",".join(str(_plain(one)) for one in value)


def _call(name: str, values: list[Any], keywords: Mapping[str, Any]) -> str:
    words = ", ".join(map(_literal, values)) + _keywords(keywords)
    return f"{name}({words.removeprefix(', ')})"


def _keywords(keywords: Mapping[str, Any]) -> str:
    return "".join(f", {name}={_literal(value)}" for name, value in keywords.items())


def _plain(value: Any) -> Any:
    """A number of NumPy, or a path, as one of Python."""
    if isinstance(value, np.generic):
        return value.item()
    return fspath(value) if hasattr(value, "__fspath__") else value


def _literal(value: Any) -> str:
    """A value as Python reads it."""
    value = _plain(value)
    if isinstance(value, str):
        # The escapes of JSON are those of Python. Bytes of a name that are not UTF-8 are surrogates.
        return json.dumps(value, ensure_ascii=False).encode("utf-8", "backslashreplace").decode()
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_literal(k)}: {_literal(v)}' for k, v in value.items())}}}"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, tuple):
        return f"({', '.join(map(_literal, value))}{',' * (len(value) == 1)})"
    if isinstance(value, list):
        return f"[{', '.join(map(_literal, value))}]"
    return repr(value)
