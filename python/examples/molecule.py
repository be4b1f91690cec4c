"""A molecule of ASE: a soft picture, and its depth in angstrom.

python molecule.py                                  ethanol, 256 pixels wide
python molecule.py some.cif --size 1600 -o some     a file that ASE reads
"""

# ASE's types are incomplete.
# mypy: disable-error-code="import-untyped, import-not-found, no-untyped-call"
# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false

from argparse import ArgumentParser, RawTextHelpFormatter
from pathlib import Path
from typing import Any

import ase.build
import ase.io
import numpy as np

import halfline as hl


def main() -> None:
    parser = ArgumentParser(description=__doc__, formatter_class=RawTextHelpFormatter)
    parser.add_argument("molecule", nargs="?", default="CH3CH2OH", help="a file, or a name of ASE")
    parser.add_argument("--size", type=int, default=256, help="columns and rows of the picture")
    parser.add_argument("-o", "--out", default="molecule", help="start of the files' names")
    given = parser.parse_args()

    of_file = Path(given.molecule).exists()
    atoms: Any = ase.io.read(given.molecule) if of_file else ase.build.molecule(given.molecule)
    scene = hl.from_ase(atoms, background="white")
    size = (given.size, given.size)
    camera = hl.Camera.fit(scene, view=(-0.5, -0.3, -1), size=size)

    # Only color is averaged over the samples; depth is measured at each pixel's centre.
    renderer = hl.Renderer()
    frame = renderer.render(
        scene, camera, size=size, aovs=["color", "depth"], look="soft", samples=16
    )
    frame.save(f"{given.out}.png")
    frame.save(f"{given.out}-depth.npy", aovs="depth")

    depth = frame["depth"][np.isfinite(frame["depth"])]
    print(f"{len(scene)} atoms on {renderer.adapter}, in {depth.size} pixels")
    print(f"depth from {depth.min():.3f} to {depth.max():.3f} angstrom")
    print(f"{given.out}.png, {given.out}-depth.npy")


if __name__ == "__main__":
    main()
