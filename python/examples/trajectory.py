"""A film of a trajectory that MDAnalysis reads: a picture for each frame, seen by one camera.

python trajectory.py                                                12 atoms, made here
python trajectory.py top.psf run.dcd --select protein --step 10     atoms of files
"""

# MDAnalysis has no types.
# mypy: disable-error-code="import-untyped, import-not-found"
# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false

from argparse import ArgumentParser, RawTextHelpFormatter
from typing import Any

import MDAnalysis
import numpy as np

import halfline as hl


def ring_that_opens() -> Any:
    """A universe of 12 carbon atoms and 8 frames."""
    universe: Any = MDAnalysis.Universe.empty(12, trajectory=True)
    universe.add_TopologyAttr("elements", ["C"] * 12)
    atom, frame = np.arange(12), np.arange(8)[:, np.newaxis]
    x, y, z = 3 * np.cos(atom * np.pi / 6), 3 * np.sin(atom * np.pi / 6), 0.1 * frame * atom
    return universe.load_new(np.stack(np.broadcast_arrays(x, y, z), axis=-1), order="fac")


def main() -> None:
    parser = ArgumentParser(description=__doc__, formatter_class=RawTextHelpFormatter)
    parser.add_argument("files", nargs="*", help="topology and trajectory")
    parser.add_argument("--select", default="all", help="the atoms, in MDAnalysis' words")
    parser.add_argument("--step", type=int, default=1, help="every so many frames")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 240), help="columns and rows")
    parser.add_argument("-o", "--out", default="film", help="start of the files' names")
    given = parser.parse_args()

    universe: Any = MDAnalysis.Universe(*given.files) if given.files else ring_that_opens()
    group, frames = universe.select_atoms(given.select), universe.trajectory[:: given.step]

    # One camera that shows all atoms of all frames, so that the film does not jitter.
    places = np.concatenate([group.positions for _ in frames])
    everything = hl.Scene(places, hl.from_mdanalysis(group).radii.max())
    size = (given.size[0], given.size[1])
    camera = hl.Camera.fit(everything, view=(-1, -0.5, -1), size=size)

    renderer = hl.Renderer()
    for step in frames:
        scene = hl.from_mdanalysis(group, background="white")
        frame = renderer.render(scene, camera, size=size, look="soft", samples=4)
        frame.save(f"{given.out}.{step.frame:04}.png")
    print(f"{len(frames)} pictures of {len(group)} atoms: {given.out}.0000.png ...")


if __name__ == "__main__":
    main()
