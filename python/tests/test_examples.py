"""The scripts of python/examples run as users run them; their answers are compared with NumPy's.

The truth is the ray-sphere formula below in float64. Its own error is a few units of 2^-53 times
(distance / radius)^2 at worst, far below the tolerances, which are those that halfline promises.
"""

import json
import os
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT
from numpy.typing import NDArray

import halfline as hl

EXAMPLES = ROOT / "python" / "examples"

# The relative error of a distance that a certified answer may have.
TOLERANCE = 1e-5

# The angle in radians that a certified normal may be off.
NORMAL = 1e-3

# Bondi's radii in angstrom (J. Phys. Chem. 68, 441, 1964).
BONDI = {"H": 1.20, "C": 1.70, "O": 1.52}

Floats = NDArray[np.float64]


def example(name: str, *arguments: object, folder: Path) -> str:
    """Runs a script in a folder, and returns what it printed."""
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr.replace("DeprecationWarning", ""), done.stderr
    return done.stdout


def needs(package: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(find_spec(package) is None, reason=f"{package} is not installed")


def nearest(origins: Floats, rays: Floats, centers: Floats, radii: Floats) -> tuple[Any, Floats]:
    """Index (-1 on a miss) and distance of the first sphere that each ray of length 1 meets.

    With the foot of the centre on the ray, h^2 = |o + b d - c|^2 is free of the cancellation of
    b^2 - |o - c|^2 (Hearn and Baker; Haines et al., Ray Tracing Gems, chapter 7).
    """
    ids, best = np.full(len(rays), -1), np.full(len(rays), np.inf)
    for number, (center, radius) in enumerate(zip(centers, radii, strict=True)):
        toward = center - origins
        foot = (toward * rays).sum(axis=-1)
        apart = toward - foot[:, np.newaxis] * rays
        inside = radius**2 - (apart**2).sum(axis=-1)
        half = np.sqrt(np.maximum(inside, 0))
        # (|f|^2 - r^2) / (b + half) is b - half without its cancellation, for spheres of any size.
        power = (toward**2).sum(axis=-1) - radius**2
        near = np.where(foot + half > 0, power / (foot + half), np.inf)
        t = np.where(near > 0, near, foot + half)
        hit = (inside >= 0) & (t > 0) & (t < best)
        ids, best = np.where(hit, number, ids), np.where(hit, t, best)
    return ids, best


def camera_rays(camera: dict[str, Any], size: tuple[int, int]) -> tuple[Floats, Floats, Floats]:
    """Eye, view axis and rays of length 1 (rows * columns, 3) through the centres of pixels."""
    lens, eye = camera["intrinsics"], np.array(camera["eye"], float)
    forward = np.array(camera["view"]) / np.linalg.norm(camera["view"])
    right = np.cross(forward, camera["up"])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    x = (np.arange(size[0]) + 0.5 - lens["cx"]) / lens["fx"]
    y = (np.arange(size[1]) + 0.5 - lens["cy"]) / lens["fy"]
    columns, rows = np.meshgrid(x, y)
    rays = forward + columns.reshape(-1, 1) * right + rows.reshape(-1, 1) * down
    return eye, forward, rays / np.linalg.norm(rays, axis=1, keepdims=True)


def picture(path: Path) -> Any:
    """The pixels of a PNG."""
    return np.asarray(
        pytest.importorskip("PIL.Image", reason="Pillow is not installed").open(path)
    )


@needs("ase")
def test_molecule(tmp_path: Path) -> None:
    molecule: Any = import_module("ase.build").molecule
    printed = example("molecule.py", "--size", 96, folder=tmp_path)
    atoms = molecule("CH3CH2OH")
    depth = np.load(tmp_path / "molecule-depth.npy")
    assert depth.shape == (96, 96) and depth.dtype == np.float64
    assert (
        printed.startswith(f"{len(atoms)} atoms")
        and f"in {np.isfinite(depth).sum()} pixels" in printed
    )

    # The camera is an input, not an answer: the numbers that the script gave to Camera.fit.
    scene = hl.from_ase(atoms)
    fitted = hl.Camera.fit(scene, view=(-0.5, -0.3, -1), size=(96, 96)).record((96, 96))
    eye, forward, rays = camera_rays(fitted, (96, 96))
    radii = np.array([BONDI[symbol] for symbol in atoms.get_chemical_symbols()])
    ids, distance = nearest(eye, rays, atoms.get_positions(), radii)
    expected = np.where(ids < 0, np.inf, distance * (rays @ forward)).reshape(96, 96)
    assert np.array_equal(np.isfinite(depth), np.isfinite(expected))
    hits = np.isfinite(depth)
    assert np.abs(depth[hits] / expected[hits] - 1).max() < TOLERANCE

    pixels = picture(tmp_path / "molecule.png")
    assert pixels.shape == (96, 96, 3) and (pixels[0, 0] == 255).all()
    # Oxygen is red (Jmol's #ff0d0d), so some of its pixels are.
    red = (pixels[..., 0] > 2.0 * pixels[..., 1]) & (pixels[..., 0] > 150)
    oxygen = atoms.get_chemical_symbols().index("O")
    assert (
        red.sum() > 20 and np.isin(np.flatnonzero(red), np.flatnonzero(ids == oxygen)).mean() > 0.9
    )


@needs("MDAnalysis")
def test_trajectory(tmp_path: Path) -> None:
    assert example("trajectory.py", folder=tmp_path).startswith("8 pictures of 12 atoms")
    names = sorted(path.name for path in tmp_path.glob("*.png"))
    assert names == [f"film.{number:04}.png" for number in range(8)]
    film = [picture(tmp_path / name) for name in names]
    assert all(pixels.shape == (240, 320, 3) for pixels in film)
    # The camera of all frames is an input: it shows the atoms wherever they will be.
    rings = [ring(number) for number in range(8)]
    everything = hl.Scene(np.concatenate(rings).astype(np.float32), BONDI["C"])
    fitted = hl.Camera.fit(everything, view=(-1, -0.5, -1), size=(320, 240)).record((320, 240))
    eye, _, rays = camera_rays(fitted, (320, 240))
    for atoms, pixels in zip(rings, film, strict=True):
        ids, _ = nearest(eye, rays, atoms, np.full(12, BONDI["C"]))
        covered = (ids >= 0).reshape(240, 320)
        # Samples lie within half a pixel of the centre, and the line along an edge is drawn on
        # pixels of both sides: three pixels from the edge the pixel is atom or background.
        assert (pixels[shrunk(covered, 3)] < 255).all() and (
            pixels[shrunk(~covered, 3)] == 255
        ).all()
        # Nothing leaves the picture.
        assert not (covered[0].any() or covered[-1].any() or covered[:, [0, -1]].any())


def ring(frame: int) -> Floats:
    """The atoms of trajectory.py: 12 on a circle of radius 3, which opens along z."""
    angle = np.arange(12) * np.pi / 6
    return np.stack([3 * np.cos(angle), 3 * np.sin(angle), 0.1 * frame * np.arange(12)], axis=-1)


def shrunk(mask: NDArray[np.bool_], by: int) -> Any:
    """The pixels of the mask that are at least so many columns and rows from others."""
    columns = np.logical_and.reduce([np.roll(mask, shift, axis=1) for shift in range(-by, by + 1)])
    return np.logical_and.reduce([np.roll(columns, shift, axis=0) for shift in range(-by, by + 1)])


@needs("MDAnalysis")
@needs("MDAnalysisTests")
def test_trajectory_of_files(tmp_path: Path) -> None:
    files: Any = import_module("MDAnalysisTests.datafiles")
    arguments = [
        files.PSF,
        files.DCD,
        "--select",
        "name CA",
        "--step",
        40,
        "--size",
        64,
        48,
        "-o",
        "adk",
    ]
    # Adenylate kinase has 214 residues, and the file 98 frames.
    assert example("trajectory.py", *arguments, folder=tmp_path).startswith(
        "3 pictures of 214 atoms"
    )
    assert sorted(path.name for path in tmp_path.glob("*.png")) == [
        f"adk.{number:04}.png" for number in (0, 40, 80)
    ]
    # Carbon is grey.
    assert np.ptp(picture(tmp_path / "adk.0040.png").astype(int), axis=2).max() == 0


def test_dataset(tmp_path: Path) -> None:
    example("dataset.py", "--poses", 3, "--size", 80, 60, "-o", "some", folder=tmp_path)
    folder = tmp_path / "some"
    assert sorted(path.name for path in folder.iterdir()) == [
        "00000.npz", "00001.npz", "00002.npz", "scene.npz",
    ]  # fmt: skip
    with np.load(folder / "scene.npz") as file:
        centers, radii = file["centers"], file["radii"]
    total = 0
    for path in sorted(folder.glob("0*.npz")):
        with np.load(path) as file:
            found = {name: file[name] for name in file}
        assert set(json.loads(str(found["about"]))) == set(found) - {"about"}
        pose, lens = found["pose"], found["intrinsics"]
        rotation, eye = pose[:, :3], pose[:, 3]
        assert np.allclose(rotation.T @ rotation, np.eye(3)) and np.linalg.det(rotation) > 0
        # By the definition of the pinhole camera, not by the code of the reader.
        columns, rows = np.meshgrid(np.arange(80) + 0.5, np.arange(60) + 0.5)
        local = np.linalg.solve(lens, np.stack([columns.ravel(), rows.ravel(), np.ones(4800)])).T
        lengths = np.linalg.norm(local, axis=1)
        ids, distance = nearest(eye, (local / lengths[:, np.newaxis]) @ rotation.T, centers, radii)
        assert np.array_equal(found["id"].ravel(), ids)
        depth, expected = found["depth"].ravel(), distance / lengths
        hits = ids >= 0
        assert np.isposinf(depth[~hits]).all() and hits.any()
        assert np.abs(depth[hits] / expected[hits] - 1).max() < TOLERANCE
        points = eye + (local @ rotation.T * expected[:, np.newaxis])[hits]
        normals = (points - centers[ids[hits]]) / radii[ids[hits], np.newaxis]
        normal = found["normal"].reshape(-1, 3)
        assert (normal[~hits] == 0).all()
        assert np.linalg.norm(normal[hits] - normals, axis=1).max() < NORMAL
        total += hits.sum()

    said = example("dataset_points.py", folder, folder=tmp_path)
    count, gap = int(said.split()[0]), float(said.split()[4])
    # A point that is off by a share of its distance, 7 m at most, is off its sphere by no more.
    assert count == total and gap < 7 * TOLERANCE


def test_the_reader_sees_what_is_wrong(tmp_path: Path) -> None:
    example("dataset.py", "--poses", 1, "-o", "some", folder=tmp_path)
    path = tmp_path / "some" / "00000.npz"
    with np.load(path) as file:
        found: dict[str, Any] = {name: file[name] for name in file}
    # A principal point that is half a pixel off, as with another convention of pixel centres.
    found["intrinsics"][0, 2] += 0.5
    np.savez(path, **found)
    said = example("dataset_points.py", "some", folder=tmp_path)
    assert float(said.split()[4]) > 1e-3


def test_lidar(tmp_path: Path) -> None:
    printed = example("lidar.py", "--rings", 8, "--beams", 90, folder=tmp_path)
    with np.load(tmp_path / "sweep.npz") as file:
        beams, ranges, ids = file["beams"], file["range"], file["id"]
    assert beams.shape == (8, 90, 3) and ranges.shape == ids.shape == (8, 90)
    assert np.allclose(np.linalg.norm(beams, axis=-1), 1)

    random = np.random.default_rng(2)
    radii = random.uniform(0.2, 2.0, 200)
    boulders = np.column_stack([random.uniform(-50, 50, (200, 2)), 0.5 * radii])
    eye = np.array([0, 0, 1.8])
    rays = beams.reshape(-1, 3)
    expected, distance = nearest(eye, rays, boulders, radii)
    # The ground in closed form: the smaller root of t^2 + 2 b t + c = 0 as c / (-b + sqrt), with
    # c = (1.8 + R)^2 - R^2 = 1.8 (1.8 + 2 R), which does not cancel.
    planet = 6_371_000.0
    b, c = rays[:, 2] * (1.8 + planet), 1.8 * (1.8 + 2 * planet)
    with np.errstate(invalid="ignore"):
        ground = c / (-b + np.sqrt(b * b - c))
    first = (b < 0) & (b * b > c) & (ground < distance)
    expected = np.where(first, 0, np.where(expected >= 0, expected + 1, -1))
    distance = np.where(first, ground, distance)
    expected, distance = (
        np.where(distance < 80, expected, -1),
        np.where(distance < 80, distance, np.inf),
    )
    assert np.array_equal(ids.ravel(), expected)
    hits = expected >= 0
    assert (expected == 0).any() and (expected > 0).any() and (~hits).any()
    assert np.isposinf(ranges.ravel()[~hits]).all()
    assert np.abs(ranges.ravel()[hits] / distance[hits] - 1).max() < TOLERANCE

    head, _, body = (tmp_path / "sweep.ply").read_bytes().partition(b"end_header\n")
    assert f"element vertex {hits.sum()}\n".encode() in head
    points = np.frombuffer(body, "<f8, <f8, <f8, <f8, <i4")
    assert np.array_equal(points["f4"], expected[hits])
    xyz = np.stack([points["f0"], points["f1"], points["f2"]], axis=-1)
    assert np.allclose(
        xyz, eye + rays[hits] * distance[hits, np.newaxis], rtol=0, atol=80 * TOLERANCE
    )
    assert printed.startswith(
        f"720 beams, {hits.sum()} returns, {(expected == 0).sum()} of the ground"
    )
    proved, settled = (int(text.split()[0]) for text in printed.splitlines()[1].split(", "))
    assert proved + settled == 720


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_types_of_the_examples(checker: str, tmp_path: Path) -> None:
    program = Path(sys.executable).parent / (checker + (".exe" if os.name == "nt" else ""))
    if not program.exists():
        pytest.skip(f"{checker} is not installed")
    # Without a package its example has nothing to check.
    packages = {"molecule": "ase", "trajectory": "MDAnalysis"}
    files = [
        str(path)
        for path in sorted(EXAMPLES.glob("*.py"))
        if path.stem not in packages or find_spec(packages[path.stem]) is not None
    ]
    if checker == "mypy":
        cache = str(tmp_path / "cache")
        options = ["--strict", "--cache-dir", cache, "--python-executable", sys.executable]
    else:
        (tmp_path / "pyrightconfig.json").write_text('{"typeCheckingMode": "strict"}')
        options = ["--pythonpath", sys.executable]
    done = subprocess.run(
        [program, *options, *files], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_examples_are_short() -> None:
    files = sorted(EXAMPLES.glob("*.py"))
    assert len(files) == 5
    for path in files:
        assert len(path.read_text().splitlines()) < 60, path.name
