"""Scenes: spheres from arrays and from files."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from io import BytesIO
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Unpack
from zipfile import ZipFile

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _halfline
from ._arrays import (
    Color,
    Renders,
    array,
    whole,
    word,
)
from ._arrays import color as checked_color
from ._arrays import size as checked_size
from ._shown import Shown
from ._source import Source
from .camera import Camera, native_camera
from .columns import Columns
from .frame import Frame
from .options import Options, Path, ReadOptions, VectorOptions
from .vector import Vector

if TYPE_CHECKING:
    from .page import Page
    from .view import View

# The longer side of the picture in a notebook, pixels.
_PREVIEW = 320


class Scene:
    """Spheres, and the colour of the background.

    Contiguous float64 centers and radii, and contiguous float32 colors, are not copied: the scene
    keeps the arrays, and what is written to them later changes the scene. Do not write to them
    while the scene is rendered. Arrays of other types or in another order are copied once.

    Args:
        centers: Centres, shape (n, 3), in any unit of length; finite.
        radii: Radii in the same unit, shape (n,), or one number for all; positive and finite.
        colors: Linear RGB, shape (n, 3), 0 or more; levels of sRGB from 0 to 255, an array of
            uint8 of shape (n, 3), or (n, 4) with alpha as opacity; CSS names such as ``"red"``
            or ``"#rrggbb"``, one for each; or one colour for all. The default is a light grey.
        opacities: Opacities in pictures, shape (n,), or one for all: above 0, and at most 1, the
            default. No other buffer depends on them.
        values: Numbers that give the colours in place of ``colors``, shape (n,); they are the
            column ``value`` of `Scene.columns`, and of the legend.
        map: The colour map of the values, as for `read`: a name, colours, or a map of matplotlib.
        range: The values at the ends of the map; ``"1%"`` and the like are percentiles.
        legend_title: The title of the legend in place of ``value``.
        background: Colour of rays that hit nothing: linear RGB, a CSS name, or ``"#rrggbb"``.

    Raises:
        ValueError: with the argument, the row and what to give instead.

    >>> import halfline as hl, numpy as np
    >>> centers = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    >>> scene = hl.Scene(centers, 1.0, "tomato")
    >>> scene
    Scene(2 spheres)
    >>> scene.centers is centers or np.shares_memory(scene.centers, centers)
    True
    >>> hl.Scene(centers, [1.0, -1.0])
    Traceback (most recent call last):
    ValueError: radii[1] is -1: radii are positive and finite; remove the sphere or give it a
    radius
    """

    __slots__ = ("_native", "_source")

    def __init__(
        self,
        centers: ArrayLike,
        radii: ArrayLike,
        colors: Color | None = None,
        *,
        opacities: ArrayLike | None = None,
        values: ArrayLike | None = None,
        map: Any = None,
        range: tuple[float | str, float | str] | None = None,
        legend_title: str | None = None,
        background: Color = (0.0, 0.0, 0.0),
    ) -> None:
        points = array("centers", centers, np.float64, "(n, 3)")
        count = len(points)
        sizes = _per_sphere("radii", radii, count, np.float64)
        if values is not None:
            if colors is not None or opacities is not None:
                raise ValueError("values give the colors; give no colors and no opacities")
            given = array("values", values, np.float64, "(n,)")
            columns = {"positions": points, "radius": sizes, "value": given}
            scene = _colored(columns, count, map, range, legend_title)
            self._native = scene.as_arrays(checked_color("background", background))
            self._source: Source | None = None
            return
        if map is not None or range is not None or legend_title is not None:
            raise ValueError(
                "map, range and legend_title are of values; give values, or none of them"
            )
        rows = None if colors is None else _rows(colors, count)
        shares = None
        alpha = _alpha(colors)
        if alpha is not None:
            if opacities is not None:
                raise ValueError("colors has alpha, and opacities is given; give one of them")
            opacities = alpha
        if opacities is not None:
            shares = _per_sphere("opacities", opacities, count, np.float32)
        for name, others in (("radii", sizes), ("colors", rows), ("opacities", shares)):
            if others is not None and len(others) != count:
                raise ValueError(
                    f"{name} has {len(others)} rows, and centers has {count}; give one per sphere"
                )
        self._native = _halfline.Scene(
            points, sizes, rows, shares, checked_color("background", background)
        )
        self._source = None

    @classmethod
    def _of(cls, native: _halfline.Scene, source: Source | None = None) -> Scene:
        scene = cls.__new__(cls)
        scene._native = native
        scene._source = source
        return scene

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        count = len(self)
        columns = "".join(f", {name}" for name in self._native.column_names)
        of_file = f"; columns{columns[1:]}" if columns else ""
        return f"Scene({count} sphere{'' if count == 1 else 's'}{of_file})"

    def _repr_png_(self) -> bytes | None:
        """A small picture for notebooks, by the CPU path; nothing where none can be made."""
        width, height = self.size
        shrink = _PREVIEW / max(width, height)
        size = max(round(width * shrink), 1), max(round(height * shrink), 1)
        try:
            native = _halfline.Renderer("cpu", None)
            return Frame._of(native.render(self._native, None, {"size": size}, None))._repr_png_()
        except Exception:
            # A notebook then shows the text.
            return None

    @property
    def columns(self) -> Columns:
        """What the file says of each sphere: chain, residue, element, any column of the file, as
        arrays in the order of ids.

        ``scene.columns["chain"][ids]`` are the chains of ids that are not -1. Scenes of arrays,
        TOML and NFF have none; `read` says which columns are kept.
        """
        return Columns._of(self._native)

    def select(self, expression: str) -> NDArray[np.bool_]:
        """Which spheres an expression selects, in the words of `read`'s ``select``: shape (n,),
        bool, in the order of ids.

        It reads `columns`, coordinates and radii. A word that selects nothing is a warning.

        Raises:
            ValueError: for an expression with a mistake, or a column that was not kept.

        >>> import halfline as hl
        >>> scene = hl.Scene([[0, 0, 0], [2, 0, 0], [9, 0, 0]], 1.0)
        >>> scene.select("within 3 of (x > 1 and x < 3)")
        array([ True,  True, False])
        """
        mask, notes = self._native.select(word("expression", expression))
        for note in notes:
            warnings.warn(note, stacklevel=2)
        return mask.view(np.bool_)

    def with_colors(self, colors: Color | Mapping[str, Color]) -> Scene:
        """The same spheres in other colours; centres, radii and columns are shared, not copied.

        Args:
            colors: A colour for each sphere, or one for all, as in `Scene`; or
                ``{expression: colour}`` for the spheres that an expression selects, as in `read`.
                The last expression wins, the other spheres keep their colours, and the legend has
                a row for each. ``"element"`` is the colour of each sphere's element.

        Raises:
            ValueError: for colours, or for an expression, with a mistake.

        >>> import halfline as hl
        >>> scene = hl.Scene([[0, 0, 0], [2, 0, 0]], 1.0, "silver")
        >>> scene.with_colors({"x > 1": (1, 0, 0)}).colors[1]
        array([1., 0., 0.], dtype=float32)
        """
        if not isinstance(colors, Mapping):
            count = len(self)
            if _alpha(colors) is not None:
                raise ValueError(
                    "colors has alpha, which is an opacity; give three levels, or a new Scene"
                )
            rows = _rows(colors, count)
            if len(rows) != count:
                raise ValueError(
                    f"colors has {len(rows)} rows, and the scene has {count}; give one per sphere"
                )
            return Scene._of(self._native.with_colors(rows))
        given: Mapping[str, Color] = colors
        rules = [
            (word("colors", key), _paint(f"colors[{key!r}]", value))
            for key, value in given.items()
        ]
        native, notes = self._native.painted(rules)
        for note in notes:
            warnings.warn(note, stacklevel=2)
        return Scene._of(native)

    def view(
        self,
        camera: Camera | None = None,
        *,
        renderer: Renders | None = None,
        **options: Unpack[Options],
    ) -> View:
        """A view to turn, pick and select from in a notebook. It needs anywidget: ``pip install
        'halfline[jupyter]'``.

        Args:
            camera: The camera with which it begins; by default the file's, else one that shows all
                spheres.
            renderer: What renders; by default one `Renderer` for all views.
            **options: Options of `Renderer.render`. ``size`` is the size of the view in the
                notebook, 640 x 480 by default; ``aovs``, ``crop`` and ``dtype`` are left out, since
                a view shows whole pictures.

        Returns:
            The `halfline.view.View`, a widget with the traits ``camera``, ``picked`` and
            ``selection``.

        Raises:
            ImportError: without anywidget.
            ValueError: for options, or a camera, with a mistake.
        """
        from .view import View

        return View(self._shown(camera, renderer, options, "a view"))

    def page(
        self,
        camera: Camera | None = None,
        *,
        columns: Iterable[str] = (),
        title: str | None = None,
        caption: str | None = None,
        renderer: Renders | None = None,
        **options: Unpack[Options],
    ) -> Page:
        """A page in one file that shows the scene in any browser, without a server and without
        Python: to turn, to pick and to select from.

        Args:
            camera: The camera with which it begins; by default the file's, else one that shows all
                spheres.
            columns: Further columns that it has of each sphere, by the words of `Scene.select`: what
                a pick shows, and what its selections read. It has chain, residue, name and
                element, and what options name, where the scene has them.
            title: The title of the page; by default the name of the file.
            caption: The caption below the picture.
            renderer: What renders the picture for browsers that cannot run the page; by default
                one `Renderer` for all pages.
            **options: Options of `Renderer.render`. ``size`` is the size of the page in a
                notebook, 640 x 480 by default; ``aovs``, ``crop`` and ``dtype`` are left out, since
                a page shows whole pictures.

        Returns:
            The `halfline.page.Page`: ``page.save("figure.html")`` writes it, and a notebook shows it.

        Raises:
            KeyError, ValueError: for options, a camera or a column with a mistake, and for a
                package that was built without the program of pages.
        """
        from .page import Page

        return Page(self._shown(camera, renderer, options, "a page"), columns, title, caption)

    def _shown(
        self, camera: Camera | None, renderer: Renders | None, options: Options, thing: str
    ) -> Shown:
        return Shown.of(self._native, self._source, camera, renderer, options, repr(self), thing)

    @property
    def centers(self) -> NDArray[np.float64]:
        """Centres, shape (n, 3), float64, scene units; read-only, without a copy."""
        return self._native.centers

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii, shape (n,), float64, scene units; read-only, without a copy."""
        return self._native.radii

    @property
    def colors(self) -> NDArray[np.float32] | None:
        """Linear RGB, shape (n, 3), float32, read-only; ``None`` where no sphere has a colour."""
        return self._native.colors

    @property
    def opacities(self) -> NDArray[np.float32] | None:
        """Opacities in pictures, shape (n,), float32, read-only; ``None`` where all spheres are opaque."""
        return self._native.opacities

    @property
    def camera(self) -> Camera:
        """The camera of the file, or one that looks along -z and shows all spheres."""
        return Camera._of(self._native.camera(None), None)

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of the image: the file's, else 512 x 512."""
        return self._native.size

    @property
    def background(self) -> tuple[float, float, float]:
        """Linear RGB of rays that hit nothing."""
        return self._native.background

    @property
    def warnings(self) -> list[str]:
        """What the reader left out or assumed, in whole sentences."""
        return self._native.warnings

    @property
    def number(self) -> int:
        """The frame's number in its file, from 1."""
        return self._native.number

    @property
    def time(self) -> float | None:
        """The time of the frame: picoseconds for GRO, XTC, TRR and DCD; ``None`` where the file
        has none.
        """
        return self._native.time

    @property
    def step(self) -> int | None:
        """The step of the simulation; ``None`` where the file has none."""
        return self._native.step

    @property
    def cell(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Origin (3,) and edges (3, 3) of the periodic cell, scene units; ``None`` where the file
        has none.
        """
        found = self._native.cell
        return None if found is None else (np.array(found[0]), np.array(found[1]))

    def vector(self, camera: Camera | None = None, **options: Unpack[VectorOptions]) -> Vector:
        """A figure without pixels: the visible part of every sphere as a path of arcs, as
        ``halfline render -o FILE.svg``. What only pixels show, such as shadows and opacity, is
        refused.

        Args:
            camera: The camera; by default the scene's.
            **options: Keywords of a rendering, ``group``, ``detail`` and ``dpi``.

        Raises:
            ValueError: for spheres around the eye or across its plane, and for options that a
                figure cannot show.

        >>> scene = Scene([[0, 0, 0], [1, 0.5, 0]], 1.0)
        >>> figure = scene.vector(size=(200, 150), shade="flat")
        >>> figure.paths
        2
        """
        return Vector(self._native, camera, options)

    def save(self, path: Path, camera: Camera | None = None) -> None:
        """Writes the spheres as a model: points with radii and colours, for Blender and other
        programs, as ``halfline render -o FILE.glb``.

        Args:
            path: The file, a .glb.
            camera: The camera that the file has; by default the scene's.

        Raises:
            OSError: if the file cannot be written.
            ValueError: for another extension, and for lengths beyond float32.
        """
        native = None if camera is None else native_camera(camera)
        for warning in self._native.save(fspath(path), native):
            warnings.warn(warning, stacklevel=2)

    def fingerprint(self) -> str:
        """32 hexadecimal digits, equal for equal numbers; files of frames hold it."""
        return self._native.fingerprint()


def _per_sphere(name: str, values: ArrayLike, count: int, dtype: type) -> NDArray[Any]:
    """A number for each sphere."""
    numbers = np.asarray(values)
    if numbers.ndim == 0 and numbers.dtype.kind in "fiu":
        numbers = np.full(count, numbers, dtype=dtype)
    return array(name, numbers, dtype, "(n,)")


def _rows(colors: Color, count: int) -> NDArray[np.float32]:
    """A colour for each sphere."""
    if isinstance(colors, str):
        return np.tile(np.array(checked_color("colors", colors), np.float32), (count, 1))
    given = _given(colors)
    if given.dtype.kind in "UO" and given.ndim == 1 and all(isinstance(x, str) for x in given):
        names, places = np.unique(given.astype(str), return_inverse=True)
        return np.array([checked_color("colors", str(name)) for name in names], np.float32)[places]
    if given.dtype == np.uint8 and given.shape == (3,):
        return np.tile(_linear()[given], (count, 1))
    if given.dtype == np.uint8 and given.ndim == 2 and given.shape[1] in (3, 4):
        rows: NDArray[np.float32] = _linear()[given[:, :3]]
        return rows
    if given.shape == (3,):
        return np.tile(np.array(checked_color("colors", given), np.float32), (count, 1))
    if given.ndim == 2 and given.shape[1] == 4:
        raise ValueError(
            f"colors has the shape {given.shape}; give linear RGB, or the levels of sRGB with "
            "alpha as an array of uint8; a map of matplotlib gives them by map(values, bytes=True)"
        )
    return array("colors", colors, np.float32, "(n, 3)")


def _alpha(colors: Color | None) -> NDArray[np.float32] | None:
    """The opacities in the alpha of levels; None where all are opaque."""
    given = _given(colors)
    if given.dtype != np.uint8 or given.ndim != 2 or given.shape[1] != 4:
        return None
    alpha = given[:, 3]
    return None if bool((alpha == 255).all()) else alpha.astype(np.float32) / np.float32(255)


def _given(colors: Color | None) -> NDArray[Any]:
    """The colours as an array; an empty one where they are none."""
    try:
        return np.asarray(colors)
    except ValueError:
        return np.empty(0)


@cache
def _linear() -> NDArray[np.float32]:
    """Linear light of the levels of sRGB from 0 to 255."""
    return np.array([_halfline.color(f"#{level:02x}0000")[0] for level in range(256)], np.float32)


def _colored(
    columns: Mapping[str, NDArray[Any]], count: int, map: Any, range: Any, title: str | None
) -> _halfline.Scene:
    """The spheres of columns of arrays, coloured by the column ``value``."""
    for name, values in columns.items():
        if len(values) != count:
            raise ValueError(
                f"{name}s has {len(values)} rows, and centers has {count}; give one per sphere"
            )
    options: ReadOptions = {"color_by": "value"}
    if map is not None:
        options["map"] = map
    if range is not None:
        options["range"] = range
    if title is not None:
        options["legend_title"] = title
    return read(columns, keep=True, **options)._native


def _archive(columns: Mapping[str, ArrayLike]) -> bytes:
    """The .npz of arrays by their names."""
    buffer = BytesIO()
    with ZipFile(buffer, "w") as archive:
        for name, values in columns.items():
            rows = np.asarray(values)
            if rows.dtype.kind == "O":
                rows = rows.astype(str)
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, rows, allow_pickle=False)
    return buffer.getvalue()


def read(
    path: Path | Mapping[str, ArrayLike],
    *,
    frame: int = 1,
    size: tuple[int, int] | None = None,
    keep: bool | str | Iterable[str] | None = None,
    **options: Unpack[ReadOptions],
) -> Scene:
    """Reads one scene. The keywords are the options of ``halfline render``, with underscores.

    Args:
        path: A scene or particle file (TOML, NFF, XYZ, PDB, mmCIF, GRO, LAMMPS, PLY, CSV, NumPy,
            XTC, LAS ...), also compressed with gzip, bzip2, xz or
            Zstandard; see docs/reading.md. Or arrays by their names, as an .npz has them:
            ``{"positions": xyz, "radius": r, "charge": q}``.
        frame: The frame of a sequence, from 1.
        size: Columns and rows of the image for which the camera is framed; by default the
            file's, else 512 x 512.
        keep: The columns in `Scene.columns`: ``True`` for all, names or words of selections such
            as ``["speed"]``, ``False`` for none. By default all of a molecule (PDB, PQR, PDBQT,
            mmCIF, GRO, also as the topology of a trajectory), which takes some 40 bytes per atom,
            and of other files those that colours and selections read, 8 bytes per number.
        **options: See `ReadOptions`.

    Raises:
        OSError: if the file cannot be read.
        ValueError: with the file, the line or byte, the problem and the mend; and for wrong
            options.
        MemoryError: if the scene does not fit into memory.
        KeyboardInterrupt: ctrl-C, within a second.
    """
    number = whole("frame", frame, 1)
    native, given = _sequence(path, str(number), size, False, keep, options)
    source = None if isinstance(path, Mapping) else Source(path, number, given)
    return Scene._of(next(native), source)


def read_frames(
    path: Path,
    frames: str = "1-",
    *,
    size: tuple[int, int] | None = None,
    keep: bool | str | Iterable[str] | None = None,
    **options: Unpack[ReadOptions],
) -> Iterator[Scene]:
    """The frames of a sequence, one after the other; at most one is in memory.

    All of them have the camera, the default radii and the range of colours of the first frame of
    the file, so that a film does not jitter; ``hold="none"`` takes each frame's own.

    Args:
        path: The file.
        frames: The frames, counted from 1: ``"2"``, ``"1-10"``, ``"1-3,5,7-20:2"``, ``"5-"`` to
            the last.
        size: Columns and rows of the images for which the camera is framed.
        keep: As for `read`.
        **options: See `ReadOptions`.

    Raises:
        As `read`.
    """
    natives, given = _sequence(path, word("frames", frames), size, True, keep, options)
    return (Scene._of(native, Source(path, native.number, given)) for native in natives)


def _sequence(
    path: Path | Mapping[str, ArrayLike],
    frames: str,
    size: tuple[int, int] | None,
    holds: bool,
    keep: Any,
    options: ReadOptions,
) -> tuple[_halfline.Sequence, dict[str, Any]]:
    """The frames, and the keywords by which they are read."""
    # An iterator is gone once it was read.
    given = {
        name: list(value) if isinstance(value, Iterator) else value
        for name, value in options.items()
    }
    archive = _archive(path) if isinstance(path, Mapping) else None
    file = "arrays.npz" if isinstance(path, Mapping) else fspath(path)
    image = None if size is None else checked_size("size", size)
    map, colors = _map(given.get("map"))
    words = {**given, "map": map}
    sequence = _halfline.Sequence(file, archive, words, keep, colors, frames, image, holds)
    return sequence, given


def _paint(name: str, value: Color) -> tuple[float, float, float] | str:
    """Linear RGB, or a name: a CSS colour, or ``"element"`` for the colour of each one's element."""
    return value if isinstance(value, str) else checked_color(name, value)


def _map(value: Any) -> tuple[Any, NDArray[np.uint8] | None]:
    """The name or file of a colour map; or any name and colours in its place, uint8, shape (n, 3)."""
    if value is None or isinstance(value, (str, PathLike)):
        return value, None
    # A colormap of matplotlib gives RGBA between 0 and 1.
    given = np.asarray(value(np.linspace(0, 1, 256)) if callable(value) else value)
    if given.ndim != 2 or given.shape[1] not in (3, 4) or given.dtype.kind not in "fu":
        raise ValueError(
            f"map has the shape {given.shape} and the dtype {given.dtype}; "
            "give a name, a file, or colours of shape (n, 3), float from 0 to 1 or uint8"
        )
    levels = given[:, :3] * 255 if given.dtype.kind == "f" else given[:, :3]
    if not ((levels >= 0) & (levels <= 255)).all():
        raise ValueError("map has colours beyond 0 and 1; give sRGB from 0 to 1, or uint8")
    colors: NDArray[np.uint8] = np.rint(levels).astype(np.uint8)
    return "grays", colors
