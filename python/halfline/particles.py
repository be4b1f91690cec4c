"""Files of particles as arrays, without a scene or a renderer.

>>> import pathlib, tempfile
>>> from halfline import particles
>>> file = pathlib.Path(tempfile.mkdtemp()) / "water.xyz"
>>> _ = file.write_text("2\\n\\nO 0 0 0\\nH 0.96 0 0\\n")
>>> atoms = particles.read(file)
>>> atoms.positions.tolist(), atoms["element"].tolist()
([[0.0, 0.0, 0.0], [0.96, 0.0, 0.0]], ['O', 'H'])
>>> atoms.positions[atoms.select("element H")].tolist()
[[0.96, 0.0, 0.0]]
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from os import fspath
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from . import _halfline
from ._arrays import word
from .columns import Columns
from .options import Path, ReadOptions

__all__ = ["Particles", "frames", "read"]

# The options of a reading that are about particles; the others are about spheres and pictures.
_OPTIONS = frozenset(
    {
        "add",
        "altloc",
        "as_listed",
        "assembly",
        "atom_style",
        "columns",
        "format",
        "hide",
        "identity",
        "model",
        "select",
        "strict",
        "topology",
        "unwrap",
        "wrap",
    }
)


class Particles:
    """The particles of a frame, in the order of the file: arrays by name.

    ``particles["mass"]`` is a column, by the words of selections too; see `Columns`.
    """

    __slots__ = ("_native",)

    _native: _halfline.Particles

    def __init__(self) -> None:
        raise TypeError("particles come from a file: halfline.particles.read(file)")

    @classmethod
    def _of(cls, native: _halfline.Particles) -> Particles:
        particles = cls.__new__(cls)
        particles._native = native
        return particles

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions, shape (n, 3), in the file's unit; positions of GROMACS in ångström."""
        return self._native.positions

    @property
    def radii(self) -> NDArray[np.float64] | None:
        """Radii in the same unit, NaN for a particle without one; None if the file has none."""
        return self._native.radii

    @property
    def colors(self) -> NDArray[np.float32] | None:
        """Colours as the numbers of the file, shape (n, 3); None if the file has none."""
        return self._native.colors

    @property
    def columns(self) -> Columns:
        """All columns of the file, as a mapping from names."""
        return Columns._of(self._native)

    @property
    def cell(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """The corner and the three edges of the periodic cell; None if the file has none."""
        found = self._native.cell
        return None if found is None else (np.array(found[0]), np.array(found[1]))

    @property
    def number(self) -> int:
        """The number of the frame in the file, from 1."""
        return self._native.number

    @property
    def time(self) -> float | None:
        """The time of the frame, as far as the file has it: picoseconds for GROMACS and DCD."""
        return self._native.time

    @property
    def step(self) -> int | None:
        """The step of the simulation, as far as the file has it."""
        return self._native.step

    @property
    def warnings(self) -> list[str]:
        """What the reader left out, and what it assumed, in whole sentences."""
        return self._native.warnings

    def select(self, expression: str) -> NDArray[np.bool_]:
        """Whether a selection selects each particle: ``"protein and within 5 of resname HEM"``.

        Raises:
            ValueError: for an expression that is malformed or that the columns do not fit.
        """
        mask, notes = self._native.select(expression)
        for note in notes:
            warnings.warn(note, stacklevel=2)
        return mask.astype(np.bool_)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        names = ", ".join(self._native.column_names)
        return f"Particles({len(self)}: {names})"


def read(path: Path, frame: int = 1, **options: Unpack[ReadOptions]) -> Particles:
    """The particles of a frame of a file, with all columns.

    Args:
        path: The file, compressed or not; its format follows from its content.
        frame: The number of the frame, from 1.
        **options: Keywords of `ReadOptions` that are about particles: ``format``, ``columns``,
            ``topology``, ``model``, ``altloc``, ``assembly``, ``select``, ``hide``, ``wrap``, ...

    Raises:
        ValueError: for a file that is not of particles, and for options that it does not take.
        OSError: for a file that cannot be read.
    """
    if not isinstance(frame, int) or frame < 1:
        raise ValueError(f"frame is {frame!r}; give a whole number from 1")
    found = next(frames(path, str(frame), **options), None)
    if found is None:
        raise ValueError(f"{fspath(path)} has no frame {frame}")
    return found


def frames(path: Path, frames: str = "1-", **options: Unpack[ReadOptions]) -> Iterator[Particles]:
    """The frames of a file, one after the other; at most one is in memory.

    Args:
        path: The file.
        frames: The frames, counted from 1: ``"2"``, ``"1-10"``, ``"1-3,5,7-20:2"``, ``"5-"`` to
            the last.
        **options: As for `read`.

    Raises:
        As `read`.
    """
    fspath(path)
    if others := sorted(set(options) - _OPTIONS):
        raise TypeError(
            f"particles have no {others[0]}; the options are {', '.join(sorted(_OPTIONS))}"
        )
    natives = _halfline.ParticleFrames(path, dict(options), word("frames", frames))
    return map(Particles._of, natives)
