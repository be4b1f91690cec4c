"""Keywords of a rendering and their types. The native module checks them, as options of the command."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Literal, TypedDict

from numpy.typing import ArrayLike

from ._arrays import Color

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
