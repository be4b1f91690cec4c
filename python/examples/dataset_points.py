"""Reads the files of dataset.py: turns depth into points, and checks them against the spheres.

python dataset_points.py dataset
"""

from argparse import ArgumentParser, RawTextHelpFormatter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def points(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The points (n, 3) in the world that a file's depth shows, and the spheres they are on."""
    with np.load(path) as file:
        depth, ids, lens, pose = (file[name] for name in ("depth", "id", "intrinsics", "pose"))
    rows, columns = np.nonzero(np.isfinite(depth))
    z = depth[rows, columns]
    x = (columns + 0.5 - lens[0, 2]) / lens[0, 0] * z
    y = (rows + 0.5 - lens[1, 2]) / lens[1, 1] * z
    return np.stack([x, y, z], axis=-1) @ pose[:, :3].T + pose[:, 3], ids[rows, columns]


def main() -> None:
    parser = ArgumentParser(description=__doc__, formatter_class=RawTextHelpFormatter)
    parser.add_argument("folder", type=Path, help="the folder that dataset.py wrote")
    folder: Path = parser.parse_args().folder
    with np.load(folder / "scene.npz") as scene:
        centers, radii = scene["centers"], scene["radii"]
    worst, count = 0.0, 0
    for path in sorted(folder.glob("[0-9]*.npz")):
        found, ids = points(path)
        gaps = np.abs(np.linalg.norm(found - centers[ids], axis=1) - radii[ids])
        worst, count = max(worst, gaps.max(initial=0)), count + len(found)
    print(f"{count} points, at most {worst:.1e} m from their spheres")


if __name__ == "__main__":
    main()
