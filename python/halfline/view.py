"""The view of a scene in a notebook: `View`, which `Scene.view` makes. Importing it needs
anywidget.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

from . import _halfline
from ._answer import Answer
from ._desk import Desk
from ._pose import pose, pose_of
from ._turns import Turn, Turns
from .camera import Camera

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError(
        "a view needs anywidget and a notebook; install them with pip install 'halfline[jupyter]'"
    ) from None

# What the bars above and below the picture take of the height, pixels.
_BARS = 72

# The widget has the size that its layout says, and the page fills it.
_STYLE = "\n:is(.lm-Widget, .p-Widget, .jupyter-widgets) > .halfline-view { height: 100%; }\n"

Pose = dict[str, Any]


class _Camera(traitlets.TraitType[Pose, "Pose | Camera"]):
    """A pose: eye, at, up, and vfov or height. A `Camera` becomes one."""

    info_text = "a Camera, or a dict of eye, at, up, and vfov or height"

    def validate(self, obj: Any, value: Any) -> Pose:
        try:
            if isinstance(value, Camera):
                return _json(obj._pose_of(value))
            return _json(pose(value))
        except ValueError as error:
            raise traitlets.TraitError(str(error)) from None


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

    _desk: Desk

    def __init__(self, desk: Desk, name: str) -> None:
        self._desk, self._name = desk, name
        # Picks do not wait for a picture.
        self._frames, self._others = Turns("halfline frames"), Turns("halfline answers")
        width, height = desk.size
        super().__init__(
            camera=desk.start,
            layout={"width": f"{width}px", "max_width": "100%", "height": f"{height + _BARS}px"},
        )
        self.on_msg(self._receive)

    @property
    def still(self) -> bytes:
        """The last picture at rest, a PNG file: the bytes that `Frame.save` writes for the lines
        that ``p`` copies. It is rendered now, if there is none yet.
        """
        return self._desk.first()

    def to_camera(self) -> Camera:
        """The camera as one of `Renderer.render`."""
        given: Pose = {**self.camera, **self._desk.lens}
        return Camera(given.pop("eye"), **given)

    def close(self) -> None:
        """Takes the view out of the notebook."""
        for turns in (self._frames, self._others):
            turns.close()
        super().close()

    def __repr__(self) -> str:
        width, height = self._desk.size
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

    def _pose_of(self, camera: Camera) -> Pose:
        return pose_of(camera, self._desk.size, self._desk.summary()["center"])

    def _receive(self, _: Any, content: Any, buffers: Any) -> None:
        """A message of the page: {id, route, body}. It is answered by another thread."""
        if not isinstance(content, Mapping) or content.get("id") is None:
            return
        name, route, body = content["id"], str(content.get("route")), content.get("body")

        def answer(turn: Turn) -> None:
            self._answer(name, self._desk.answer(route, body, turn))

        if route != "/frame":
            self._others.ask(Turn(answer))
            return
        seq = body.get("seq") if isinstance(body, Mapping) else None
        self._frames.ask(
            Turn(
                answer,
                lambda: self._answer(name, Answer(204)),
                seq if isinstance(seq, int) else 0,
            )
        )

    def _answer(self, name: Any, answer: Answer) -> None:
        content: dict[str, Any] = {"id": name, "status": answer.status}
        if answer.picture is None:
            content["json"] = answer.json
            self.send(content)
        else:
            content["info"] = answer.info
            self.send(content, [answer.picture])


def _json(found: Pose) -> Pose:
    """A pose in the types of JSON, so that what the page sends is equal to what is kept."""
    return {
        name: list(value) if isinstance(value, tuple) else value for name, value in found.items()
    }
