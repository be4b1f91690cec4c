"""Sweeps of scanners and models of spheres: the same as the command's."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import SCENES, commands

import halfline as hl

SWEEP = "lidar:rings=6,vfov=-12..8,step=7.5,range=40"
EYE, VIEW, UP = (1.0, 1.5, 6.0), (0.0, -0.1, -1.0), (0.0, 1.0, 0.0)


def traced(pattern: str, tmp_path: Path) -> dict[str, np.ndarray]:
    """The arrays of the command."""
    words = [
        f"--{name}={','.join(map(str, vector))}"
        for name, vector in zip(("eye", "view", "up"), (EYE, VIEW, UP), strict=True)
    ]
    out = tmp_path / "hits.npz"
    done = subprocess.run(
        [
            commands()[0],
            "trace",
            str(SCENES / "weekend.toml"),
            "--pattern",
            pattern,
            *words,
            "--backend",
            "cpu",
            "-o",
            str(out),
        ],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return dict(np.load(out))


@pytest.mark.skipif(not commands(), reason="there is no command")
def test_sweeps_are_those_of_the_command(tmp_path: Path, cpu: hl.Renderer) -> None:
    scene = hl.read(SCENES / "weekend.toml")
    scanner = hl.Camera(EYE, view=VIEW, up=UP)
    expected = traced(SWEEP, tmp_path)
    hits = cpu.scan(scene, SWEEP, scanner)
    assert isinstance(hits, hl.Hits) and hits.id.shape == (6, 48) and 20 < hits.hit.sum() < 288
    for name in ("id", "t", "distance", "normal", "position", "certainty"):
        found = getattr(hits, name)
        assert np.array_equal(expected[name].reshape(found.shape), found, equal_nan=True), name
    for more in (",divergence=0.4,returns=3", ",noise=0.1,seed=4", ",divergence=1,noise=0.02"):
        expected = traced(SWEEP + more, tmp_path)
        echoes = cpu.scan(scene, SWEEP + more, scanner)
        assert isinstance(echoes, hl.Echoes) and len(echoes.id) > 20
        for name in ("id", "distance", "position", "intensity", "certainty"):
            assert np.array_equal(expected[name], getattr(echoes, name)), (more, name)
        assert np.array_equal(expected["ring"], echoes.beam[:, 0])
        assert np.array_equal(expected["column"], echoes.beam[:, 1])
        assert np.array_equal(expected["return_number"], echoes.returns[:, 0])
    with pytest.raises(ValueError, match="no pattern"):
        cpu.scan(scene, "sonar", scanner)
    with pytest.raises(ValueError, match="pattern is 3"):
        cpu.scan(scene, 3, scanner)  # type: ignore[arg-type]


@pytest.mark.skipif(not commands(), reason="there is no command")
def test_models_are_those_of_the_command(tmp_path: Path) -> None:
    scene = hl.read(SCENES / "weekend.toml")
    scene.save(tmp_path / "a.glb")
    done = subprocess.run(
        [
            commands()[0],
            "render",
            str(SCENES / "weekend.toml"),
            "--backend",
            "cpu",
            "-o",
            str(tmp_path / "b.glb"),
        ],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
    with pytest.raises(ValueError, match="cannot hold spheres; use the file name extension"):
        scene.save(tmp_path / "a.obj")
