"""What the tests share: renderers, scenes, the command."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import halfline as hl

# Packages whose tests only `tests/run --all` runs, and packages whose tests `--ci` also runs.
# They are hidden where they are installed too, so that a run does not depend on the machine.
ECOSYSTEM = ("ase", "MDAnalysis", "MDAnalysisTests", "h5py", "zarr", "pyarrow", "dask")
ECOSYSTEM += ("distributed", "mpi4py", "openpmd_api")
CHECKED = (
    "anywidget",
    "nbclient",
    "nbformat",
    "PIL",
    "xarray",
    "Pillow",
    "mypy",
    "pyright",
    "ruff",
)
LEVEL = os.environ.get("HALFLINE_TESTS", "ci")
EVERYTHING = LEVEL == "all"
LEFT = {"all": (), "ci": ECOSYSTEM, "": ECOSYSTEM + CHECKED}[LEVEL]
for name in LEFT:
    # Importing it fails, as if it were not installed.
    sys.modules[name] = None  # type: ignore[assignment]

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "scenes"


@pytest.fixture(scope="session")
def cpu() -> hl.Renderer:
    """The CPU path, which is on every machine."""
    return hl.Renderer("cpu")


@pytest.fixture(scope="session", params=["cpu", "gpu"])
def renderer(request: pytest.FixtureRequest) -> hl.Renderer:
    """The CPU path and an adapter."""
    if request.param == "gpu" and os.environ.get("HALFLINE_NO_GPU"):
        pytest.skip("HALFLINE_NO_GPU is set")
    return hl.Renderer(request.param)


@pytest.fixture(scope="session")
def cloud() -> hl.Scene:
    """Coloured spheres that overlap."""
    random = np.random.default_rng(1)
    return hl.Scene(
        random.normal(size=(500, 3)), random.uniform(0.02, 0.3, 500), random.uniform(size=(500, 3))
    )


def commands() -> list[str]:
    """The command of the wheel, and the one that cargo built, if HALFLINE names it."""
    own = shutil.which("halfline", path=str(Path(sys.executable).parent))
    assert own is not None, "the wheel has a command"
    return [own, *filter(None, [os.environ.get("HALFLINE")])]


def run(command: str, *arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Runs the command, which ends with this exit code."""
    done = subprocess.run(
        [command, *map(str, arguments)], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == code, done.stderr
    return done


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Prints the counts as the tests of the library do, for tests/run."""
    counts = {
        name: len(terminalreporter.getreports(name))
        for name in ("passed", "failed", "error", "skipped")
    }
    for report in terminalreporter.getreports("skipped"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        left = any(name in str(reason) for name in LEFT)
        counts["skipped"] -= left
        kind = "--all" if any(name in str(reason) for name in ECOSYSTEM) else "--ci"
        words = f"LEFT OUT: tests with packages that {kind} installs" if left else "SKIPPED:"
        terminalreporter.write_line(
            words if left else f"{words} {report.nodeid.rpartition('/')[2]}: {reason}"
        )
    failed = counts["failed"] + counts["error"]
    terminalreporter.write_line(
        f"test result: {'FAILED' if failed else 'ok'}. {counts['passed']} passed; {failed} failed;"
        f" {counts['skipped']} ignored"
    )
