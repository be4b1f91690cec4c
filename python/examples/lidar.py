"""A sweep of a spinning scanner over boulders on a planet: a range image and a point cloud.

python lidar.py                                     16 rings of 360 beams
python lidar.py --rings 128 --beams 3600 -o big     460,800 beams
"""

from argparse import ArgumentParser, RawTextHelpFormatter
from pathlib import Path

import numpy as np

import halfline as hl

PLANET = 6_371_000.0  # metres, as all lengths here
RANGE = 80.0
EYE = (0.0, 0.0, 1.8)


def main() -> None:
    parser = ArgumentParser(description=__doc__, formatter_class=RawTextHelpFormatter)
    parser.add_argument("--rings", type=int, default=16)
    parser.add_argument("--beams", type=int, default=360, help="beams of a ring in a turn")
    parser.add_argument("-o", "--out", default="sweep", help="start of the files' names")
    given = parser.parse_args()

    # Sphere 0 is the ground, which touches z = 0 from below.
    random = np.random.default_rng(2)
    radii = random.uniform(0.2, 2.0, 200)
    boulders = np.column_stack([random.uniform(-50, 50, (200, 2)), 0.5 * radii])
    scene = hl.Scene(np.vstack([(0, 0, -PLANET), boulders]), np.append(PLANET, radii))

    rings = np.radians(np.linspace(-25, 15, given.rings))
    turn = np.linspace(0, 2 * np.pi, given.beams, endpoint=False)
    elevation, azimuth = np.meshgrid(rings, turn, indexing="ij")
    x, y = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)
    beams = np.stack([x, y, np.sin(elevation)], axis=-1)

    # The answers have the shape of the beams: (rings, beams).
    hits = hl.Renderer().trace(scene, EYE, beams, RANGE)
    np.savez_compressed(f"{given.out}.npz", beams=beams, range=hits.distance, id=hits.id)

    seen = hits.hit
    names = ["x", "y", "z", "range"]
    points = np.empty(seen.sum(), [*((name, "<f8") for name in names), ("id", "<i4")])
    points["x"], points["y"], points["z"] = hits.position[seen].T
    points["range"], points["id"] = hits.distance[seen], hits.id[seen]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {points.size}"]
    head += [*(f"property double {name}" for name in names), "property int id", "end_header\n"]
    Path(f"{given.out}.ply").write_bytes("\n".join(head).encode() + points.tobytes())
    print(f"{seen.size} beams, {points.size} returns, {(points['id'] == 0).sum()} of the ground")
    print(f"{(hits.certainty == 0).sum()} proved, {(hits.certainty == 1).sum()} settled")


if __name__ == "__main__":
    main()
