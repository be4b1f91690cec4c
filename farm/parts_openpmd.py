"""The particles of an openPMD series, block by block: the frame that they show.

python parts_openpmd.py data.h5             the first iteration and species
python parts_openpmd.py                     makes a small one first
"""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np
import openpmd_api as pmd

import halfline as hl


MICROMETRE = 1e-6
CELL = 0.5e-6


def series(path: Path) -> None:
    """A small series: electrons in a ball, by their cells and their places in these, as a plasma code writes them."""
    written = pmd.Series(str(path), pmd.Access.create)
    electrons = written.iterations[0].particles["electrons"]
    data = np.random.default_rng(2).normal(size=(3, 200_000)) * MICROMETRE
    for axis, values in zip("xyz", data, strict=True):
        cells = np.floor(values / CELL)
        for record, numbers, unit in (
            ("position", (values - cells * CELL) / MICROMETRE, MICROMETRE),
            ("positionOffset", cells.astype(np.int64), CELL),
        ):
            component = electrons[record][axis]
            component.reset_dataset(pmd.Dataset(numbers.dtype, numbers.shape))
            component.unit_SI = unit
            component.store_chunk(numbers)
            written.flush()
    written.close()


class Column:
    """Coordinates in micrometres: position and positionOffset, each in its unit, read where rows are taken."""

    def __init__(self, opened: pmd.Series, species: pmd.ParticleSpecies, axis: str) -> None:
        self.opened = opened
        self.records = [species[record][axis] for record in ("position", "positionOffset")]
        self.shape = tuple(self.records[0].shape)

    def __getitem__(self, rows: slice) -> np.ndarray:
        first, end, _ = rows.indices(self.shape[0])
        read = [record.load_chunk([first], [end - first]) for record in self.records]
        self.opened.flush()
        place, offset = (
            np.asarray(values, np.float64) * (record.unit_SI / MICROMETRE)
            for values, record in zip(read, self.records, strict=True)
        )
        return place + offset


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("series", type=Path, nargs="?", default=Path("electrons.h5"))
    parser.add_argument("-o", "--output", type=Path, default=Path("electrons.png"))
    given = parser.parse_args()
    if not given.series.exists():
        series(given.series)
    opened = pmd.Series(str(given.series), pmd.Access.read_only)
    iteration = opened.iterations[next(iter(opened.iterations))]
    species = iteration.particles[next(iter(iteration.particles))]
    sieve = hl.Sieve(hl.Camera((0, 0, 12), at=(0, 0, 0), vfov=40), (320, 240))
    sieve.add(tuple(Column(opened, species, axis) for axis in "xyz"), 0.01)
    part = sieve.part()
    print(part)
    hl.render(part).save(given.output)


if __name__ == "__main__":
    main()
