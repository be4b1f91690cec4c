"""Keywords of a rendering: their types, and the checks that give them to the native module."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike, fspath
from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import (
    Color,
    array,
    cell_radius,
    color,
    number,
    shown,
    vector,
    whole,
    wholes,
    word,
    words,
)
from ._arrays import size as checked_size

Aov = Literal[
    "color",
    "distance",
    "depth",
    "normal",
    "position",
    "id",
    "mask",
    "certainty",
    "bound",
    "alpha",
    "shadow",
    "occlusion",
]


class Options(TypedDict, total=False):
    """Keywords of `Renderer.render`, `Renderer.render_many` and `Renderer.plan`: the options of
    ``halfline render``.
    """

    size: tuple[int, int] | None
    """Columns and rows; by default those of the camera's intrinsics, else of the scene."""
    aovs: Aov | Iterable[Aov]
    """The buffers; ``id`` is always there. By default ``color``."""
    accuracy: Literal["auto", "fast", "certified", "exact"]
    """The accuracy of the answers; by default what the buffers require."""
    method: str | None
    """One intersection method, uncertified: textbook, unit, geometric, stable, f64,
    double-float.
    """
    tolerance: float | None
    """The allowed relative error of distances; 1e-5 where it is not given."""
    samples: int | None
    """Samples per pixel of color and alpha; all other buffers are those of the pixel's centre. By
    default those of the scene file, else those of the look: 1, 4 for soft, 16 for figure.
    """
    seed: int
    """Seed of the sample positions."""
    shade: Literal["headlight", "flat", "normal"] | None
    """How a hit is shaded."""
    look: Literal["plain", "soft", "figure"] | None
    """Several options in one: soft is 4 samples, silhouette, a sky and a light from above left;
    figure is 16 samples, silhouette and a sky. By default that of the scene file; a scene that was
    read from a file of particles is soft unless shade is given. ``report["look"]`` names it.
    """
    exposure: float
    """Light of pictures in 8 and 16 bits is multiplied by 2 to this power; the buffer color and
    linear files keep it.
    """
    tone: Literal["linear", "soft"] | None
    """Light beyond 1 in pictures in 8 and 16 bits: linear is cut off, soft makes the colour whiter.
    By default soft where lights or a sky light the picture.
    """
    silhouette: bool
    """Whether dark lines are drawn where the depth jumps."""
    outline_width: float | None
    """The width of these lines, 0.1 to 40 pixels, 1.3 by default; below that they become paler
    instead of narrower.
    """
    outline_color: Color | None
    """The colour of these lines; black by default."""
    depth_cue: bool
    """Whether colours fade to the background with depth."""
    layers: int | None
    """So many translucent spheres before the first opaque one are shown, the nearest: 1 to 64, 1 by
    default. ``opacity`` of `read`, or ``opacities`` of `Scene`, makes spheres translucent.
    """
    opacity_shadows: bool
    """Whether translucent spheres block lights and sky as opaque ones do."""
    crop: tuple[int, int, int, int] | None
    """Columns x0 to x1 and rows y0 to y1 of the frame, ends excluded: ``(x0, y0, x1, y1)``."""
    background: Color | None
    """Colour of rays that hit nothing; by default the scene's."""
    transparent: bool
    """Whether the background is transparent: the buffer alpha is there, and .png, .exr and .npz files
    of the color have it.
    """
    sun: ArrayLike
    """White lights infinitely far in these directions, shape (3,) or (n, 3)."""
    shadows: bool
    """Whether lights cast shadows; without a light, one from above left is added."""
    occlusion: bool | int
    """Ambient occlusion: a white sky, with so many rays for each point; ``True`` for those of the
    scene, else 16.
    """
    reach: float | None
    """Spheres farther than this from a point hide nothing of the sky; scene units."""
    bounces: int | None
    """The most bounces of a ray at mirrors and in glass."""
    cryptomatte: str | Iterable[str]
    """Cryptomatte layers in .exr files of the frame: ``"id"``, ``"residue"``, or columns of the
    scene that ``keep`` of `read` keeps, such as ``"chain"`` (see docs/formats.md).
    """
    legend: bool | str | PathLike[str]
    """The legend of the colours of a scene that was read with ``color_by``: ``True`` draws it into
    the picture on the right, ``"top-left"``, ``"top-right"``, ``"bottom-left"``,
    ``"bottom-right"`` in a corner; a file name (.svg, .png) writes it to a file of its own.
    """
    label: str | None
    """A text at the top left of the picture; ``{frame}``, ``{file}``, ``{count}``, ``{time}`` and
    ``{step}`` stand for the frame's number, the file's name, the number of spheres, and the
    frame's time and step.
    """
    mark: Mapping[str, str]
    """Texts at what expressions select, ``{expression: text}``: at each residue, or at each particle
    of files without residues. ``{column}`` in a text stands for the value of a column, which
    ``keep`` of `read` keeps. What is hidden has none.
    """
    mark_all: bool
    """Whether the texts of ``mark`` are also at what is hidden."""
    scale_bar: bool | str
    """A bar of a round length at the bottom left of the picture, with this unit in its label; with
    a perspective camera the length is that at the distance of the middle of all spheres.
    """
    cell: bool | float
    """Whether the edges of the periodic cell are drawn, or the radius of the beads that draw them;
    their ids are ``len(scene)`` and more.
    """
    dtype: Literal["float32", "float64"]
    """The type of the arrays distance, depth and position: float64, or the nearest float32 (ties
    to even; a miss is still +inf or NaN, and so +inf is what exceeds 3.4e38). Files hold float64.
    """


