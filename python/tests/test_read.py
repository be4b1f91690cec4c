"""Files: the options of the command as keywords, sequences, errors."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SCENES, commands, run
from numpy.typing import NDArray

import halfline as hl

PDB = """\
ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00  0.00           N
ATOM      2  CA  ALA A   1      11.639   6.071  -5.147  1.00  0.00           C
ATOM      3  O   ALA B   2      12.639   7.071  -4.147  1.00  0.00           O
HETATM    4  O   HOH B   3      15.639   7.071  -4.147  1.00  0.00           O
END
"""

XYZ = "".join(f"2\nframe {n}\nC {n} 0 0\nO {3 - n} {n} 0\n" for n in range(4))


@pytest.fixture
def pdb(tmp_path: Path) -> Path:
    path = tmp_path / "some.pdb"
    path.write_text(PDB)
    return path


@pytest.fixture
def film(tmp_path: Path) -> Path:
    path = tmp_path / "film.xyz"
    path.write_text(XYZ)
    return path


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ({}, []),
        ({"select": "not water"}, ["--select", "not water"]),
        ({"hide": ["name CA", "chain B"]}, ["--hide", "name CA", "--hide", "chain B"]),
        (
            {"radii": "covalent", "radius_scale": 0.5},
            ["--radii", "covalent", "--radius-scale", "0.5"],
        ),
        ({"radius": 0.7, "color": "tomato"}, ["--radius", "0.7", "--color", "tomato"]),
        (
            {"radius": {"name CA": 2.5}, "color": {"chain B": "#00f"}},
            ["--radius", "name CA=2.5", "--color", "chain B=#00f"],
        ),
        (
            {"color_by": "x", "map": "magma", "range": (10, 13)},
            ["--color-by", "x", "--map", "magma", "--range", "10,13"],
        ),
        ({"color_by": ["x", "y"]}, ["--color-by", "x,y"]),
        (
            {"color_by": "chain", "color": {"not element C": "element"}},
            ["--color-by", "chain", "--color", "not element C=element"],
        ),
        ({"clip": [(1, 0, 0, 12)]}, ["--clip", "1,0,0,12"]),
    ],
)
def test_keywords_are_the_options_of_the_command(
    cpu: hl.Renderer, pdb: Path, tmp_path: Path, options: dict[str, Any], arguments: list[str]
) -> None:
    out = tmp_path / "out.npz"
    run(
        commands()[0],
        "render",
        pdb,
        f"--aov=color,depth,id={out}",
        "--backend",
        "cpu",
        "--size",
        "50x40",
        *arguments,
    )
    frame = cpu.render(hl.read(pdb, **options), size=(50, 40), aovs=["color", "depth"])
    with np.load(out) as found:
        for name in ("color", "depth", "id"):
            assert frame[name].tobytes() == found[name].tobytes(), name


def test_frames_are_held_to_the_first_as_in_the_command(
    cpu: hl.Renderer, film: Path, tmp_path: Path
) -> None:
    # The plane removes both atoms of the first frame.
    clip = {"clip": [(0, -1, 0, -0.5)]}
    for frames, hold, options in (
        ("1-", "first", {}),
        ("2-3", "first", {}),
        ("1-4:2", "none", {}),
        ("1-", "first", clip),
        ("2-3", "first", clip),
    ):
        command = [
            commands()[0],
            "render",
            film,
            f"--aov=color,depth={tmp_path}/%d.npz",
            "--backend",
            "cpu",
        ]
        clipped = ["--clip=0,-1,0,-0.5"] if options else []
        run(*map(str, command), "--size", "40x30", "--frames", frames, "--hold", hold, *clipped)
        scenes = list(hl.read_frames(film, frames, size=(40, 30), hold=hold, **options))
        assert len(scenes) == {"1-": 4, "2-3": 2, "1-4:2": 2}[frames]
        for scene in scenes:
            frame = cpu.render(scene, aovs=["color", "depth"])
            with np.load(tmp_path / f"{scene.number}.npz") as found:
                assert frame["depth"].tobytes() == found["depth"].tobytes(), (
                    frames,
                    options,
                    scene.number,
                )


def test_a_map_is_an_array_or_a_function(pdb: Path, tmp_path: Path) -> None:
    ends = np.array([[255, 0, 0], [0, 0, 255]], np.uint8)
    table = tmp_path / "map.csv"
    table.write_text("255,0,0\n0,0,255\n")
    expected = hl.read(pdb, color_by="x", map=table).colors

    def function(x: NDArray[np.float64]) -> NDArray[np.float64]:
        """As a colormap of matplotlib: RGBA."""
        return np.stack([1 - x, 0 * x, x, 0 * x + 1], axis=-1)

    for map in (ends, ends / 255, function):
        # A function is taken at 256 steps, whose levels of 8 bits are rounded.
        np.testing.assert_allclose(hl.read(pdb, color_by="x", map=map).colors, expected, atol=0.01)
    painted = hl.read(pdb, color="red").with_colors({"element N": "element"})
    assert painted.colors is not None and len(np.unique(painted.colors, axis=0)) == 2


def test_a_frame_is_chosen_by_its_number(film: Path) -> None:
    assert hl.read(film, frame=3).centers[0, 0] == 2
    with pytest.raises(ValueError, match="frame"):
        hl.read(film, frame=9)


def test_a_scene_file_has_its_camera_and_size(cpu: hl.Renderer) -> None:
    scene = hl.read(SCENES / "weekend.toml")
    frame = cpu.render(scene)
    assert frame.size == scene.size and frame.report["camera"]["eye"] == list(
        scene.camera.record()["eye"]
    )
    assert scene.warnings == [] and len(scene.fingerprint()) == 32


def test_what_a_file_lacks_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        hl.read(tmp_path / "none.pdb")
    assert caught.value.filename == str(tmp_path / "none.pdb") and caught.value.errno == 2
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("[camera]\neye = [0, 0]\n")
    with pytest.raises(ValueError, match=r"wrong\.toml:1:1: camera\.at") as error:
        hl.read(wrong)
    said = run(commands()[0], "render", wrong, "-o", tmp_path / "x.png", code=3)
    assert str(error.value) in said.stderr
    csv = tmp_path / "radii.csv"
    csv.write_text("x,y,z,radius\n0,0,0,1\n1,1,1,-1\n")
    with pytest.raises(ValueError, match="radius"):
        hl.read(csv)
    assert len(hl.read(csv, skip_invalid=True)) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"color": "red", "color_by": "x"}, ["color", "color_by"]),
        ({"color_by": "temperature"}, ["temperature"]),
        ({"select": "chian A"}, ["chian"]),
        ({"radius": -1}, ["-1", "positive"]),
        ({"range": (1, 1), "color_by": "x"}, ["range"]),
        ({"map": "magma"}, ["color_by"]),
        ({"color_by": "x", "map": np.zeros((3, 2))}, ["map", "(3, 2)"]),
        ({"color_by": "x", "map": [[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]]}, ["map", "beyond"]),
        ({"color_by": "x", "map": [[0.0, 0.0, 1.0]]}, ["1 colour"]),
        ({"copies": (1, 2)}, ["copies"]),
        ({"copies": (2, 2, 2)}, ["cell"]),
        ({"wrap": True, "unwrap": True}, ["wrap"]),
        ({"clip": [(0, 0, 0, 1)]}, ["clip"]),
        ({"format": "docx"}, ["docx"]),
        ({"frame": 0}, ["frame"]),
    ],
)
def test_wrong_options_are_refused(pdb: Path, options: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as caught:
        hl.read(pdb, **options)
    assert all(word in str(caught.value) for word in words) and "--" not in str(caught.value), (
        caught.value
    )
    with pytest.raises(TypeError):
        hl.read(pdb, selct="x")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="selct"):
        hl.read_frames(pdb, selct="x")


def test_info_and_adapters_are_those_of_the_command(pdb: Path) -> None:
    assert hl.info(pdb) == json.loads(run(commands()[0], "info", pdb, "--json").stdout)
    assert hl.adapters() == json.loads(run(commands()[0], "adapters", "--json").stdout)["adapters"]


def test_cameras_of_a_list(cpu: hl.Renderer, tmp_path: Path) -> None:
    path = tmp_path / "cameras.csv"
    path.write_text(
        "eye_x,eye_y,eye_z,view_x,view_y,view_z,up_x,up_y,up_z\n0,0,5,0,0,-1,0,1,0\n5,0,0,-1,0,0,0,1,0\n"
    )
    try:
        cameras = hl.read_cameras(path, vfov=30)
    except ValueError:
        # The columns of docs/film.md.
        path.write_text("ex,ey,ez,vx,vy,vz,ux,uy,uz\n0,0,5,0,0,-1,0,1,0\n5,0,0,-1,0,0,0,1,0\n")
        cameras = hl.read_cameras(path, vfov=30)
    frames = list(cpu.render_many(hl.Scene([[0, 0, 0]], 1), cameras, size=(5, 5), aovs="depth"))
    assert [frame["depth"][2, 2] for frame in frames] == [4, 4]


class Atoms:
    """The part of ``ase.Atoms`` that is read."""

    def __init__(self, symbols: str, positions: Any, arrays: dict[str, Any]) -> None:
        self.symbols, self.positions, self.arrays = list(symbols), np.asarray(positions), arrays

    def get_positions(self) -> Any:
        return self.positions

    def get_chemical_symbols(self) -> list[str]:
        return self.symbols


def test_arrays_of_atoms_are_columns(cpu: hl.Renderer) -> None:
    positions = np.arange(12.0).reshape(4, 3)
    arrays = {
        "positions": positions,
        "numbers": np.array([8, 1, 0, 1]),
        "initial_charges": np.array([-0.8, 0.4, 9.0, 0.4]),
        "forces": positions,
        "residuenames": np.array(["HOH", "HOH", "", "WAT"]),
    }
    scene = hl.from_ase(Atoms("OHXH", positions, arrays))
    # X is not drawn, and vectors are no columns.
    assert scene.columns["initial_charges"].tolist() == [-0.8, 0.4, 0.4]
    assert scene.columns["residuenames"].tolist() == ["HOH", "HOH", "WAT"]
    assert scene.select("element H and initial_charges > 0").tolist() == [False, True, True]
    assert "forces" not in scene.columns and "numbers" not in scene.columns
    frame = cpu.render(scene, size=(8, 8), mark={"initial_charges < 0": "{residuenames}"})
    assert frame["id"].shape == (8, 8)


def test_arrays_are_read_as_files_are(cpu: hl.Renderer, tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    arrays = {
        "positions": random.normal(size=(50, 3)),
        "radius": random.uniform(0.1, 0.3, 50),
        "charge": random.normal(size=50),
        "kind": np.array(["a", "bb"] * 25, dtype=object),
    }
    np.savez(tmp_path / "a.npz", **{**arrays, "kind": arrays["kind"].astype(str)})
    options: dict[str, Any] = {"color_by": "charge", "map": "coolwarm", "select": "kind a"}
    own, of_file = hl.read(arrays, **options), hl.read(tmp_path / "a.npz", **options)
    assert len(own) == 25 and np.array_equal(own.centers, of_file.centers)
    assert np.array_equal(own.colors, of_file.colors) and np.array_equal(own.radii, of_file.radii)
    frames = [cpu.render(scene, size=(240, 200), legend=True).image for scene in (own, of_file)]
    assert np.array_equal(*frames)
    with pytest.raises(ValueError, match="mass"):
        hl.read(arrays, color_by="mass")


def test_values_give_the_colours_of_arrays(cpu: hl.Renderer) -> None:
    random = np.random.default_rng(5)
    centers, radii, values = (
        random.normal(size=(90, 3)),
        random.uniform(0.1, 0.2, 90),
        np.arange(90),
    )
    scene = hl.Scene(
        centers, radii, values=values, map="plasma", range=("10%", 80), background="white"
    )
    table = {"positions": centers, "radius": radii, "value": values.astype(float)}
    expected = hl.read(table, color_by="value", map="plasma", range=("10%", 80))
    assert np.array_equal(scene.colors, expected.colors)
    assert scene.columns["value"].tolist() == values.tolist()
    # The look is the same as for scenes of arrays.
    painted = hl.Scene(centers, radii, scene.colors, background="white")
    frames = [cpu.render(one, size=(30, 30)).image for one in (scene, painted)]
    assert np.array_equal(*frames)
    for wrong in (
        {"values": values[:5]},
        {"values": values, "colors": "red"},
        {"map": "plasma"},
        {"values": values, "map": "rainbow"},
    ):
        with pytest.raises(ValueError, match=r"values|rainbow"):
            hl.Scene(centers, radii, **wrong)


def test_atoms_of_ase(cpu: hl.Renderer, pdb: Path) -> None:
    ase = pytest.importorskip("ase")
    water = ase.Atoms("OHHX", [[0, 0, 0], [0.76, 0.59, 0], [-0.76, 0.59, 0], [3, 0, 0]])
    scene = hl.from_ase(water)
    # Bondi's radii; X is no element.
    assert np.array_equal(scene.radii, [1.52, 1.2, 1.2]) and np.array_equal(
        scene.centers, water.get_positions()[:3]
    )
    assert scene.warnings == ["1 atom of the element X (number 0) left out"]
    assert scene.cell is None and scene.time is None
    assert scene.columns["element"].tolist() == ["O", "H", "H"]
    del water[3]
    water.set_cell([[5, 0, 0], [1, 6, 0], [0, 0, 7]])
    whole = hl.from_ase(water)
    assert whole.warnings == [] and whole.cell is not None
    assert np.array_equal(whole.cell[1], [[5, 0, 0], [1, 6, 0], [0, 0, 7]])
    assert scene.colors is not None and np.array_equal(
        scene.colors[0], np.array([1, 0.004024717, 0.004024717], "f4")
    )


def test_atoms_of_mdanalysis(pdb: Path) -> None:
    mda = pytest.importorskip("MDAnalysis")
    scene = hl.from_mdanalysis(mda.Universe(str(pdb)).select_atoms("not resname HOH"))
    expected = hl.read(pdb, select="not water")
    assert np.array_equal(scene.radii, expected.radii) and np.array_equal(
        scene.colors, expected.colors
    )
    # MDAnalysis has single precision.
    assert np.allclose(scene.centers, expected.centers, atol=1e-5)
    for word in ("name", "resname", "element"):
        assert scene.columns[word].tolist() == expected.columns[word].tolist(), word
    assert scene.columns["resid"].tolist() == expected.columns["resid"].tolist()


TIP4P = """water and a peptide, t= 0.5
   12
    1SOL     OW    1   1.000   1.000   1.000
    1SOL    HW1    2   1.095   1.000   1.000
    1SOL    HW2    3   0.976   1.093   1.000
    1SOL     MW    4   1.010   1.010   1.000
    2SOL     OW    5   2.000   1.000   1.000
    2SOL    HW1    6   2.095   1.000   1.000
    2SOL    HW2    7   1.976   1.093   1.000
    2SOL     MW    8   2.010   1.010   1.000
    3ALA      N    9   0.300   0.300   0.300
    3ALA     CA   10   0.440   0.300   0.300
    3ALA      C   11   0.500   0.440   0.300
    4CAL    CAL   12   2.500   2.500   2.500
   3.00000   3.00000   3.00000
