"""The view of a scene in a notebook: `View`, which `Scene.view` makes. Importing it needs
anywidget.
"""

from __future__ import annotations

import base64
import json
import logging
import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _halfline
from ._arrays import shown
from ._shown import Shown
from .camera import Camera

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError(
        "a view needs anywidget and a notebook; install them with pip install 'halfline[jupyter]'"
    ) from None

_LOG = logging.getLogger("halfline")

# What the bars above and below the picture take of the height, pixels.
_BARS = 72

# The widget has the size that its layout says, and the page fills it.
_STYLE = "\n:is(.lm-Widget, .p-Widget, .jupyter-widgets) > .halfline-view { height: 100%; }\n"

Pose = dict[str, Any]


class _Camera(traitlets.TraitType[Pose, "Pose | Camera"]):
    """A pose: eye, at, up, and vfov, height or lens. A `Camera` becomes one."""

    info_text = "a Camera, or a dict of eye, at, up, and vfov, height or lens"

    def validate(self, obj: Any, value: Any) -> Pose:
        try:
            if isinstance(value, Camera):
                return _pose_of(obj._desk, value)
            found: Pose = json.loads(_halfline.pose(json.dumps(value, default=np.ndarray.tolist)))
        except (TypeError, ValueError) as error:
            mend = f"give eye, at, up, and vfov or height: {error}"
            raise traitlets.TraitError(f"camera is {shown(value)}; {mend}") from None
        return found


class _Selection(traitlets.Unicode[str, str]):
    """An expression that selects, or an empty text."""

    def validate(self, obj: Any, value: Any) -> str:
        text = str(super().validate(obj, value)).strip()
        if text:
            try:
                obj._desk.select(text)
            except ValueError as error:
                raise traitlets.TraitError(str(error)) from None
        return text


class View(anywidget.AnyWidget):
    """A scene to turn, pick and select from in a notebook, rendered by the kernel: `Scene.view`
    makes it.

    The page asks for small and quick pictures while the camera moves, and for the picture of
    `Renderer.render` when it rests. It has the hands and keys of ``halfline view``; ``?`` lists
    them, ``p`` copies the lines of Python that render the picture.

    The saved notebook holds the picture of the moment at which the cell was run, for those who
    look at it without a kernel.
    """

    _esm = _halfline.widget_module()
    _css = _halfline.widget_style() + _STYLE

    camera = _Camera().tag(sync=True)
    """The camera: a dict of ``eye``, ``at``, ``up``, and ``vfov`` in degrees or ``height`` in
    scene units. It changes when the camera of the page rests; setting it, also to a `Camera`,
    moves the page.
    """
    picked: traitlets.List[dict[str, Any]] = traitlets.List().tag(sync=True)
    """The spheres that are picked, none, one or two: dicts of ``id``, ``row``, ``center``,
    ``radius``, ``position``, ``distance``, ``certainty``, ``columns`` and ``from``, which has the
    distance from the first to the second.
    """
    selection = _Selection().tag(sync=True)
    """The expression whose spheres are orange, in the words of `Scene.select`; empty for none."""

    _desk: _halfline.Desk
    _still: bytes | None = None

    def __init__(self, given: Shown) -> None:
        width, height = given.size
        self._lens, self._name, self._size = given.lens, given.name, given.size
        self._desk = _halfline.Desk(given)
        super().__init__(
            camera=_pose_of(self._desk, given.camera),
            layout={"width": f"{width}px", "max_width": "100%", "height": f"{height + _BARS}px"},
        )
        self.on_msg(self._receive)

    @property
    def still(self) -> bytes:
        """The last picture at rest, a PNG file: the bytes that `Frame.save` writes for the lines
        that ``p`` copies. It is rendered now, if there is none yet.
        """
        if self._still is None:
            self._still = self._desk.still()
        return self._still

    def to_camera(self) -> Camera:
        """The camera as one of `Renderer.render`."""
        given: Pose = {**self.camera, **self._lens}
        return Camera(given.pop("eye"), **given)

    def close(self) -> None:
        """Takes the view out of the notebook."""
        # One that was refused has none.
        if hasattr(self, "_desk"):
            self._desk.close()
        super().close()

    def __repr__(self) -> str:
        width, height = self._size
        return f"View({self._name}, {width} x {height})"

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        """The widget, and a picture for notebooks without a kernel."""
        bundle = super()._repr_mimebundle_(**kwargs)
        if bundle is None:
            return None
        data, metadata = bundle
        data = {**data, "text/plain": f"{self!r}: run the cell to turn it."}
        try:
            data["image/png"] = base64.b64encode(self.still).decode("ascii")
        except Exception:
            # The page says what is wrong.
            pass
        return data, metadata

    def _receive(self, _: Any, content: Any, buffers: Any) -> None:
        """A message of the page: {id, route, body}. It is answered by another thread."""
        if not isinstance(content, Mapping) or content.get("id") is None:
            return
        question = self._desk.ask(str(content.get("route")), json.dumps(content.get("body")))
        arguments = (content["id"], question)
        threading.Thread(target=self._answer, args=arguments, name="halfline answer").start()

    def _answer(self, name: Any, question: _halfline.Question) -> None:
        while (answer := question.wait()) is None:
            # The interpreter ends, and waits for this thread.
            if not threading.main_thread().is_alive():
                self._desk.close()
        status, text, picture = answer
        found = json.loads(text) if text else None
        try:
            if picture is None:
                self.send({"id": name, "status": status, "json": found})
                return
            if picture.startswith(b"\x89PNG"):
                self._still = picture
            self.send({"id": name, "status": status, "info": found}, [picture])
        except Exception as error:
            # An answer reports its own errors: this is one that could not be sent.
            _LOG.warning("an answer to the view was lost: %r", error)


def _pose_of(desk: _halfline.Desk, camera: Camera) -> Pose:
    found: Pose = json.loads(desk.pose_of(camera._native))
    return found
