"""The particles of an openPMD series, chunk by chunk: the frame that they show.

python parts_openpmd.py data.h5             the first iteration and species
python parts_openpmd.py                     makes a small one first
"""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np
import openpmd_api as pmd

import halfline as hl

CHUNK = 1 << 18


def series(path: Path) -> None:
    """A small series: electrons in a ball, in micrometres."""
    written = pmd.Series(str(path), pmd.Access.create)
    electrons = written.iterations[0].particles["electrons"]
    random = np.random.default_rng(2)
    data = random.normal(size=(3, 200_000))
    for axis, values in zip("xyz", data, strict=True):
        for record in ("position", "positionOffset"):
            component = electrons[record][axis]
            component.reset_dataset(pmd.Dataset(values.dtype, values.shape))
            component.unit_SI = 1e-6
        electrons["positionOffset"][axis].make_constant(0.0)
        electrons["position"][axis].store_chunk(np.ascontiguousarray(values))
    written.flush()
    written.close()


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("series", type=Path, nargs="?", default=Path("electrons.h5"))
    parser.add_argument("-o", "--output", type=Path, default=Path("electrons.png"))
    given = parser.parse_args()
    if not given.series.exists():
        series(given.series)
    opened = pmd.Series(str(given.series), pmd.Access.read_only)
    iteration = opened.iterations[next(iter(opened.iterations))]
    position = iteration.particles[next(iter(iteration.particles))]["position"]
    camera = hl.Camera((0, 0, 12), at=(0, 0, 0), vfov=40)
    sieve = hl.Sieve(camera, (320, 240))
    count = position["x"].shape[0]
    for first in range(0, count, CHUNK):
        size = [min(CHUNK, count - first)]
        xyz = tuple(position[axis].load_chunk([first], size) for axis in "xyz")
        opened.flush()
        sieve.add(xyz, 0.01)
    part = sieve.part()
    print(part)
    hl.render(part).save(given.output)


if __name__ == "__main__":
    main()