"""


def test_virtual_sites_and_elements_of_mdanalysis_are_those_of_files(tmp_path: Path) -> None:
    mda = pytest.importorskip("MDAnalysis")
    path = tmp_path / "tip4p.gro"
    path.write_text(TIP4P)
    scene, expected = hl.from_mdanalysis(mda.Universe(str(path))), hl.read(path)
    assert len(scene) == len(expected) == 10
    assert np.array_equal(scene.radii, expected.radii)
    assert np.array_equal(scene.colors, expected.colors)
    # MDAnalysis has single precision.
    assert np.allclose(scene.centers, expected.centers, atol=1e-5)
    assert scene.warnings[-1] == expected.warnings[-1] == "2 virtual sites left out (2 `MW`)"
    assert scene.cell is not None and expected.cell is not None
    assert np.allclose(scene.cell[1], expected.cell[1], atol=1e-5)


def test_several_files_are_one_scene(tmp_path: Path) -> None:
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    first.write_text("x,y,z,radius\n0,0,0,1\n")
    second.write_text("x,y,z,radius\n0,0,0,2\n5,0,0,3\n")
    for added in (second, [second], [str(second)]):
        scene = hl.read(first, add=added, move={"file second": (0, 0, 7)})
        assert scene.radii.tolist() == [1, 2, 3]
        assert scene.centers.tolist() == [[0, 0, 0], [0, 0, 7], [5, 0, 7]]
    arrays = hl.particles.read(first, add=[second, second])
    assert arrays["file"].tolist() == ["first", "second", "second", "second-2", "second-2"]
    with pytest.raises(ValueError, match="move"):
        hl.read(first, move={"all": (1, 2)})


def test_frames_of_mdanalysis_have_their_times() -> None:
    mda = pytest.importorskip("MDAnalysis")
    files = pytest.importorskip("MDAnalysisTests.datafiles")
    # Elements of a PSF are the letters of its names; XTC has times and steps.
    universe = mda.Universe(files.PSF, files.DCD)
    scene = hl.from_mdanalysis(universe)
    known = set(np.unique(scene.radii))
    # H, C, N, O, S of Bondi, none of the 1.6 of unknown elements.
    assert known == {1.2, 1.7, 1.55, 1.52, 1.8} and len(scene) == universe.atoms.n_atoms
    universe = mda.Universe(files.GRO, files.XTC)
    universe.trajectory[2]
    expected = hl.read(files.XTC, topology=files.GRO, frame=3)
    scene = hl.from_mdanalysis(universe)
    assert len(scene) == len(expected) < universe.atoms.n_atoms
    assert np.array_equal(scene.radii, expected.radii)
    assert (scene.number, scene.time, scene.step) == (3, expected.time, expected.step)


@pytest.mark.parametrize("adapter", [hl.from_ase, hl.from_mdanalysis])
@pytest.mark.parametrize("wrong", [None, 3, "OHH"])
def test_other_objects_are_no_atoms(adapter: Any, wrong: Any) -> None:
    with pytest.raises(TypeError, match=r"is (None|3|'OHH'); give an"):
        adapter(wrong)
