"""Examples of the documentation run, and the types are right."""

import doctest
import importlib
import pkgutil
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

import halfline as hl

MODULES = [
    "halfline",
    *(f"halfline.{module.name}" for module in pkgutil.iter_modules(hl.__path__)),
]


@pytest.mark.parametrize("name", [name for name in MODULES if name != "halfline._halfline"])
def test_examples_in_docstrings(name: str) -> None:
    if name == "halfline.view":
        pytest.importorskip("anywidget", reason="anywidget is not installed")
    module = importlib.import_module(name)
    result = doctest.testmod(
        module, optionflags=doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL * 0
    )
    assert result.failed == 0


def test_everything_public_is_documented() -> None:
    for name in hl.__all__:
        found: Any = getattr(hl, name)
        if name in ("Aov", "__version__"):
            continue
        assert found.__doc__, name
        for member, value in vars(found).items() if isinstance(found, type) else ():
            if not member.startswith("_") and (
                callable(value) or isinstance(value, property | classmethod)
            ):
                text = value.__func__.__doc__ if isinstance(value, classmethod) else value.__doc__
                assert text, f"{name}.{member}"


def test_the_stub_names_what_the_module_has() -> None:
    stub = Path(hl.__file__).with_name("_halfline.pyi").read_text()
    native = importlib.import_module("halfline._halfline")
    for name in dir(native):
        if not name.startswith("__"):
            assert f"class {name}" in stub or f"def {name}(" in stub, name


EXAMPLE = """
import numpy as np
from numpy.typing import NDArray
import halfline as hl

scene = hl.Scene(np.zeros((3, 3)), 1.0, "red")
camera = hl.Camera((0, 0, 5), at=(0, 0, 0), vfov=45)
renderer = hl.Renderer("cpu")
frame = renderer.render(scene, camera, size=(64, 48), aovs=["color", "depth"], samples=4)
depth: NDArray[np.float64] = frame["depth"]
for other in renderer.render_many(scene, [camera], aovs="depth"):
    other.save("x.npy")
hits = renderer.trace(scene, (0, 0, 5), np.zeros((4, 3)) - 1)
t: NDArray[np.float64] = hits.t
for name, values in frame.items():
    print(name, values.dtype)
single = renderer.render(scene, camera, aovs="depth", dtype="float32", label="x", scale_bar="m")
K = np.eye(3)
hl.Camera.from_intrinsics(K=K, width=4, height=3, pose=np.eye(4))
chains: NDArray[np.str_] = scene.columns["chain"]
numbers, texts = scene.columns.categories("chain")
view = scene.view(camera, size=(640, 480), look="soft")
view.camera = camera
eye: list[float] = view.camera["eye"]
still: bytes = scene.with_colors({"all": "red"}).view().still + frame.to_png()
nearest: bool = bool(renderer.trace(scene, (0, 0, 5), [[0, 0, 1]], any=True).hit[0])
"""

WRONG = """
import halfline as hl
hl.Renderer("abacus")
hl.Renderer("cpu").render(hl.Scene([[0, 0, 0]], 1.0), sise=(3, 3))
hl.Renderer("cpu").render(hl.Scene([[0, 0, 0]], 1.0), aovs=["depht"])
"""


@pytest.mark.parametrize("work", [["check"], ["format", "--check"]])
def test_the_sources_have_the_form_of_ruff(work: list[str]) -> None:
    program = shutil.which("ruff", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip("ruff is not installed")
    scripts = [ROOT / "packaging" / name for name in ("archive", "check", "licenses")]
    command = [program, *work, "--no-cache", ROOT / "python", ROOT / "docs", *scripts]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_types_are_right_for_checkers(checker: str, tmp_path: Path) -> None:
    folder = Path(sys.executable).parent
    program = shutil.which(checker, path=str(folder))
    if program is None:
        pytest.skip(f"{checker} is not installed")
    good, wrong = tmp_path / "good.py", tmp_path / "wrong.py"
    good.write_text(EXAMPLE)
    wrong.write_text(WRONG)
    if checker == "mypy":
        strict = [
            program,
            "--strict",
            "--cache-dir",
            str(tmp_path / "cache"),
            "--python-executable",
            sys.executable,
        ]
        package = [*strict, "-p", "halfline"]
    else:
        strict = [program, "--pythonpath", sys.executable]
        (tmp_path / "pyrightconfig.json").write_text('{"typeCheckingMode": "strict"}')
        package = []
    done = subprocess.run([*strict, str(good)], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    done = subprocess.run([*strict, str(wrong)], capture_output=True, text=True, cwd=tmp_path)
    for line in (3, 4, 5):
        assert f"wrong.py:{line}" in done.stdout, done.stdout
    if package:
        done = subprocess.run(package, capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stdout
