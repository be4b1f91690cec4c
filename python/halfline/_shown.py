"""The scene and the options of pictures that a page shows: of a notebook's view, and of a file."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from os import fspath
from typing import Any

from . import _halfline
from ._arrays import Renders, native_renderer
from ._arrays import size as checked_size
from ._source import Source
from .camera import Camera, native_camera
from .options import Options


@functools.cache
def _usual_renderer() -> _halfline.Renderer:
    """The renderer of all pages that are given none: opening a device takes time."""
    return _halfline.Renderer("auto", None)


@dataclass
class Shown:
    """What a page shows, checked."""

    scene: _halfline.Scene
    name: str
    renderer: _halfline.Renderer
    camera: Camera
    size: tuple[int, int]
    options: dict[str, Any]
    lens: dict[str, float]
    origin: dict[str, Any]

    @property
    def native_camera(self) -> _halfline.Camera:
        """The camera, for the native module."""
        return self.camera._native

    @staticmethod
    def of(
        scene: _halfline.Scene,
        source: Source | None,
        camera: Camera | None,
        renderer: Renders | None,
        options: Options,
        name: str,
        thing: str,
    ) -> Shown:
        """The options of `Renderer.render` for a scene of this name and a `thing` such as
        ``a view``.
        """
        given: dict[str, Any] = dict(options)
        for refused in ("aovs", "crop", "dtype"):
            if refused in given:
                raise ValueError(f"{thing} shows whole pictures in colour; remove {refused}")
        legend = given.get("legend")
        if not (legend is None or isinstance(legend, bool) or "." not in str(legend)):
            raise ValueError(f"{thing} writes no files; give legend=True or a corner")
        size = checked_size("size", given.pop("size", None) or (640, 480))
        if camera is None:
            camera = Camera._of(scene.camera(size), None)
        # A TypeError for anything else.
        native_camera(camera)
        record = camera.record(size if camera.size is None else None)
        lens = {name: record[name] for name in record if name in ("aperture", "focus")}
        choosing: dict[str, str] = {}
        native = _usual_renderer() if renderer is None else native_renderer(renderer)
        if renderer is not None:
            # On one machine the name of an adapter is enough to find it again.
            choosing = {"adapter": renderer.adapter} if renderer.is_gpu else {"backend": "cpu"}
        reading = {} if source is None else source.options
        origin = {
            "file": None if source is None else fspath(source.path),
            "reading": {name: value for name, value in reading.items() if name != "keep"},
            "renderer": choosing,
        }
        return Shown(scene, name, native, camera, size, given, lens, origin)
