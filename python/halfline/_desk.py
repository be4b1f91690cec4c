"""What the page of a view asks, answered. It knows no notebook; see `view`."""

from __future__ import annotations

import functools
import json
import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _halfline
from ._answer import NOTHING, Answer, error, refusal
from ._arrays import Renders, color, native_renderer, shown, whole, word
from ._arrays import size as checked_size
from ._lines import Shot, commands, rules
from ._pose import pose, pose_of
from ._source import Source
from ._turns import Superseded, Turn
from .camera import Camera
from .frame import Frame
from .options import Options, checked

# What a view does not take: it shows whole pictures, and writes no file.
_REFUSED = ("aovs", "crop", "dtype")

# Options of the light and of what is drawn, which a moving picture leaves out.
_RESTING = (
    "samples",
    "look",
    "silhouette",
    "sun",
    "shadows",
    "occlusion",
    "reach",
    "bounces",
    "legend",
    "label",
    "scale_bar",
)


@functools.cache
def _usual_renderer() -> _halfline.Renderer:
    """The renderer of all views that are given none: opening a device takes time."""
    return _halfline.Renderer("auto", None)


@dataclass(slots=True)
class Desk:
    """A scene, what renders it, and how."""

    scene: _halfline.Scene
    source: Source | None
    renderer: _halfline.Renderer
    options: Mapping[str, Any]
    """Those of `Renderer.render` without the size."""
    size: tuple[int, int]
    lens: Mapping[str, float]
    """Aperture and focus of the camera, if its lens has a size."""
    start: dict[str, Any]
    """The pose with which the view begins."""
    named: Mapping[str, str]
    """The arguments of the renderer in the lines that are copied."""
    picker: _halfline.Renderer = field(default_factory=lambda: _halfline.Renderer("cpu", None))
    still: bytes | None = None
    """The last still picture, a PNG file."""
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _painted: tuple[str, _halfline.Scene, int, list[str]] | None = None
    _moving: tuple[_halfline.Scene, _halfline.Scene] | None = None
    _summary: dict[str, Any] = field(default_factory=dict[str, Any])

    @classmethod
    def of(
        cls,
        scene: _halfline.Scene,
        source: Source | None,
        camera: Camera | None,
        renderer: Renders | None,
        options: Options,
    ) -> Desk:
        """Checks what a view is given."""
        given: dict[str, Any] = dict(options)
        for name in _REFUSED:
            if name in given:
                raise ValueError(f"a view shows whole pictures in colour; remove {name}")
        size = checked_size("size", given.pop("size", None) or (640, 480))
        legend = given.get("legend")
        if not (legend is None or isinstance(legend, bool) or "." not in str(legend)):
            raise ValueError("a view writes no files; give legend=True or a corner")
        chosen: Any = given
        picture, _ = checked(chosen)
        if camera is None:
            camera = Camera._of(scene.camera(size), None)
        elif not isinstance(camera, Camera):
            raise TypeError(f"camera is a {type(camera).__name__}; give a Camera")
        named: dict[str, str] = {}
        native = _usual_renderer() if renderer is None else native_renderer(renderer)
        if renderer is not None:
            # On one machine the name of an adapter is enough to find it again.
            named = {"adapter": renderer.adapter} if renderer.is_gpu else {"backend": "cpu"}
        summary: dict[str, Any] = json.loads(_halfline.summary(scene, picture))
        record = camera.record(size if camera.size is None else None)
        return cls(
            scene,
            source,
            native,
            given,
            size,
            {name: record[name] for name in ("aperture", "focus") if name in record},
            pose_of(camera, size, summary["center"]),
            named,
            _summary=summary,
        )

    def answer(self, route: str, body: Any, turn: Turn) -> Answer:
        """The answer to a request, also to one with a mistake."""
        routes: dict[str, Callable[[Mapping[str, Any], Turn], Any]] = {
            "/scene": lambda body, turn: self.summary(),
            "/progress": lambda body, turn: {"state": "ready", "text": ""},
            "/frame": self._frame,
            "/pick": lambda body, turn: self.pick(body),
            "/select": lambda body, turn: self.select(body.get("expr")),
            "/command": lambda body, turn: self.command(body),
        }
        ask = routes.get(route)
        if ask is None:
            return Answer(404, error("settings", 2, f"there is nothing at {shown(route)}"))
        if not isinstance(body, Mapping):
            return Answer(400, error("settings", 2, "the request is not valid: give an object"))
        try:
            found = ask(body, turn)
        except Superseded:
            return NOTHING
        except Exception as problem:
            return refusal(problem)
        return found if isinstance(found, Answer) else Answer(200, found)

    def summary(self) -> dict[str, Any]:
        """What is known about the scene."""
        summary = self._summary
        return {
            "schema": 1,
            "version": _halfline.__version__,
            **summary,
            "file": summary["file"] or "scene",
            "legend": _halfline.legend(self.scene),
            "format": None,
            "frames": 1,
            "camera": self.start,
            "size": self.size,
            "selects": True,
            "warnings": self.scene.warnings,
        }

    def _frame(self, body: Mapping[str, Any], turn: Turn) -> Answer:
        begin = time.perf_counter()
        is_move = body.get("mode") == "move"
        shot = self.shot(body)
        frame = self.moving(shot) if is_move else self.render(shot, turn)
        if is_move:
            picture = _halfline.jpeg(np.ascontiguousarray(frame.image))
        else:
            picture = self.still = frame.to_png()
        report, pose = frame.report, shot.pose
        seen = pose.get("height") or 2 * math.tan(math.radians(pose["vfov"]) / 2) * math.dist(
            pose["eye"], pose["at"]
        )
        names = ("accuracy", "certified", "settled", "adapter", "look", "samples", "warnings")
        info = {
            "seq": body.get("seq", 0),
            "ms": round((time.perf_counter() - begin) * 1e3, 2),
            "unit": seen / shot.size[1],
            **{name: report.get(name) for name in names},
        }
        return Answer(200, info=info, picture=picture)

    def shot(self, body: Mapping[str, Any]) -> Shot:
        """The picture of a request."""
        options = dict(self.options)
        if body.get("look") is not None:
            options["look"] = word("look", body["look"])
        if body.get("samples") is not None and body.get("mode") != "move":
            options["samples"] = whole("samples", body["samples"], 1)
        select = body.get("select")
        return Shot(
            pose(body.get("camera")),
            self.lens,
            checked_size("size", body.get("size")),
            options,
            None if select is None else word("select", select),
            self.named,
        )

    def render(self, shot: Shot, turn: Turn | None = None) -> Frame:
        """A picture as it is copied, unless a newer one is wanted."""
        options = {**shot.options, "size": shot.size}
        stop = None if turn is None else turn.check
        return _frame(self.renderer, self._shown(shot.select), shot.camera, options, stop)

    def moving(self, shot: Shot) -> Frame:
        """A picture by one ray for each pixel, lit from the eye."""
        shown_now = self._shown(shot.select)
        with self._lock:
            if self._moving is None or self._moving[0] is not shown_now:
                self._moving = shown_now, _halfline.with_light_at_the_eye(shown_now)
            scene = self._moving[1]
        options = {name: value for name, value in shot.options.items() if name not in _RESTING}
        options |= {"size": shot.size, "look": "plain", "samples": 1}
        return _frame(self.renderer, scene, _pinhole(shot), options)

    def first(self) -> bytes:
        """The last still picture, or that with which the view begins."""
        if self.still is None:
            shot = self.shot({"camera": self.start, "size": self.size})
            self.still = self.render(shot).to_png()
        return self.still

    def pick(self, body: Mapping[str, Any]) -> dict[str, Any] | None:
        """The sphere at a pixel: its id is that of the buffer ``id``."""
        shot = self.shot({**body, "look": None, "samples": None})
        x, y = whole("x", body.get("x")), whole("y", body.get("y"))
        origin = None if body.get("from") is None else whole("from", body["from"])
        options = {
            **{name: shot.options[name] for name in ("cell", "tolerance") if name in shot.options},
            "size": shot.size,
            "crop": (x, y, x + 1, y + 1),
            "aovs": ["id", "distance", "position", "certainty"],
            "accuracy": "certified",
        }
        frame = _frame(self.picker, self.scene, _pinhole(shot), options)
        found = int(frame["id"][0, 0])
        # Beads that draw the edges of a cell are no spheres of the scene.
        if not 0 <= found < len(self.scene):
            return None
        picked: dict[str, Any] = json.loads(_halfline.describe(self.scene, found))
        picked["position"] = frame["position"][0, 0].tolist()
        picked["distance"] = float(frame["distance"][0, 0])
        picked["certainty"] = "settled" if frame["certainty"][0, 0] == 1 else "certified"
        picked["from"] = None
        apart = None if origin is None else _halfline.apart(self.scene, origin, found)
        if apart is not None:
            picked["from"] = {"id": origin, "distance": apart[0], "minimum_image": apart[1]}
        return picked

    def select(self, expression: Any) -> dict[str, Any]:
        """How many spheres an expression selects."""
        _, painted, count, notes = self._paint(word("expr", expression))
        legend = _halfline.legend(painted)
        of = self._summary["count"]
        return {"count": count, "of": of, "legend": legend, "notes": notes}

    def command(self, body: Mapping[str, Any]) -> dict[str, Any]:
        """The lines that render the picture of a request again."""
        shot = self.shot({**body, "mode": "still"})
        return commands(self.source, shot)

    def _shown(self, select: str | None) -> _halfline.Scene:
        """The scene in the colours of a selection."""
        return self._paint(select)[1] if select else self.scene

    def _paint(self, select: str) -> tuple[str, _halfline.Scene, int, list[str]]:
        with self._lock:
            if self._painted is None or self._painted[0] != select:
                mask, notes = self.scene.select(select)
                # What is said about these is what is said about the mask.
                colors = [(text, color("", name)) for text, name in rules(select).items()]
                painted, _ = _halfline.painted(self.scene, colors)
                count = int(np.count_nonzero(mask[: self._summary["count"]]))
                self._painted = select, painted, count, notes
            return self._painted


def _frame(
    renderer: _halfline.Renderer,
    scene: _halfline.Scene,
    camera: Camera,
    options: Mapping[str, Any],
    progress: _halfline.Report | None = None,
) -> Frame:
    """The frame of `Renderer.render`, which this module cannot import: it is below `Scene`."""
    given: Any = options
    picture, accurate = checked(given)
    return Frame._of(renderer.render(scene, camera._native, picture, accurate, progress))


def _pinhole(shot: Shot) -> Camera:
    given = dict(shot.pose)
    return Camera(given.pop("eye"), **given)
