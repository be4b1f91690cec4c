"""Scenes from the atoms of other packages, which this one does not depend on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from . import _halfline
from .scene import Color, Scene

# As the command does for an unknown element: between carbon and nitrogen, angstrom.
_UNKNOWN = 1.6

# Jmol's colour of unknown elements.
_UNKNOWN_COLOR = "#ff1493"


def from_ase(
    atoms: Any,
    *,
    radii: Literal["vdw", "covalent"] = "vdw",
    radius_scale: float = 1.0,
    background: Color = (0.0, 0.0, 0.0),
) -> Scene:
    """The atoms of ``ase.Atoms`` as spheres, with the radii and colours of their elements.

    Args:
        atoms: An ``ase.Atoms``; its positions are angstrom.
        radii: Radii of elements.
        radius_scale: Multiplies every radius.
        background: Colour of rays that hit nothing.
    """
    return _scene(
        atoms.get_positions(), atoms.get_chemical_symbols(), radii, radius_scale, background
    )


def from_mdanalysis(
    group: Any,
    *,
    radii: Literal["vdw", "covalent"] = "vdw",
    radius_scale: float = 1.0,
    background: Color = (0.0, 0.0, 0.0),
) -> Scene:
    """The atoms of an MDAnalysis group or universe in its current frame as spheres.

    Args:
        group: An ``AtomGroup`` or a ``Universe``; its positions are angstrom. Elements are those
            of the topology; without them, the letters of the atoms' types, as far as they are
            elements.
        radii: Radii of elements.
        radius_scale: Multiplies every radius.
        background: Colour of rays that hit nothing.
    """
    atoms = group.atoms
    symbols = getattr(atoms, "elements", None)
    if symbols is None:
        symbols = [str(kind).strip("0123456789+-") for kind in atoms.types]
    return _scene(atoms.positions, symbols, radii, radius_scale, background)


def _scene(
    positions: Any, symbols: Sequence[Any], radii: str, radius_scale: float, background: Color
) -> Scene:
    if radii not in ("vdw", "covalent"):
        raise ValueError(f"radii is {radii!r}; give 'vdw' or 'covalent'")
    kinds, of = np.unique(
        np.asarray([str(symbol) for symbol in symbols], dtype=str), return_inverse=True
    )
    sizes, colors = _halfline.elements(kinds.tolist(), radii)
    unknown = _halfline.color(_UNKNOWN_COLOR)
    all_sizes = (
        np.array([_UNKNOWN if size is None else size for size in sizes], np.float64)[of]
        * radius_scale
    )
    all_colors = np.array(
        [unknown if color is None else color for color in colors], np.float32
    ).reshape(-1, 3)[of]
    return Scene(np.asarray(positions, np.float64), all_sizes, all_colors, background=background)
