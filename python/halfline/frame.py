"""Frames: buffers as arrays, a report, files, pictures in notebooks."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping
from importlib import import_module
from os import PathLike
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from . import _halfline
from ._arrays import words
from ._colors import picture
from .options import SaveOptions


class _NoBufferError(KeyError, ValueError):
    """A name that no buffer has: a missing key, and a wrong argument."""


class Frame(Mapping[str, NDArray[Any]]):
    """A rendered frame: a mapping from the names of buffers to arrays. Row 0 is the top row.

    ``frame["depth"]`` is a buffer as an array. Arrays are read-only, since they are the memory
    that `save` writes; an array keeps the memory as long as it lives, and ``.copy()`` gives one to
    write to. With ``dtype="float32"`` distance, depth and position are arrays of the nearest
    float32 instead, which are made once.

    ========= ========= ======= ==================================================== ============
    buffer    shape     dtype   meaning                                              on a miss
    ========= ========= ======= ==================================================== ============
    color     (H, W, 3) float32 shaded colour, linear RGB                            background
    distance  (H, W)    float64 length from the ray's origin to the hit, scene units +inf
    depth     (H, W)    float64 distance along the view axis, scene units            +inf
    normal    (H, W, 3) float32 unit normal in world space, against the ray          0, 0, 0
    position  (H, W, 3) float64 hit point in world space, scene units                NaN
    id        (H, W)    int32   index of the sphere; always there                    -1
    mask      (H, W)    uint8   1 hit, 0 miss                                        0
    certainty (H, W)    uint8   0 certified in float32, 1 settled, 255 neither       as its pixel
    bound     (H, W)    float64 proven bound of the distance's error, scene units    0
    alpha     (H, W)    float32 share of the pixel's samples that hit                0
    shadow    (H, W, L) float32 share of each of L lights that is hidden             0
    occlusion (H, W)    float32 share of the sky that is open                        1
    ========= ========= ======= ==================================================== ============
    """

    __slots__ = ("_native", "_report")

    _native: _halfline.Frame
    _report: dict[str, Any] | None

    # A mapping compares values, and a comparison of arrays has no single truth.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __init__(self) -> None:
        raise TypeError("a Frame is made by Renderer.render")

    @classmethod
    def _of(cls, native: _halfline.Frame) -> Frame:
        frame = cls.__new__(cls)
        frame._native = native
        frame._report = None
        return frame

    def __getitem__(self, name: str) -> NDArray[Any]:
        if not isinstance(name, str):
            raise TypeError(f"a buffer is named by a text such as 'depth', not by {name!r}")
        try:
            return self._native.array(name)
        except ValueError as error:
            raise _NoBufferError(str(error)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._native.names

    def __iter__(self) -> Iterator[str]:
        return iter(self._native.names)

    def __len__(self) -> int:
        return len(self._native.names)

    def __repr__(self) -> str:
        width, height = self.size
        return f"Frame({width} x {height}: {', '.join(self)})"

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of the part that was rendered."""
        return self._native.size

    @property
    def report(self) -> dict[str, Any]:
        """Adapter, method, times, counts, camera and warnings, as ``halfline render --json`` prints
        them.
        """
        report = self._report
        if report is None:
            report = self._report = dict[str, Any](json.loads(self._native.report()))
        return report

    @property
    def warnings(self) -> list[str]:
        """The warnings of the report."""
        warnings: list[str] = self.report["warnings"]
        return warnings

    @property
    def image(self) -> NDArray[np.uint8]:
        """The picture in 8-bit sRGB, shape (H, W, 3), uint8, in an array of its own, with legend,
        label and scale bar; needs the buffer color.
        """
        return self._native.image()

    def picture(self, name: str | None = None) -> NDArray[np.uint8]:
        """A buffer as a picture, shape (H, W, 3), uint8: color as it is, lengths near to far from
        light to dark, a colour
        for each id, normals as (n + 1) / 2; misses of lengths and ids are black. By default color,
        else the first buffer besides id.

        >>> import halfline as hl
        >>> frame = hl.Renderer("cpu").render(hl.Scene([[0, 0, 0]], 1.0), size=(4, 4),
        ...     aovs="depth")
        >>> frame.picture("depth").shape
        (4, 4, 3)
        """
        if name is None:
            name = (
                "color"
                if "color" in self
                else next((other for other in self if other != "id"), "id")
            )
        return self.image if name == "color" else picture(name, self[name])

    def save(
        self,
        path: str | PathLike[str],
        *,
        aovs: str | list[str] | None = None,
        **options: Unpack[SaveOptions],
    ) -> None:
        """Writes a file, completely or not at all, with the provenance of the frame.

        Legend, label and scale bar are in the color of pictures. Numbers are those that were
        computed: float64, also with ``dtype="float32"``.

        Args:
            path: The file; its extension is the format: .png, .exr, .npy, .npz, .pfm, .tif,
                .jpg, .webp (see docs/formats.md).
            aovs: The buffers; by default color for .png and .npy, or the only other buffer, and
                all for .exr and .npz.
            **options: See `SaveOptions`.

        Raises:
            OSError: if the file cannot be written.
            ValueError: if the format cannot hold the buffers.
        """
        for warning in self._native.save(path, _names(aovs), dict(options)):
            warnings.warn(warning, stacklevel=2)

    def to_png(
        self, *, aovs: str | list[str] | None = None, **options: Unpack[SaveOptions]
    ) -> bytes:
        """The bytes that `save` writes to a .png file with the same arguments.

        Raises:
            ValueError: if PNG cannot hold the buffers.

        >>> import halfline as hl
        >>> frame = hl.Renderer("cpu").render(hl.Scene([[0, 0, 0]], 1.0), size=(4, 4))
        >>> frame.to_png()[:4]
        b'\\x89PNG'
        """
        encoded, found = self._native.encode(_names(aovs), dict(options))
        for warning in found:
            warnings.warn(warning, stacklevel=2)
        return encoded

    def show(self, name: str | None = None) -> None:
        """Shows a buffer in a notebook, or with matplotlib or Pillow in a window; see
        `picture`.
        """
        pixels = self.picture(name)
        try:
            display: Any = import_module("IPython.display")
            shell = import_module("IPython").get_ipython()
        except ImportError:
            display = shell = None
        if shell is not None and hasattr(shell, "kernel"):
            display.display(display.Image(_png(pixels)))
            return
        try:
            image: Any = import_module("PIL.Image")
        except ImportError:
            raise ImportError(
                "show needs a notebook or Pillow; install pillow, or use save"
            ) from None
        image.fromarray(pixels).show()

    def _repr_png_(self) -> bytes:
        return _png(self.picture())

    def to_xarray(self) -> Any:
        """The buffers as an xarray.Dataset with the dimensions y, x, and channel for vectors;
        needs xarray.

        Coordinates are rows and columns of the full frame. The report is the attribute ``report``,
        as JSON.
        """
        try:
            xarray: Any = import_module("xarray")
        except ImportError:
            raise ImportError(
                "to_xarray needs xarray; install it with pip install xarray"
            ) from None
        rows, columns = self["id"].shape
        channels = {"color": "rgb", "normal": "xyz", "position": "xyz"}
        variables: dict[str, Any] = {}
        for name in self:
            values = self[name]
            dimensions = ["y", "x"]
            if values.ndim == 3:
                dimensions.append(channels.get(name, "light"))
            variables[name] = (
                dimensions,
                values,
                {"units": "scene units"} if name in _LENGTHS else {},
            )
        coordinates: dict[str, Any] = {"y": np.arange(rows), "x": np.arange(columns)}
        used = {dimension for dimensions, *_ in variables.values() for dimension in dimensions}
        coordinates |= {name: list(name) for name in ("rgb", "xyz") if name in used}
        return xarray.Dataset(variables, coordinates, {"report": json.dumps(self.report)})


def _names(aovs: Any) -> list[str] | None:
    return None if aovs is None else words("aovs", aovs)


_LENGTHS = ("distance", "depth", "position", "bound")


def _png(pixels: NDArray[np.uint8]) -> bytes:
    """The PNG of a picture (H, W, 3)."""
    return _halfline.png(np.ascontiguousarray(pixels))
