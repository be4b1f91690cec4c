"""Numbers of neighbours in a periodic cell, counted by SciPy.

    pip install numpy scipy
    python tests/independent/neighbors.py path/to/halfline
"""
import json, os, subprocess, sys, tempfile

import numpy as np
from scipy.spatial import cKDTree

halfline = os.path.abspath(sys.argv[1])
COUNT, SIDE, REACH = 200_000, 60.0, 1.5


def selected(expression):
    """The number of particles that an expression selects."""
    command = [halfline, "render", "cloud.xyz", "--radius", "0.1", "--select", expression, "--size", "8x8", "--backend", "cpu"]
    result = subprocess.run([*command, "--look", "plain", "--json", "--aov", "id=i.npy"], check=True, capture_output=True)
    return json.loads(result.stdout)["spheres"]


points = np.random.default_rng(1).uniform(0, SIDE, (COUNT, 3))
expected = cKDTree(points, boxsize=SIDE).query_ball_point(points, REACH, return_length=True, workers=-1) - 1
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    with open("cloud.xyz", "w") as file:
        cell = " ".join(map(str, (np.eye(3) * SIDE).ravel()))
        file.write(f'{COUNT}\nLattice="{cell}" Properties=species:S:1:pos:R:3 pbc="T T T"\n')
        np.savetxt(file, points, fmt="Ar %.17g %.17g %.17g")
    for number in range(expected.max() + 2):
        assert selected(f"coordination:{REACH} = {number}") == (expected == number).sum(), number
    print(f"{COUNT} particles, {expected.min()} to {expected.max()} neighbours: equal")
    os.chdir("/")
