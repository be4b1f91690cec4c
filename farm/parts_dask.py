"""The frame of a scene in many files, sifted by Dask where they lie.

python farm/parts_dask.py run/*.npy -o frame.png      on this machine
python farm/parts_dask.py run/*.npy -o frame.png --scheduler tcp://host:8786

A worker that is lost costs its tasks alone: parts may come again, and in any order.
"""

from argparse import ArgumentParser
from pathlib import Path

import dask.bag
import numpy as np
from distributed import Client

import halfline as hl

CAMERA = hl.Camera((0, 0, 6), at=(0, 0, 0), vfov=40)


def part(file: str, first: int) -> hl.Part:
    """What the frame needs of a file of x, y, z, radius; a memory map is read in blocks."""
    rows = np.load(file, mmap_mode="r")
    return hl.sift(rows[:, :3], rows[:, 3], camera=CAMERA, size=(640, 480), first_id=first)


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+")
    parser.add_argument("-o", "--output", type=Path, default="frame.png")
    parser.add_argument("--scheduler", help="its address; without it two processes here")
    given = parser.parse_args()
    counts = [len(np.load(file, mmap_mode="r")) for file in given.files]
    firsts = np.cumsum([0, *counts[:-1]]).tolist()
    local = {} if given.scheduler else {"n_workers": 2, "threads_per_worker": 1}
    with Client(given.scheduler, **local):
        files = dask.bag.from_sequence(list(zip(given.files, firsts, strict=True)), partition_size=1)
        whole = files.starmap(part).fold(hl.combine).compute()
    print(whole)
    hl.render(whole).save(given.output)


if __name__ == "__main__":
    main()
