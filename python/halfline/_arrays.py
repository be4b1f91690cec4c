"""Checks of arguments. Errors name the argument, what was found, and what is expected."""

from __future__ import annotations

import math
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _halfline

Color = str | ArrayLike
Vector = tuple[float, float, float]
Number = TypeVar("Number", np.float32, np.float64)


class Spheres(Protocol):
    """What cameras need of a `Scene`, which has cameras itself."""

    def __len__(self) -> int: ...

    def select(self, expression: str) -> NDArray[np.bool_]: ...


class Renders(Protocol):
    """What views need of a `Renderer`."""

    @property
    def adapter(self) -> str: ...

    @property
    def is_gpu(self) -> bool: ...


def native_renderer(renderer: Renders) -> _halfline.Renderer:
    """The native part of a `Renderer`."""
    native = getattr(renderer, "_native", None)
    if not isinstance(native, _halfline.Renderer):
        raise TypeError(f"renderer is a {type(renderer).__name__}; give a Renderer")
    return native


def native_scene(scene: Spheres) -> _halfline.Scene:
    """The native part of a `Scene`."""
    native = getattr(scene, "_native", None)
    if not isinstance(native, _halfline.Scene):
        raise TypeError(f"scene is a {type(scene).__name__}; give a Scene")
    return native


def array(name: str, values: ArrayLike, dtype: type[Number], shape: str) -> NDArray[Number]:
    """The values as an aligned array in C order: the array itself where it is one, else one copy.

    ``shape`` is ``(n,)``, ``(n, 3)`` or ``(..., 3)``; ``n`` and ``...`` stand for any numbers.
    """
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values; remove them or fill them")
    try:
        given = np.asarray(values)
    except ValueError as error:
        raise ValueError(
            f"{name} is not an array: {error}; give an array of shape {shape}"
        ) from None
    if given.dtype.kind not in "fiu":
        raise ValueError(
            f"{name} has the dtype {given.dtype}; give real numbers such as {np.dtype(dtype).name}"
        )
    wanted = shape.strip("()").replace(" ", "").split(",")
    columns = 3 if wanted[-1] == "3" else None
    dimensions = (
        given.ndim >= 1 if wanted[0] == "..." else given.ndim == (1 if columns is None else 2)
    )
    if not dimensions or (columns is not None and given.shape[-1] != columns):
        raise ValueError(f"{name} has the shape {given.shape}; give an array of shape {shape}")
    return np.require(given, dtype, ["C", "A"])


def vector(name: str, values: ArrayLike) -> Vector:
    """Three finite numbers."""
    try:
        given = np.asarray(values)
    except ValueError:
        given = np.empty(0)
    if given.shape != (3,) or given.dtype.kind not in "fiu":
        raise ValueError(f"{name} is {shown(values)}; give three numbers")
    x, y, z = (float(component) for component in given)
    if not all(map(math.isfinite, (x, y, z))):
        raise ValueError(f"{name} is {shown(values)}; give three finite numbers")
    return x, y, z


def number(name: str, value: Any) -> float:
    """A finite number."""
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise ValueError(f"{name} is {shown(value)}; give a number")
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} is {shown(value)}; give a number") from None
    if not math.isfinite(found):
        raise ValueError(f"{name} is {found}; give a finite number")
    return found


def whole(name: str, value: Any, least: int = 0, most: int = 2**32 - 1) -> int:
    """A whole number from ``least`` to ``most``."""
    if isinstance(value, (bool, np.bool_)) or not hasattr(value, "__index__"):
        raise ValueError(f"{name} is {shown(value)}; give a whole number")
    found = int(value.__index__())
    if not least <= found <= most:
        raise ValueError(f"{name} is {found}; give a whole number from {least} to {most}")
    return found


def wholes(name: str, values: Any, count: int, least: int = 0) -> tuple[int, ...]:
    """So many whole numbers."""
    if isinstance(values, (str, bytes)) or not hasattr(values, "__len__") or len(values) != count:
        raise ValueError(f"{name} is {shown(values)}; give {count} whole numbers")
    return tuple(whole(f"{name}[{k}]", value, least) for k, value in enumerate(values))


def size(name: str, values: Any) -> tuple[int, int]:
    """Columns and rows of an image."""
    width, height = wholes(name, values, 2, 1)
    return width, height


def word(name: str, value: Any) -> str:
    """A text."""
    if not isinstance(value, str):
        raise ValueError(f"{name} is {shown(value)}; give a text")
    return value


def words(name: str, values: Any) -> list[str]:
    """A text or several; a single one is a list of one."""
    if isinstance(values, str):
        return [values]
    try:
        return [word(f"{name}[{k}]", value) for k, value in enumerate(values)]
    except TypeError:
        raise ValueError(f"{name} is {shown(values)}; give a text or a list of texts") from None


def color(name: str, value: Color) -> Vector:
    """Linear RGB: three numbers, or a CSS name or ``#rrggbb`` in sRGB."""
    if isinstance(value, str):
        return _halfline.color(value)
    return vector(name, value)


def shown(value: Any) -> str:
    """A value in a message, shortened."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
