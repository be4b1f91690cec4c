"""Hits of curved lenses, projected by OpenCV to the centres of their pixels.

    pip install numpy opencv-python-headless
    python tests/independent/cameras.py path/to/halfline
"""
import json, os, subprocess, sys, tempfile

import cv2, numpy as np

halfline = os.path.abspath(sys.argv[1])
WIDTH, HEIGHT = 160, 120

# Half a pixel is the difference of halfline's centre of the first pixel, 0.5, and OpenCV's, 0.
K = np.array([[90, 0, 81.3], [0, 91, 58.2], [0, 0, 1.0]])
K_OF_OPENCV = K - np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])

LENSES = {
    "rational": ([-0.25, 0.08, 0.002, -0.001, -0.01, 0.03, -0.01, 0.001], False),
    "five coefficients": ([-0.2, 0.05, 0.001, 0.0005, -0.004], False),
    "fisheye": ([0.03, -0.01, 0.004, -0.0007], True),
}

# Positions are rounded in f64 at lengths of 30 radii: 1e-14 of a focal length, a hundred times less than this, in pixels.
MOST = 1e-10


def positions(camera):
    """The positions of all hits, and the columns and rows of their pixels."""
    with open("list.json", "w") as file:
        json.dump([camera], file)
    command = [halfline, "render", "cloud.npy", "--cameras", "list.json", "--size", f"{WIDTH}x{HEIGHT}", "--backend", "cpu"]
    subprocess.run([*command, "--aov", "position=p%d.npy", "--aov", "id=i%d.npy"], check=True, stderr=subprocess.DEVNULL)
    rows, columns = np.nonzero(np.load("i1.npy") >= 0)
    return np.load("p1.npy")[rows, columns], np.c_[columns, rows]


rng = np.random.default_rng(5)
centers = rng.normal(size=(3000, 3))
centers *= rng.uniform(8, 30, (3000, 1)) / np.linalg.norm(centers, axis=1, keepdims=True)
rotation, eye = cv2.Rodrigues(np.array([0.3, -0.5, 0.2]))[0], np.array([0.5, -0.4, 0.3])
pose = np.r_[np.c_[rotation, eye], [[0, 0, 0, 1]]]
rvec, tvec = cv2.Rodrigues(rotation.T)[0], -rotation.T @ eye
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    np.save("cloud.npy", np.c_[centers, rng.uniform(0.3, 1.5, 3000)])
    for name, (coefficients, is_fisheye) in LENSES.items():
        camera = {"pose": pose.tolist(), "K": K.tolist(), "w": WIDTH, "h": HEIGHT, "dist": coefficients}
        points, pixels = positions({**camera, "is_fisheye": is_fisheye})
        project = cv2.fisheye.projectPoints if is_fisheye else cv2.projectPoints
        found, _ = project(points.reshape(-1, 1, 3), rvec, tvec, K_OF_OPENCV, np.array(coefficients))
        apart = np.abs(found.reshape(-1, 2) - pixels).max()
        assert len(points) > 10_000 and apart < MOST, (name, len(points), apart)
        print(f"{name}: {len(points)} hits, at most {apart:.1e} pixels beside the centre")
    os.chdir("/")
