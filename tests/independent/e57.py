"""Scans of E57 that pye57 (libE57Format) writes, compared with the points and columns that halfline-particles reads.

    pip install pye57 numpy
    cargo build --release -p halfline-particles --example frames
    python tests/independent/e57.py target/release/examples/frames
"""

import json
import os
import subprocess
import sys
import tempfile

import numpy as np
import pye57

frames = os.path.abspath(sys.argv[1])
rng = np.random.default_rng(73)


def scan(count, has_colors):
    data = {f"cartesian{axis}": (rng.standard_normal(count) * 100).astype("f4") for axis in "XYZ"}
    data["intensity"] = rng.random(count).astype("f4")
    data["rowIndex"] = rng.integers(0, 50, count)
    data["columnIndex"] = rng.integers(0, 70, count)
    data["cartesianInvalidState"] = (rng.random(count) < 0.1).astype("i1") * 2
    if has_colors:
        data |= {f"color{name}": rng.integers(0, 256, count) for name in ["Red", "Green", "Blue"]}
    return data


def pose():
    """A unit quaternion, w first, and a translation."""
    turn = rng.standard_normal(4)
    return turn / np.linalg.norm(turn), rng.standard_normal(3) * 1000


def rotation(q):
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


files = points = columns = 0
worst = 0.0
with tempfile.TemporaryDirectory() as folder:
    for number in range(40):
        path = f"{folder}/{number}.e57"
        has_colors = number % 3 > 0
        scans = [(scan(int(rng.choice([1, 9, 500, 20_000])), has_colors), *pose()) for _ in range(1 + number % 3)]
        with pye57.E57(path, mode="w") as file:
            for data, turn, place in scans:
                file.write_scan_raw(data, rotation=turn, translation=place)
        done = subprocess.run([frames, path], capture_output=True, text=True)
        assert done.returncode == 0, (path, done.stderr)
        found = json.loads(done.stdout)
        stays = [data["cartesianInvalidState"] == 0 for data, *_ in scans]
        raw = [np.stack([data[f"cartesian{axis}"].astype("f8") for axis in "XYZ"], 1) for data, *_ in scans]
        placed = [p @ rotation(turn).T + place for p, (_, turn, place) in zip(raw, scans, strict=True)]
        expected = np.concatenate([p[s] for p, s in zip(placed, stays, strict=True)])
        got = np.array(found["positions"]).reshape(-1, 3)
        assert got.shape == expected.shape, path
        worst = max(worst, np.abs(got - expected).max(initial=0) / 1000)
        names = {"intensity": "intensity", "rowIndex": "row", "columnIndex": "column"}
        names |= {f"color{name}": name.lower() for name in ["Red", "Green", "Blue"]} if has_colors else {}
        for theirs, ours in names.items():
            values = np.concatenate([data[theirs][s] for (data, *_), s in zip(scans, stays, strict=True)])
            assert np.array_equal(np.array(found["columns"][ours], "f8"), values.astype("f8")), (path, theirs)
            columns += 1
        assert len(found["colors"]) == (len(expected) if has_colors else 0), path
        files += 1
        points += len(expected)
print(f"{files} files, {points} points, positions within {worst:.1e} of 1000, {columns} columns equal")
