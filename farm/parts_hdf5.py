"""The particles of a snapshot in HDF5 (as of GADGET), larger than memory: the frame that they show.

python parts_hdf5.py snapshot.hdf5          one with PartType1/Coordinates
python parts_hdf5.py                        makes a small one first

The data set is read in blocks; of each only what some ray may hit first is kept.
"""

from argparse import ArgumentParser
from pathlib import Path

import h5py
import numpy as np

import halfline as hl


def snapshot(path: Path) -> None:
    """A small snapshot: Plummer's sphere."""
    random = np.random.default_rng(1)
    directions = random.normal(size=(300_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    distance = 1 / np.sqrt(random.uniform(0.01, 1, 300_000) ** (-2 / 3) - 1 + 1e-9)
    with h5py.File(path, "w") as file:
        header = file.create_group("Header")
        header.attrs["NumPart_ThisFile"] = [0, 300_000]
        positions = (directions * distance[:, np.newaxis]).astype("f4")
        file.create_dataset("PartType1/Coordinates", data=positions, chunks=True)


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("snapshot", type=Path, nargs="?", default=Path("snapshot.hdf5"))
    parser.add_argument("-o", "--output", type=Path, default=Path("snapshot.png"))
    given = parser.parse_args()
    if not given.snapshot.exists():
        snapshot(given.snapshot)
    camera = hl.Camera((0, 0, 12), at=(0, 0, 0), vfov=40)
    with h5py.File(given.snapshot) as file:
        part = hl.sift(file["PartType1/Coordinates"], 0.01, camera=camera, size=(320, 240))
    print(part)
    hl.render(part).save(given.output)


if __name__ == "__main__":
    main()
