"""Parts of scenes that are too large for one process or machine: each keeps what a frame needs of
its spheres, and parts combine to the frame of all.
"""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike, fspath
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _halfline
from ._arrays import Color, array, whole
from ._arrays import color as checked_color
from .camera import Camera, native_camera
from .options import PartOptions

# Spheres that are in memory at a time.
_BLOCK = 1 << 18


class Part:
    """The spheres of a part of a scene that some ray of a frame may hit first.

    A `Sieve` makes it, and `Renderer.render` renders it. ``a | b`` and `combine` give the part of
    both. Whatever parts a scene is divided into, in whatever order and however often they are
    combined, the frame is bit for bit the frame of all spheres in memory. Parts are pickled as the
    bytes of their files, which are NumPy's .npz.

    >>> import functools, operator, pickle
    >>> import halfline as hl, numpy as np
    >>> centers = np.random.default_rng(1).uniform(-1, 1, (3000, 3))
    >>> camera = hl.Camera((0, 0, 5), at=(0, 0, 0))
    >>> view = {"camera": camera, "size": (64, 48)}
    >>> first = hl.sift(centers[:1000], 0.1, **view)
    >>> rest = hl.sift(centers[1000:], 0.1, first_id=1000, **view)
    >>> whole = functools.reduce(operator.or_, [rest, first, pickle.loads(pickle.dumps(rest))])
    >>> whole.count, len(whole) < 1500
    (3000, True)
    >>> renderer = hl.Renderer("cpu")
    >>> frame = renderer.render(whole, aovs="distance")
    >>> all = renderer.render(hl.Scene(centers, 0.1), camera, size=(64, 48), aovs="distance")
    >>> bool((frame["id"] == all["id"]).all() and (frame["distance"] == all["distance"]).all())
    True
    """

    __slots__ = ("_native",)

    _native: _halfline.Part

    @classmethod
    def _of(cls, native: _halfline.Part) -> Part:
        part = cls.__new__(cls)
        part._native = native
        return part

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Part:
        """Reads a file of `save` or of ``halfline sift``.

        Raises:
            OSError: for a file that cannot be read.
            ValueError: for one that is no part, or damaged.
        """
        return cls._of(_halfline.Part.load(fspath(path)))

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the part to an .npz, completely or not at all; ``halfline render --visible`` reads
        it too.
        """
        name = fspath(path)
        if not str(name).lower().endswith(".npz"):
            raise ValueError(f"path is {name!r}; give a file name that ends in .npz")
        self._native.save(name)

    def __or__(self, other: Part) -> Part:
        if not isinstance(other, Part):
            return NotImplemented
        return Part._of(self._native.combine([other._native]))

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return _unpickled, (self._native.bytes(),)

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        return f"Part({self._native.words})"

    @property
    def count(self) -> int:
        """The number of all spheres that the part was made of."""
        return self._native.count

    @property
    def id_ranges(self) -> list[tuple[int, int]]:
        """Their ids, as intervals in order; the ends are excluded."""
        return self._native.all_ids

    @property
    def ids(self) -> NDArray[np.int64]:
        """The ids of the spheres that are left, int64, in increasing order."""
        return self._native.ids

    @property
    def centers(self) -> NDArray[np.float64]:
        """Their centres, float64, shape (n, 3)."""
        return self._native.centers

    @property
    def radii(self) -> NDArray[np.float64]:
        """Their radii, float64."""
        return self._native.radii

    @property
    def colors(self) -> NDArray[np.float32] | None:
        """Their colours, linear RGB, float32, shape (n, 3), where they were given."""
        return self._native.colors

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of the frame."""
        return self._native.size

    @property
    def samples(self) -> int:
        """Samples per pixel of the frame."""
        return self._native.samples


