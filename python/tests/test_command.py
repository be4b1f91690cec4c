"""The command of the wheel is the command of the crate."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import SCENES, commands, run

import halfline as hl


@pytest.mark.parametrize("command", commands())
def test_exit_codes_and_words(command: str, tmp_path: Path) -> None:
    assert run(command, "--version").stdout == f"halfline {hl.__version__}\n"
    assert "Usage: halfline render" in run(command, "render", "--help").stdout
    assert "halfline render needs a file" in run(command, "render", code=2).stderr
    assert "unexpected argument" in run(command, "render", "--nonsense", code=2).stderr
    assert '"kind":"io"' in run(command, "render", tmp_path / "none.toml", "--json", code=8).stdout
    a, b = tmp_path / "a.npy", tmp_path / "b.npy"
    for file, size in ((a, "8x8"), (b, "8x9")):
        run(
            command,
            "render",
            SCENES / "inside.toml",
            f"--aov=depth={file}",
            "--backend",
            "cpu",
            "--size",
            size,
        )
    run(command, "compare", a, a)
    run(command, "compare", a, b, code=2 if "shape" in run_any(command, a, b) else 1)


def test_the_module_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "halfline", "--version"], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, f"halfline {hl.__version__}\n")
    bad = subprocess.run([sys.executable, "-m", "halfline", "--nonsense"], capture_output=True)
    assert bad.returncode == 2


def run_any(command: str, *files: Path) -> str:
    done = subprocess.run([command, "compare", *map(str, files)], capture_output=True, text=True)
    return "shape" if done.returncode == 2 else done.stderr


def test_a_name_that_is_not_text_arrives_unchanged(tmp_path: Path) -> None:
    if sys.platform != "linux":
        pytest.skip("names of files are text there")
    name = os.fsencode(tmp_path) + b"/\xff.toml"
    Path(os.fsdecode(name)).write_bytes((SCENES / "inside.toml").read_bytes())
    done = subprocess.run([commands()[0].encode(), b"info", name], capture_output=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("command", commands())
def test_ctrl_c_ends_the_command(command: str, tmp_path: Path) -> None:
    arguments = [
        "render",
        str(SCENES / "weekend.toml"),
        "-o",
        str(tmp_path / "x.png"),
        "--backend",
        "cpu",
    ]
    child = subprocess.Popen(
        [command, *arguments, "--size", "5000x5000", "--accuracy", "exact"], stderr=subprocess.PIPE
    )
    time.sleep(1.5)
    child.send_signal(signal.SIGINT)
    start = time.monotonic()
    assert child.wait(10) == 130 and time.monotonic() - start < 3
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of Unix")
@pytest.mark.parametrize("command", commands())
def test_a_closed_pipe_is_an_error_of_output(command: str) -> None:
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [command, "info", str(SCENES / "weekend.toml")],
        stdout=write,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(write)
    assert done.returncode == 8, done.stderr
