"""The frame of a scene in many files, sifted by Ray where they lie.

python farm/parts_ray.py run/*.npy -o frame.png
"""

from argparse import ArgumentParser

import numpy as np
import ray

import halfline as hl

CAMERA = hl.Camera((0, 0, 6), at=(0, 0, 0), vfov=40)


@ray.remote(max_retries=5)
def part(file: str, first: int) -> hl.Part:
    """What the frame needs of a file of x, y, z, radius; a memory map is read in blocks."""
    rows = np.load(file, mmap_mode="r")
    return hl.sift(rows[:, :3], rows[:, 3], camera=CAMERA, size=(640, 480), first_id=first)


combine = ray.remote(max_retries=5)(hl.combine)


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+")
    parser.add_argument("-o", "--output", default="frame.png")
    given = parser.parse_args()
    ray.init()
    counts = [len(np.load(file, mmap_mode="r")) for file in given.files]
    firsts = np.cumsum([0, *counts[:-1]]).tolist()
    parts = [part.remote(file, first) for file, first in zip(given.files, firsts, strict=True)]
    while len(parts) > 1:
        parts = [combine.remote(*parts[n : n + 2]) for n in range(0, len(parts), 2)]
    whole = ray.get(parts[0])
    print(whole)
    hl.render(whole).save(given.output)


if __name__ == "__main__":
    main()
