"""Particles of files as arrays, without a scene."""

from pathlib import Path

import numpy as np
import pytest
from test_columns import CLOUD, CRYSTAL

import halfline as hl
from halfline import particles

FILM = "".join(f"2\nTime={n}.5\nO {n} 0 0\nH 0.96 {n} 0\n" for n in range(3))


def test_arrays_have_the_numbers_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(CLOUD)
    found = particles.read(path)
    assert found.positions.tolist() == [[0, 0, 0], [3, 0, 0], [6, 0, 0]]
    assert found.radii is not None and found.radii.tolist() == [1, 1, 1] and found.colors is None
    assert found["kind"].tolist() == ["red", "blue", "red"]
    assert np.array_equal(found["speed"], [0.5, np.nan, 0.25], equal_nan=True)
    assert found.select("speed > 0.3").tolist() == [True, False, False]
    assert (len(found), found.number, found.cell, found.warnings) == (3, 1, None, [])
    assert not found.positions.flags.writeable and "kind" in repr(found)
    # The columns are the same as in a scene that keeps all.
    columns = hl.read(path, keep=True).columns
    assert set(found.columns) == set(columns)
    assert all(np.array_equal(found[name], columns[name]) for name in ["kind", "id", "index"])


def test_frames_options_and_selections(tmp_path: Path) -> None:
    film = tmp_path / "film.xyz"
    film.write_text(FILM)
    found = list(particles.frames(film))
    assert [frame.number for frame in found] == [1, 2, 3]
    assert [frame.time for frame in found] == [0.5, 1.5, 2.5]
    assert [frame.positions[0, 0] for frame in found] == [0, 1, 2]
    assert particles.read(film, 2, select="element H").positions.tolist() == [[0.96, 1, 0]]
    crystal = tmp_path / "a.pdb"
    crystal.write_text(CRYSTAL)
    one = particles.read(crystal, altloc="A", hide="resname HOH")
    assert one.cell is not None and one.cell[1].tolist() == [[20, 0, 0], [0, 20, 0], [0, 0, 20]]
    assert one["name"].tolist() == ["N", "CA", "CB"]


def test_what_is_wrong_is_said(tmp_path: Path) -> None:
    film = tmp_path / "film.xyz"
    film.write_text(FILM)
    with pytest.raises(ValueError, match="no frame 4"):
        particles.read(film, 4)
    with pytest.raises(ValueError, match="whole number from 1"):
        particles.read(film, 0)
    with pytest.raises(TypeError, match="particles have no radius"):
        particles.read(film, radius=1.0)
    with pytest.raises(ValueError, match="resname"):
        particles.read(film).select("resname ALA")
    with pytest.raises(OSError):
        particles.read(tmp_path / "missing.xyz")
    scene = tmp_path / "a.nff"
    scene.write_text("s 0 0 0 1\n")
    with pytest.raises(ValueError, match="not a file of particles"):
        particles.read(scene)
    with pytest.raises(TypeError, match="come from a file"):
        particles.Particles()
