"""What is read does not depend on what is selected, hidden, or not asked for."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import halfline as hl


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Two frames of 27 particles without radii; the second has a column ``q``."""

    def frame(number: int) -> str:
        atoms = [
            f"{k + 1} 1 {k % 3} {k // 3 % 3} {k // 9} {3 * (k % 2)} 0 0" + f" {k}" * (number == 2)
            for k in range(27)
        ]
        head = f"ITEM: TIMESTEP\n{number}\nITEM: NUMBER OF ATOMS\n27\nITEM: BOX BOUNDS pp pp pp\n"
        names = "id type x y z vx vy vz" + " q" * (number == 2)
        return f"{head}0 4\n0 4\n0 4\nITEM: ATOMS {names}\n" + "\n".join(atoms) + "\n"

    path = tmp_path / "run.dump"
    path.write_text(frame(1) + frame(2))
    return path


def test_the_radius_is_of_the_file(run: Path) -> None:
    radius = hl.read(run).radii[0]
    for select in ("velocity > 2", "id 1:4", "x > 1"):
        assert np.all(hl.read(run, select=select).radii == radius)
        assert np.all(hl.read(run, hide=select).radii == radius)
        for scene in hl.read_frames(run, select=select):
            assert np.all(scene.radii == radius)
    assert np.all(hl.read(run, clip=[(1, 0, 0, 0.5)]).radii == radius)


def test_a_length_is_a_column_everywhere(run: Path) -> None:
    scene = hl.read(run, color_by="velocity", keep=True)
    assert scene.columns["velocity"].max() == 3
    for kept in (scene, hl.read(run, keep=True), hl.read(run, keep=["velocity"])):
        assert np.count_nonzero(kept.select("velocity > 2")) == 13


def test_a_frame_needs_nothing_of_others(run: Path) -> None:
    scene = hl.read(run, frame=2, color_by="q", range=(0, 9))
    assert "frame 1 is not what the others are held to" in scene.warnings[0]
    with pytest.raises(ValueError, match="`q`"):
        hl.read(run, frame=1, color_by="q", range=(0, 9))


def test_planes_that_remove_all_say_so(run: Path) -> None:
    for cell in (False, True, 0.2):
        scene = hl.read(run, clip=[(1, 0, 0, -9)], cell=cell)
        assert any("removes all 27 spheres" in warning for warning in scene.warnings)


def test_a_transparent_picture_has_an_alpha(run: Path, cpu: hl.Renderer, tmp_path: Path) -> None:
    scene = hl.read(run)
    frame = cpu.render(scene, size=(40, 30), transparent=True)
    assert frame["alpha"].min() == 0 and frame["alpha"].max() == 1
    frame.save(tmp_path / "a.png")
    assert frame.to_png()[25] == 6, "RGBA"
    assert cpu.render(scene, size=(40, 30)).to_png()[25] == 2, "RGB"
    with pytest.raises(ValueError, match="exclude each other"):
        cpu.render(scene, transparent=True, background="white")


@pytest.mark.skipif(sys.platform != "linux", reason="a layer of Mesa")
def test_a_device_opens_without_a_word() -> None:
    hidden = ("XDG_RUNTIME_DIR", "DISPLAY", "NODEVICE_SELECT")
    variables = {name: value for name, value in os.environ.items() if name not in hidden}
    code = "import halfline as hl; hl.adapters(); hl.Renderer()"
    done = subprocess.run(
        [sys.executable, "-c", code], env=variables, capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stderr) == (0, "")