def accuracy_of(accuracy: Any, method: Any, search: Any, tolerance: Any) -> dict[str, Any]:
    return {
        "accuracy": word("accuracy", accuracy),
        "method": None if method is None else word("method", method),
        "search": word("search", search),
        "tolerance": None if tolerance is None else number("tolerance", tolerance),
    }


def checked(options: Options) -> tuple[dict[str, Any], dict[str, Any]]:
    """The options in the types of the native module: those of the picture, and those of the
    accuracy.
    """
    unknown = set(options) - set(Options.__annotations__)
    if unknown:
        names = ", ".join(Options.__annotations__)
        raise TypeError(f"there is no option {sorted(unknown)[0]!r}; choose from {names}")
    given: dict[str, Any] = dict(options)
    size, crop, background, shade, reach, bounces = (
        given.get(name) for name in ("size", "crop", "background", "shade", "reach", "bounces")
    )
    samples, look, tone, layers = (
        given.get(name) for name in ("samples", "look", "tone", "layers")
    )
    width, ink = given.get("outline_width"), given.get("outline_color")
    occlusion = given.get("occlusion", False)
    suns = array("sun", given.get("sun", np.empty((0, 3))), np.float64, "(..., 3)").reshape(-1, 3)
    directions = [vector(f"sun[{k}]", row) for k, row in enumerate(suns)]
    if (0.0, 0.0, 0.0) in directions:
        raise ValueError("a direction of sun is zero; give one that points toward the light")
    transparent = bool(given.get("transparent", False))
    if transparent and background is not None:
        raise ValueError("transparent and background exclude each other; remove one of them")
    if reach is not None and number("reach", reach) <= 0:
        raise ValueError(f"reach is {reach}; give a positive length")
    # 0 takes the number of the scene.
    rays = (
        None
        if occlusion is False
        else 0
        if occlusion is True
        else whole("occlusion", occlusion, 1)
    )
    picture = {
        "aovs": words("aovs", given.get("aovs", "color")),
        "size": None if size is None else checked_size("size", size),
        "samples": None if samples is None else whole("samples", samples, 1),
        "seed": whole("seed", given.get("seed", 0)),
        "shade": None if shade is None else word("shade", shade),
        "look": None if look is None else word("look", look),
        "exposure": number("exposure", given.get("exposure", 0.0)),
        "tone": None if tone is None else word("tone", tone),
        "silhouette": bool(given.get("silhouette", False)),
        "outline_width": None if width is None else number("outline_width", width),
        "outline_color": None if ink is None else color("outline_color", ink),
        "depth_cue": bool(given.get("depth_cue", False)),
        "layers": 0 if layers is None else whole("layers", layers, 1),
        "opacity_shadows": bool(given.get("opacity_shadows", False)),
        "crop": None if crop is None else list(wholes("crop", crop, 4)),
        "background": None if background is None else color("background", background),
        "transparent": transparent,
        "sun": directions,
        "shadows": bool(given.get("shadows", False)),
        "occlusion": rays,
        "reach": None if reach is None else number("reach", reach),
        "bounces": None if bounces is None else whole("bounces", bounces),
        "cell": cell_radius(given.get("cell", False)),
        "cryptomatte": words("cryptomatte", given.get("cryptomatte", ())),
        "insets": _insets(given),
        "single": _is_single(given.get("dtype", "float64")),
    }
    accurate = accuracy_of(
        given.get("accuracy", "auto"),
        given.get("method"),
        "auto",
        given.get("tolerance"),
    )
    return picture, accurate


def _insets(given: dict[str, Any]) -> dict[str, Any]:
    """What is drawn into the picture."""
    legend, label, bar = given.get("legend"), given.get("label"), given.get("scale_bar")
    corner: str | None = None
    file: str | None = None
    if isinstance(legend, bool) or legend is None:
        corner = "right" if legend else None
    elif isinstance(legend, str) and legend in _CORNERS:
        corner = legend
    elif isinstance(legend, (str, PathLike)):
        file = fspath(legend)
        if not isinstance(file, str) or not file.lower().endswith((".svg", ".png")):
            raise ValueError(
                f"legend is {shown(legend)}; give True, one of {', '.join(_CORNERS)}, or a file "
                "name that ends in .svg or .png"
            )
    else:
        raise ValueError(f"legend is {shown(legend)}; give True, a corner or a file name")
    marks = given.get("mark") or {}
    if not isinstance(marks, Mapping):
        raise ValueError(f"mark is {shown(marks)}; give {{expression: text}}")
    if given.get("mark_all") and not marks:
        raise ValueError(
            "mark_all belongs to mark, and there is none; give mark, or remove mark_all"
        )
    if bar is not None and not isinstance(bar, (bool, str)):
        raise ValueError(f"scale_bar is {shown(bar)}; give True, or the unit as a text")
    return {
        "legend": corner,
        "legend_file": file,
        "label": None if label is None else word("label", label),
        "scale_bar": "" if bar is True else bar or None,
        "mark": [(word("mark", key), word(f"mark[{key!r}]", text)) for key, text in marks.items()],
        "mark_all": bool(given.get("mark_all", False)),
    }


_CORNERS = ("right", "top-left", "top-right", "bottom-left", "bottom-right")


def _is_single(dtype: Any) -> bool:
    """Whether lengths are float32."""
    name: str
    try:
        name = np.dtype(dtype).name
    except TypeError:
        name = ""
    if dtype is None or name not in ("float32", "float64"):
        raise ValueError(f"dtype is {shown(dtype)}; give 'float32' or 'float64'")
    return name == "float32"
