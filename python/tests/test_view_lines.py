"""The Python that the page of ``halfline view`` copies renders the picture that the page shows."""

import json
import os
import random
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from conftest import EVERYTHING, commands

TABLE = (
    "x,y,z,radius,kind,speed\n0,0,0,1,a,0.5\n2,0,0,0.7,b,1.5\n0,2,0,0.5,a,2.5\n1,1,1,0.6,c,-1\n"
)
ATOMS = """3
Lattice="4 0 0 0 4 0 0 0 4" Properties=species:S:1:pos:R:3
C 1 1 1
O 2 1 1
H 5 1 1
"""

OF_ALL = [
    ["--transparent"],
    ["--background=teal"],
    ["--background=0.2,0.3,0.4"],
    ["--samples=9"],
    ["--seed=4"],
    ["--exposure=-0.5"],
    ["--tone=soft"],
    ["--shade=normal"],
    ["--look=plain"],
    ["--look=figure"],
    ["--occlusion=8"],
    ["--occlusion", "--reach=3"],
    ["--sun=-1,2,3", "--sun=0,1,0"],
    ["--shadows"],
    ["--silhouette"],
    ["--outline-width=3"],
    ["--outline-color=teal"],
    ["--outline-color=0.2,0.3,0.4"],
    ["--depth-cue"],
    ["--radius=0.4"],
    ["--radius=x > 0.5=0.7", "--radius=0.3"],
    ["--radius-scale=1.5"],
    ["--color=teal"],
    ["--color=x > 0.5=1,0.2,0", "--color=y > 1=gold"],
    ["--color-by=x", "--map=plasma", "--range=-1,2", "--legend-in"],
    ["--label={count} it's {file}"],
    ["--scale-bar"],
    ["--scale-bar=nm"],
    ["--clip=0,0,1,2", "--clip=1,0,0,4.5"],
    ["--hide=x > 3"],
    ["--select=x < 3", "--select=y > 1"],
    ["--bits=16"],
    ["--zoom=2"],
    ["--aperture=0.3", "--focus-distance=9", "--samples=4"],
    ["--accuracy=exact"],
    ["--tolerance=1e-4"],
    ["--method=f64"],
]
OF_TABLE = [["--format=csv"], ["--skip-invalid"], ["--color-by=speed", "--log"]]
OF_ATOMS = [
    ["--cell"],
    ["--cell=0.1"],
    ["--outline"],
    ["--copies=2,1,1"],
    ["--wrap"],
    ["--radii=covalent"],
]
CLASHES = [
    {"--transparent", "--background"},
    {"--method", "--accuracy", "--tolerance"},
    {"--color", "--color-by"},
    {"--cell", "--outline"},
]


@contextmanager
def page(folder: Path, words: list[str], **more: str) -> Iterator[Any]:
    """A running page; asks it."""
    command = [commands()[0], "view", *words, "--backend=cpu", "--port=0", "--no-open"]
    with subprocess.Popen(
        command, cwd=folder, env={**os.environ, **more}, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        address, _, token = process.stdout.readline().strip().partition("/#")

        def ask(route: str, body: Any) -> bytes:
            headers = {"Authorization": f"Bearer {token}"}
            request = urllib.request.Request(address + route, json.dumps(body).encode(), headers)
            with urllib.request.urlopen(request) as reply:
                answer: bytes = reply.read()
                return answer

        try:
            yield ask
        finally:
            process.kill()


def check(folder: Path, file: str, words: list[str], **more: str) -> None:
    with page(folder, [file, *words], **more) as ask:
        scene = json.loads(ask("/scene", {}))
        body: dict[str, Any] = {"camera": scene["camera"], "size": [200, 150], "mode": "still"}
        for select in (None, "x > 0.5"):
            body["select"] = select
            picture, lines = ask("/frame", body), json.loads(ask("/command", body))["python"]
            assert "no keyword" not in lines, lines
            run = subprocess.run([sys.executable, "-c", lines], cwd=folder, capture_output=True)
            assert run.returncode == 0, (lines, run.stderr)
            saved = folder / f"{Path(file).stem}-view.png"
            assert saved.read_bytes() == picture, lines
            saved.unlink()


@pytest.mark.parametrize("seed", range(40 if EVERYTHING else 6))
def test_drawn_options_are_those_of_the_page(seed: int, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(TABLE)
    (tmp_path / "cell.xyz").write_text(ATOMS)
    draw = random.Random(seed)
    file = ["t.csv", "cell.xyz"][seed % 2]
    options = OF_ALL + (OF_TABLE if file == "t.csv" else OF_ATOMS)
    words: list[str] = []
    for option in draw.sample(options, 4):
        names = {word.partition("=")[0] for word in option}
        known = {word.partition("=")[0] for word in words}
        clashes = any(len(pair & (names | known)) > 1 for pair in CLASHES)
        if not (names & known or clashes):
            words += option
    check(tmp_path, file, words)


@pytest.mark.parametrize(
    ("preferences", "words"),
    [
        ({"HALFLINE_TRANSPARENT": "yes"}, []),
        ({"config": "transparent = true"}, ["--background=white"]),
        ({"config": "background = 'white'"}, ["--transparent"]),
        ({"config": "samples = 9\nshadows = true", "HALFLINE_SAMPLES": "4"}, []),
        ({"HALFLINE_SAMPLES": "9", "HALFLINE_SHADOWS": "true", "HALFLINE_SILHOUETTE": "off"}, []),
        ({"HALFLINE_LOOK": "figure", "HALFLINE_QUIET": "1"}, ["--look=plain"]),
    ],
)
def test_preferences_of_the_command_are_in_the_lines(
    preferences: dict[str, str], words: list[str], tmp_path: Path
) -> None:
    (tmp_path / "t.csv").write_text(TABLE)
    (tmp_path / "c.toml").write_text(preferences.get("config", ""))
    check(tmp_path, "t.csv", words, HALFLINE_CONFIG=str(tmp_path / "c.toml"), **preferences)


def test_a_name_that_is_not_text_is_copied_by_its_bytes(tmp_path: Path) -> None:
    if sys.platform != "linux":
        pytest.skip("names of files are text there")
    name = os.fsdecode(b"a \xff'.csv")
    (tmp_path / name).write_text(TABLE)
    check(tmp_path, name, [])
