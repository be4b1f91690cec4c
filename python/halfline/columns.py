"""Columns of a scene or of particles: what the file says of each sphere or particle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import shown

if TYPE_CHECKING:
    from . import _halfline


class Columns(Mapping[str, NDArray[Any]]):
    """The columns of a scene's file, as arrays in the order of ids: a mapping from names.

    Keys are the file's names in lower case, ``element``, and ``index``, the number in the file
    from 0. Lookup understands the words of selections too: ``resid`` is ``residue``, ``chainid``
    is ``chain``.

    ================================================================= ======= =======
    columns                                                           dtype   missing
    ================================================================= ======= =======
    numbers                                                           float64 NaN
    that count or identify: residue, serial, id, type, mol, index ... int32   NaN
    texts: chain, resname, name, element ...                          str     empty
    ================================================================= ======= =======

    Texts have no blanks around them. A column of the second kind is float64 where a number is
    missing, not whole or too large.

    Arrays of numbers are the scene's memory, read-only and without a copy. An array of texts is
    made at each lookup; it takes 4 bytes per letter of the longest text and sphere, and
    `categories` gives the same in 1 byte per sphere (up to 256 texts).

    An id of -1, a miss, would be the last sphere's value, as NumPy counts: leave misses out first.

    >>> import halfline as hl, pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "two.gro"
    >>> _ = file.write_text(
    ...     "t\\n    2\\n    1ALA     CA    1   0.0   0.0   0.0\\n"
    ...     "    2HOH     OW    2   1.0   0.0   0.0\\n   2.0 2.0 2.0\\n"
    ... )
    >>> scene = hl.read(file)
    >>> scene.columns
    Columns(2 spheres: name <U2, resname <U3, residue int32, serial int32, element <U2,
    index int32)
    >>> frame = hl.Renderer("cpu").render(scene, size=(40, 30))
    >>> ids = frame["id"]
    >>> sorted(set(scene.columns["resname"][ids[ids >= 0]].tolist()))
    ['ALA', 'HOH']
    >>> shown = np.where(ids >= 0, scene.columns["residue"][ids], 0)
    >>> sorted(set(shown.ravel().tolist()))
    [0, 1, 2]
    """

    __slots__ = ("_native",)

    _native: _halfline.Scene | _halfline.Particles

    # A mapping compares values, and a comparison of arrays has no single truth.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __init__(self) -> None:
        raise TypeError("Columns belong to a Scene: scene.columns")

    @classmethod
    def _of(cls, native: _halfline.Scene | _halfline.Particles) -> Columns:
        columns = cls.__new__(cls)
        columns._native = native
        return columns

    def __getitem__(self, name: str) -> NDArray[Any]:
        values, texts = self._look_up(name)
        return values if texts is None else np.asarray(texts, np.str_)[values]

    def __contains__(self, name: object) -> bool:
        try:
            self._look_up(name)
        except (KeyError, TypeError):
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(self._native.column_names)

    def __len__(self) -> int:
        return len(self._native.column_names)

    def categories(self, name: str) -> tuple[NDArray[Any], NDArray[np.str_]]:
        """A column of texts as numbers of texts: ``texts[numbers]`` is the column.

        The numbers are uint8, uint16 or uint32, read-only and without a copy. Some texts may not
        occur, and there is an empty one.

        Raises:
            KeyError: if there is no such column.
            TypeError: for a column of numbers.
        """
        values, texts = self._look_up(name)
        if texts is None:
            raise TypeError(f"the column {name!r} has numbers; use columns[{name!r}]")
        return values, np.asarray(texts, np.str_)

    def __repr__(self) -> str:
        if not len(self):
            return "Columns(none)"
        count = len(self._native)
        columns = ", ".join(f"{name} {self._dtype(name)}" for name in self)
        return f"Columns({count} sphere{'' if count == 1 else 's'}: {columns})"

    def _dtype(self, name: str) -> str:
        values, texts = self._look_up(name)
        dtype = values.dtype if texts is None else np.asarray(texts, np.str_).dtype
        return dtype.str.lstrip("=|") if texts is not None else dtype.name

    def _look_up(self, name: object) -> tuple[NDArray[Any], list[str] | None]:
        if not isinstance(name, str):
            raise TypeError(f"a column is named by a text such as 'chain', not by {shown(name)}")
        return self._native.column(name)