class Sieve:
    """Takes spheres block by block and keeps those that some ray of a frame may hit first.

    The spheres of one sieve have the ids from ``first_id`` on, in the order in which they are
    added. Ids decide ties, so the parts of a scene need ids of their own; the same sphere with the
    same id may be in several parts.

    Args:
        camera: The camera of the frame. All parts need the same one, so it cannot depend on the
            spheres of one part.
        first_id: The id of the first sphere.
        **options: See `PartOptions`; ``size`` is needed.

    >>> import halfline as hl, numpy as np
    >>> sieve = hl.Sieve(hl.Camera((0, 0, 5), at=(0, 0, 0)), (64, 48), first_id=5_000_000_000)
    >>> for z in range(4):
    ...     sieve.add(np.array([[0, 0, -z]]), 1.0)
    >>> sieve.part()
    Part(4 spheres of 4 may be hit first (ids 5000000000 to 5000000003))
    """

    __slots__ = ("_native",)

    def __init__(
        self,
        camera: Camera,
        size: tuple[int, int],
        *,
        first_id: int = 0,
        **options: Unpack[PartOptions],
    ) -> None:
        self._native = _halfline.Sieve(
            native_camera(camera), {**options, "size": size}, whole("first_id", first_id, 0, 2**55)
        )

    def add(self, centers: Any, radii: Any, colors: Any = None, *, opacities: Any = None) -> None:
        """Takes the next spheres.

        Arrays may be NumPy's, memory maps, data sets of h5py and zarr, columns of Arrow, dask
        arrays, or anything else with rows that can be sliced: they are read in blocks, and never
        copied as a whole.

        Args:
            centers: Centres, shape (n, 3), or three columns ``(x, y, z)`` of n numbers.
            radii: Radii, n numbers, or one for all.
            colors: Linear RGB, shape (n, 3), or one colour for all as for `Scene`. Either all
                spheres have colours or none.
            opacities: Opacities in pictures, n numbers, or one for all: above 0, and at most 1.
                Either all spheres have opacities or none.

        Raises:
            ValueError: with the argument, the row and what to give instead.
        """
        columns = centers if isinstance(centers, tuple) and len(centers) == 3 else None
        count = _rows("centers", centers if columns is None else columns[0])
        for name, column in zip("yz", columns[1:] if columns else (), strict=False):
            _same(name, column, count)
        one_radius = _is_number(radii)
        if not one_radius:
            _same("radii", radii, count)
        one_color = colors is not None and _is_color(colors)
        if one_color:
            colors = np.array(checked_color("colors", colors), dtype=np.float32)
        elif colors is not None:
            _same("colors", colors, count)
        one_opacity = opacities is not None and _is_number(opacities)
        if opacities is not None and not one_opacity:
            _same("opacities", opacities, count)
        for rows in _blocks(count):
            block = (
                array("centers", _part(centers, rows), np.float64, "(n, 3)")
                if columns is None
                else _joined([_part(column, rows) for column in columns])
            )
            sizes = np.full(len(block), radii) if one_radius else _part(radii, rows)
            shades = (
                None
                if colors is None
                else np.ascontiguousarray(np.broadcast_to(colors, (len(block), 3)))
                if one_color
                else array("colors", _part(colors, rows), np.float32, "(n, 3)")
            )
            shares = (
                None
                if opacities is None
                else np.full(len(block), opacities, dtype=np.float32)
                if one_opacity
                else array("opacities", _part(opacities, rows), np.float32, "(n,)")
            )
            self._native.add(block, array("radii", sizes, np.float64, "(n,)"), shades, shares)

    def part(self) -> Part:
        """The part of all spheres that were added; it ends the sieve."""
        return Part._of(self._native.part())


def sift(
    centers: Any,
    radii: Any,
    colors: Any = None,
    *,
    opacities: Any = None,
    camera: Camera,
    size: tuple[int, int],
    first_id: int = 0,
    **options: Unpack[PartOptions],
) -> Part:
    """The part of these spheres; see `Sieve`, whose `Sieve.add` says which arrays can be given."""
    sieve = Sieve(camera, size, first_id=first_id, **options)
    sieve.add(centers, radii, colors, opacities=opacities)
    return sieve.part()


def combine(first: Part, *others: Part) -> Part:
    """The part of all spheres of these parts; for two the same as ``first | other``. Many are combined
    faster at once than in pairs.
    """
    for part in (first, *others):
        if not isinstance(part, Part):
            raise TypeError(f"a part is a {type(part).__name__}; give a Part")
    return Part._of(first._native.combine([part._native for part in others]))


def _unpickled(data: bytes) -> Part:
    return Part._of(_halfline.Part.of_bytes(data, "the pickled part"))


def _rows(name: str, values: Any) -> int:
    """The number of rows."""
    shape = getattr(values, "shape", None)
    if shape is not None and len(shape) == 0:
        raise ValueError(f"{name} is one number; give an array of rows")
    try:
        return int(len(values) if shape is None else shape[0])
    except TypeError:
        raise ValueError(f"{name} is a {type(values).__name__}; give an array of rows") from None


def _same(name: str, values: Any, count: int) -> None:
    rows = _rows(name, values)
    if rows != count:
        raise ValueError(f"{name} has {rows} rows, and centers has {count}; give one per sphere")


def _is_number(values: Any) -> bool:
    return isinstance(values, (int, float, np.number)) or getattr(values, "shape", None) == ()


def _is_color(values: Color) -> bool:
    return isinstance(values, str) or (not hasattr(values, "ndim") and np.shape(values) == (3,))


def _blocks(count: int) -> Iterator[slice]:
    return (slice(first, min(first + _BLOCK, count)) for first in range(0, count, _BLOCK))


def _part(values: Any, rows: slice) -> ArrayLike:
    """Some rows, read or computed."""
    # Slices of pandas go by labels, but for iloc.
    return np.asarray(getattr(values, "iloc", values)[rows])


def _joined(columns: list[ArrayLike]) -> NDArray[np.float64]:
    """Three columns as rows."""
    xyz = [
        array(name, column, np.float64, "(n,)")
        for name, column in zip("xyz", columns, strict=True)
    ]
    return np.stack(xyz, axis=-1)
