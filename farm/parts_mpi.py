"""The frame of a scene whose spheres lie in the memory of MPI's ranks.

mpirun -n 4 python farm/parts_mpi.py -o frame.png

Each rank sifts its own spheres, and a reduction combines the parts: any order, any tree.
"""

from argparse import ArgumentParser

import numpy as np
from mpi4py import MPI

import halfline as hl

COUNT = 250_000


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default="frame.png")
    output = parser.parse_args().output
    world = MPI.COMM_WORLD
    centers = np.random.default_rng(world.rank).uniform(-1, 1, (COUNT, 3))
    # The camera is the same on all ranks. To frame all spheres, reduce their box first.
    low = world.allreduce(centers.min(axis=0), op=np.minimum)
    high = world.allreduce(centers.max(axis=0), op=np.maximum)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low)
    camera = hl.Camera(middle + (0, 0, 1.5 * reach), at=middle, vfov=40)
    first = world.exscan(len(centers)) or 0
    part = hl.sift(centers, 0.004, camera=camera, size=(640, 480), first_id=first)
    whole = world.reduce(part, op=hl.combine, root=0)
    if whole is not None:
        print(whole)
        hl.render(whole).save(output)


if __name__ == "__main__":
    main()
