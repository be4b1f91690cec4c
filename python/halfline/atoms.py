"""Scenes from the atoms of other packages, which this one does not depend on."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _halfline
from ._arrays import Color, shown
from .scene import Scene, read


def from_ase(
    atoms: Any,
    *,
    radii: Literal["vdw", "covalent"] = "vdw",
    radius_scale: float = 1.0,
    background: Color = (0.0, 0.0, 0.0),
) -> Scene:
    """The atoms of ``ase.Atoms`` as spheres, with the radii and colours of their elements.

    Atoms of the element ``X`` (number 0) are not drawn and are counted in ``scene.warnings``.
    ``scene.cell`` is the cell of the atoms, if it has a volume; ``scene.columns`` has the element,
    and the arrays of the atoms with a number or a text for each.

    Args:
        atoms: An ``ase.Atoms``; its positions are angstrom.
        radii: Radii of elements.
        radius_scale: Multiplies every radius.
        background: Colour of rays that hit nothing.

    Raises:
        TypeError: if ``atoms`` is something else.
    """
    for needed in ("get_positions", "get_chemical_symbols"):
        if not hasattr(atoms, needed):
            raise TypeError(f"atoms is {shown(atoms)}; give an ase.Atoms")
    symbols = np.asarray(atoms.get_chemical_symbols(), dtype=str)
    stays = symbols != "X"
    left_out = int(np.count_nonzero(~stays))
    warnings = [
        f"{left_out} atom{'' if left_out == 1 else 's'} of the element X (number 0) left out"
    ][: min(left_out, 1)]
    scene = _scene(
        np.asarray(atoms.get_positions(), np.float64)[stays],
        symbols[stays],
        radii,
        radius_scale,
        background,
    )
    arrays = getattr(atoms, "arrays", {})
    own = {name: values for name, values in arrays.items() if name != "numbers"}
    columns = {"element": symbols, **own}
    _keep(scene, {name: np.asarray(values)[stays] for name, values in columns.items()})
    return _told(scene, warnings, 1, None, None, getattr(atoms, "cell", None))


def from_mdanalysis(
    group: Any,
    *,
    radii: Literal["vdw", "covalent"] = "vdw",
    radius_scale: float = 1.0,
    background: Color = (0.0, 0.0, 0.0),
) -> Scene:
    """The atoms of an MDAnalysis group or universe in its current frame as spheres.

    Elements that the topology does not give are inferred as `read` does: from the names of atoms
    and residues, else from masses. Virtual sites, such as ``MW`` of TIP4P, are not drawn.
    ``scene.warnings`` has the counts of both; ``scene.cell``, ``scene.number``, ``scene.time`` and
    ``scene.step`` describe the frame, as far as the trajectory has them. ``scene.columns`` has
    the element, and name, residue, chain, type, charge, mass and B factor as far as the topology
    gives them.

    Args:
        group: An ``AtomGroup`` or a ``Universe``; its positions are angstrom.
        radii: Radii of elements.
        radius_scale: Multiplies every radius.
        background: Colour of rays that hit nothing.

    Raises:
        TypeError: if ``group`` is something else.
    """
    atoms: Any = getattr(group, "atoms", None)
    universe = getattr(atoms, "universe", None)
    if universe is None:
        raise TypeError(f"group is {shown(group)}; give an AtomGroup or a Universe of MDAnalysis")

    def texts(*attributes: str) -> list[str]:
        for attribute in attributes:
            found = getattr(atoms, attribute, None)
            if found is not None:
                return [str(value) for value in found]
        return []

    masses = getattr(atoms, "masses", None)
    symbols, is_site, warnings = _halfline.infer(
        texts("names", "types") or [""] * len(atoms),
        texts("elements"),
        texts("resnames"),
        np.asarray(atoms.resindices).tolist(),
        [] if masses is None else np.asarray(masses, np.float64).tolist(),
    )
    stays = ~np.asarray(is_site, dtype=bool)
    positions = np.asarray(atoms.positions, np.float64)[stays]
    scene = _scene(
        positions, np.asarray(symbols, dtype=str)[stays], radii, radius_scale, background
    )
    known = {word: getattr(atoms, attribute, None) for word, attribute in _COLUMNS}
    given = {word: rows for word, rows in known.items() if rows is not None}
    columns = {"element": symbols, **given}
    _keep(scene, {name: np.asarray(rows)[stays] for name, rows in columns.items()})
    frame = universe.trajectory.ts
    # Without a time of its own or a step that the user gave, a frame has its number as its time.
    time = frame.time if {"time", "dt"} & frame.data.keys() else None
    step = frame.data.get("step")
    return _told(
        scene,
        warnings,
        max(int(frame.frame), 0) + 1,
        None if time is None else float(time),
        None if step is None else int(step),
        frame.triclinic_dimensions,
    )


# Words of selections, and the attributes of MDAnalysis that have them.
_COLUMNS = (
    ("name", "names"),
    ("resname", "resnames"),
    ("resid", "resids"),
    ("chain", "chainIDs"),
    ("segid", "segids"),
    ("type", "types"),
    ("charge", "charges"),
    ("mass", "masses"),
    ("bfactor", "tempfactors"),
)


def _keep(scene: Scene, columns: dict[str, NDArray[Any]]) -> None:
    """Gives the scene the columns with a number or a text for each atom."""
    flat = {
        name: rows
        for name, rows in columns.items()
        if rows.ndim == 1 and rows.dtype.kind in "iufUO"
    }
    if len(scene):
        given = {"positions": scene.centers, "radius": scene.radii, **flat}
        scene._native = scene._native.with_columns(read(given, keep=True)._native)


def _told(
    scene: Scene, warnings: list[str], number: int, time: float | None, step: int | None, cell: Any
) -> Scene:
    """The scene with what the other package says of its frame."""
    edges = None if cell is None else np.asarray(cell, np.float64)
    if edges is None or edges.shape != (3, 3) or not np.isfinite(edges).all():
        edges = None
    elif np.linalg.matrix_rank(edges) < 3:
        edges = None
    periodic = None
    if edges is not None:
        a, b, c = ((float(x), float(y), float(z)) for x, y, z in edges)
        periodic = ((0.0, 0.0, 0.0), (a, b, c))
    return Scene._of(scene._native.with_facts(warnings, number, time, step, periodic))


def _scene(
    positions: NDArray[np.float64],
    symbols: NDArray[np.str_],
    radii: str,
    radius_scale: float,
    background: Color,
) -> Scene:
    if radii not in ("vdw", "covalent"):
        raise ValueError(f"radii is {radii!r}; give 'vdw' or 'covalent'")
    kinds, of = np.unique(symbols, return_inverse=True)
    sizes, colors = _halfline.elements(kinds.tolist(), radii)
    all_sizes = np.array(sizes, np.float64)[of] * radius_scale
    all_colors = np.array(colors, np.float32).reshape(-1, 3)[of]
    return Scene(positions, all_sizes, all_colors, background=background)
