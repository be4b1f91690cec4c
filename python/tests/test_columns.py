"""Columns of scenes: what a file says of an id."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SCENES
from test_read import PDB

import halfline as hl

# In the order of the file; the last two are the same atom at two places.
MORE = """\
ATOM      1  N   ALA A   1       0.000   0.000   0.000  1.00 11.50           N
ATOM      2  CA  ALA A   1       4.000   0.000   0.000  1.00 12.00           C
HETATM    3  O   HOH B  -2       8.000   0.000   0.000  1.00 13.00           O
ATOM      4  CB ASER C   5A     12.000   0.000   0.000  0.50 14.00           C
ATOM      5  CB BSER C   5A     16.000   0.000   0.000  0.50 15.00           C
END
"""

CRYSTAL = "CRYST1   20.000   20.000   20.000  90.00  90.00  90.00 P 1           1\n" + MORE

CLOUD = "x,y,z,radius,speed,kind,id\n0,0,0,1,0.5,red,7\n3,0,0,1,,blue,8\n6,0,0,1,0.25,red,9\n"


@pytest.fixture
def molecule(tmp_path: Path) -> Path:
    path = tmp_path / "some.pdb"
    path.write_text(MORE)
    return path


@pytest.fixture
def cloud_file(tmp_path: Path) -> Path:
    path = tmp_path / "cloud.csv"
    path.write_text(CLOUD)
    return path


def test_columns_of_a_molecule_need_no_option(cpu: hl.Renderer, molecule: Path) -> None:
    scene = hl.read(molecule)
    expected: dict[str, list[Any]] = {
        "chain": ["A", "A", "B", "C", "C"],
        "residue": [1, 1, -2, 5, 5],
        "icode": ["", "", "", "A", "A"],
        "resname": ["ALA", "ALA", "HOH", "SER", "SER"],
        "name": ["N", "CA", "O", "CB", "CB"],
        "element": ["N", "C", "O", "C", "C"],
        "altloc": ["", "", "", "A", "B"],
        "record": ["ATOM", "ATOM", "HETATM", "ATOM", "ATOM"],
        "serial": [1, 2, 3, 4, 5],
        "bfactor": [11.5, 12.0, 13.0, 14.0, 15.0],
        "index": [0, 1, 2, 3, 4],
    }
    for name, values in expected.items():
        assert scene.columns[name].tolist() == values, name
        assert name in scene.columns and name in list(scene.columns)
    kinds = {name: scene.columns[name].dtype.kind for name in expected}
    assert {name for name, kind in kinds.items() if kind == "i"} == {"residue", "serial", "index"}
    assert {name for name, kind in kinds.items() if kind == "f"} == {"bfactor"}
    # The words of selections.
    for word, name in [("resid", "residue"), ("chainid", "chain"), ("beta", "bfactor")]:
        assert word in scene.columns
        assert np.array_equal(scene.columns[word], scene.columns[name])
    # Each sphere is alone in its part of the picture.
    frame = cpu.render(scene, size=(200, 60))
    ids = frame["id"]
    assert set(np.unique(ids)) == {-1, 0, 1, 2, 3, 4}
    hit = ids >= 0
    assert set(scene.columns["chain"][ids[hit]]) == {"A", "B", "C"}
    residues = np.where(hit, scene.columns["residue"][ids], 0)
    assert set(np.unique(residues)) == {0, 1, -2, 5}
    # Columns of left to right: the atoms' order along x.
    first = [int(np.nonzero((ids == k).any(axis=0))[0][0]) for k in range(5)]
    assert first == sorted(first)


def test_ids_of_what_is_left_have_their_own_values(molecule: Path) -> None:
    scene = hl.read(molecule, select="chain A C", hide="name CA", altloc="B")
    assert scene.columns["name"].tolist() == ["N", "CB"]
    assert scene.columns["serial"].tolist() == [1, 5] and len(scene.columns["chain"]) == len(scene)
    # The place among the atoms that were read, as the word index of selections.
    assert hl.read(molecule, hide="chain A").columns["index"].tolist() == [2, 3, 4]
    again = hl.read(molecule, select="index 2:4")
    assert again.columns["name"].tolist() == ["O", "CB", "CB"]


def test_copies_have_the_values_of_their_atoms(tmp_path: Path) -> None:
    file = tmp_path / "crystal.pdb"
    file.write_text(CRYSTAL)
    plain = hl.read(file)
    many = hl.read(file, copies=(2, 1, 1), clip=[(1, 0, 0, 25)])
    # Which atom a sphere is a copy of, by its place: copies are 20 apart.
    of = [int(np.argmin(np.abs(plain.centers[:, 0] - x % 20))) for x in many.centers[:, 0]]
    assert len(of) == 7 and many.columns["name"].tolist() == plain.columns["name"][of].tolist()
    assert many.columns["index"].tolist() == of
    boxed = hl.read(file, cell=True)
    assert boxed.columns["chain"][:5].tolist() == ["A", "A", "B", "C", "C"]
    assert set(boxed.columns["chain"][5:]) == {""} and len(boxed.columns["chain"]) == len(boxed)
    assert boxed.columns["residue"].dtype == np.float64
    assert np.isnan(boxed.columns["residue"][5:]).all() and boxed.columns["residue"][2] == -2


ASSEMBLY = """\
REMARK 350 BIOMOLECULE: 1
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A, B
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   2  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000  1.000000       50.00000
"""


def test_an_assembly_has_the_columns_of_its_copies(tmp_path: Path) -> None:
    file = tmp_path / "two.pdb"
    file.write_text(ASSEMBLY + PDB)
    scene = hl.read(file, assembly=1, hide="water")
    columns = scene.columns
    assert len(scene) == 6 and len(columns["chain"]) == 6
    assert columns["copy"].tolist() == [0, 0, 0, 1, 1, 1]
    assert columns["name"].tolist() == ["N", "CA", "O"] * 2
    assert np.array_equal(columns["copy"] == 1, scene.centers[:, 2] > 20)


def test_other_files_keep_what_is_asked_for(cloud_file: Path) -> None:
    assert list(hl.read(cloud_file).columns) == ["index"]
    with pytest.raises(KeyError, match=r"keep=\['?\"?speed") as caught:
        hl.read(cloud_file).columns["speed"]
    assert "was not kept" in str(caught.value)
    for scene in (
        hl.read(cloud_file, keep="speed"),
        hl.read(cloud_file, keep=["speed"]),
        hl.read(cloud_file, color_by="speed"),
    ):
        assert np.array_equal(scene.columns["speed"], [0.5, np.nan, 0.25], equal_nan=True)
        assert list(scene.columns) == ["speed", "index"]
    assert hl.read(cloud_file, select="kind red").columns["kind"].tolist() == ["red", "red"]
    columns = hl.read(cloud_file, keep=True).columns
    assert set(columns) == {"speed", "kind", "id", "index"}
    assert columns["id"].dtype == np.int32 and columns["kind"].tolist() == ["red", "blue", "red"]
    assert len(hl.read(cloud_file, keep=False, color_by="speed").columns) == 0
    with pytest.raises(ValueError, match=r"sped.*columns are.*speed, kind"):
        hl.read(cloud_file, keep="sped")
    with pytest.raises(ValueError, match=r"keep\[0\] is 3"):
        hl.read(cloud_file, keep=[3])  # type: ignore[list-item]
    with pytest.raises(KeyError, match=r"scene\.centers"):
        columns["x"]


def test_texts_among_numbers_are_said(tmp_path: Path) -> None:
    file = tmp_path / "mixed.csv"
    rows = "".join(f"{n},0,0,1,{n}\n" for n in range(200))
    file.write_text("x,y,z,radius,load\n" + rows + "200,0,0,1,none\n")
    # Whether it is kept or not, the file is read.
    assert len(hl.read(file)) == 201
    scene = hl.read(file, keep=True)
    load = scene.columns["load"]
    assert load.dtype.kind == "f" and np.isnan(load[200]) and load[199] == 199
    # A word that means no number is none; any other text makes a column of texts.
    file.write_text("x,y,z,radius,load\n" + rows + "200,0,0,1,heavy\n")
    load = hl.read(file, keep=True).columns["load"]
    assert load[200] == "heavy" and load[199] == "199"


def test_it_is_a_mapping_of_read_only_arrays(molecule: Path, cloud_file: Path) -> None:
    columns = hl.read(molecule).columns
    assert len(columns) == len(list(columns)) == len(dict(columns.items()))
    assert {name: values.tolist() for name, values in columns.items()}["name"][1] == "CA"
    assert columns.get("nothing") is None and "nothing" not in columns and 3 not in columns
    with pytest.raises(ValueError, match="read-only"):
        columns["bfactor"][0] = 1
    assert np.shares_memory(columns["bfactor"], columns["bfactor"])
    codes, texts = columns.categories("chain")
    assert codes.dtype == np.uint8 and texts[codes].tolist() == columns["chain"].tolist()
    with pytest.raises(TypeError, match="has numbers"):
        columns.categories("bfactor")
    with pytest.raises(KeyError, match="the columns are name, resname"):
        columns["chian"]
    with pytest.raises(TypeError, match="named by a text"):
        columns[0]  # type: ignore[index]
    assert repr(columns).startswith("Columns(5 spheres: name <U2, resname <U3, residue int32")
    assert repr(hl.read(cloud_file)) == "Scene(3 spheres; columns index)"
    # The arrays outlive the scene.
    kept = hl.read(molecule).columns["bfactor"]
    assert kept.tolist() == [11.5, 12.0, 13.0, 14.0, 15.0]


def test_scenes_without_columns_have_an_empty_mapping(cloud: hl.Scene) -> None:
    for scene in (cloud, hl.read(SCENES / "weekend.toml")):
        assert len(scene.columns) == 0 and dict(scene.columns) == {}
        with pytest.raises(KeyError, match="no columns"):
            scene.columns["chain"]
    assert repr(cloud.columns) == "Columns(none)" and repr(cloud) == "Scene(500 spheres)"


def test_a_scene_selects_by_its_columns(molecule: Path, cloud_file: Path) -> None:
    scene = hl.read(molecule)
    for expression in (
        "chain A",
        "resid 5A and element C",
        "water",
        "within 5 of (name CA)",
        "bfactor < 13",
    ):
        mask = scene.select(expression)
        taken = hl.read(molecule, select=expression)
        assert mask.dtype == np.bool_ and np.array_equal(scene.centers[mask], taken.centers), (
            expression
        )
    with pytest.warns(UserWarning, match="no particle has it; the file has A, B, C"):
        assert not scene.select("chain Z").any()
    with pytest.raises(ValueError, match=r"kept.*keep=\["):
        hl.read(cloud_file).select("speed > 0.3")
    with pytest.raises(ValueError, match="the file has no chian"):
        scene.select("chian A")
    with pytest.raises(ValueError, match="expression is 3"):
        scene.select(3)  # type: ignore[arg-type]
    assert hl.read(cloud_file, keep="speed").select("speed > 0.3").tolist() == [True, False, False]


def test_the_frames_of_a_film_have_their_own_columns(tmp_path: Path) -> None:
    file = tmp_path / "film.xyz"
    frames = [
        f"2\nProperties=species:S:1:pos:R:3:load:R:1\nC {n} 0 0 {n}.5\nO 3 {n} 0 -{n}.5\n"
        for n in range(3)
    ]
    file.write_text("".join(frames))
    loads = [scene.columns["load"].tolist() for scene in hl.read_frames(file, keep=True)]
    assert loads == [[n + 0.5, -n - 0.5] for n in range(3)]
    # Elements cost a byte and are always there.
    assert hl.read(file).columns["element"].tolist() == ["C", "O"]


def test_kept_columns_take_the_documented_memory(molecule: Path) -> None:
    scene = hl.read(molecule)
    taken = 0
    for name, values in scene.columns.items():
        is_text = values.dtype.kind == "U"
        taken += scene.columns.categories(name)[0].nbytes if is_text else values.nbytes
    # Documented are some 40 bytes per atom.
    assert 30 <= taken / len(scene) <= 45, taken / len(scene)
