"""Depth, ids and normals of a scene from many poses, in files that describe themselves.

python dataset.py                                 8 poses
python dataset.py --poses 1000 --size 640 480
python dataset_points.py dataset                  reads the files with NumPy only
"""

import json
from argparse import ArgumentParser, RawTextHelpFormatter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import halfline as hl

ABOUT = {
    "depth": "distance along the optical axis, metres; +inf on a miss",
    "id": "row of centers and radii in scene.npz; -1 on a miss",
    "normal": "unit normal in world axes, against the ray; 0, 0, 0 on a miss",
    "intrinsics": "pixels, [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; (0.5, 0.5) is the first centre",
    "pose": "camera to world, metres; the camera's axes are x right, y down, z forward",
}


def look_at_origin(eye: NDArray[np.float64]) -> NDArray[np.float64]:
    """The pose (3, 4) of a camera at `eye` that looks at the origin, with +z upward."""
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, (0, 0, 1)) / np.linalg.norm(forward[:2])
    return np.stack([right, np.cross(forward, right), forward, eye], axis=1)


def main() -> None:
    parser = ArgumentParser(description=__doc__, formatter_class=RawTextHelpFormatter)
    parser.add_argument("--poses", type=int, default=8)
    parser.add_argument("--size", type=int, nargs=2, default=(160, 120), help="columns and rows")
    parser.add_argument("-o", "--out", type=Path, default=Path("dataset"), help="the folder")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(1)
    scene = hl.Scene(random.uniform(-1, 1, (60, 3)), random.uniform(0.05, 0.3, 60))
    np.savez(given.out / "scene.npz", centers=scene.centers, radii=scene.radii)
    eyes = random.normal(size=(given.poses, 3))
    poses = [look_at_origin(5 * eye / np.linalg.norm(eye)) for eye in eyes]
    width, height = given.size
    lens = (1.2 * width, 1.2 * width, width / 2 - 3, height / 2 + 2)
    cameras = [hl.Camera.from_intrinsics(*lens, width, height, pose) for pose in poses]

    frames = hl.Renderer().render_many(scene, cameras, aovs=["depth", "id", "normal"])
    matrix = np.array([[lens[0], 0, lens[2]], [0, lens[1], lens[3]], [0, 0, 1]])
    for number, (pose, frame) in enumerate(zip(poses, frames, strict=True)):
        arrays: dict[str, Any] = {name: frame[name] for name in frame}
        arrays |= {"intrinsics": matrix, "pose": pose, "about": json.dumps(ABOUT)}
        np.savez_compressed(given.out / f"{number:05}.npz", **arrays)


if __name__ == "__main__":
    main()
