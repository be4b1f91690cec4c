"""Writes axes.json: cameras and their basis u, v, w, by the formulas of the lecture with 2000 decimal digits.

    python3 -m pip install mpmath==1.3.0
    python3 tests/truth/axes.py

Each component is written as the bits of the nearest f64 and, in decimal digits, what that lacks.
"""

import json
import math
import random
import struct
from pathlib import Path

import make
from mpmath import mp, mpf, nstr

mp.dps = 2000
DICE = random.Random(20261123)
CAMERAS = []


def camera(eye, up, **look):
    scene = {"eye": eye, "up": up} | look
    _, u, v, w = make.basis(scene)
    turned = make.cross(make.unit(make.exact(up)), w)
    if make.dot(turned, turned) < 1e-30:
        return  # Refused: up is parallel to the view.
    packed = {key: [make.bits(x) for x in value] for key, value in scene.items()}
    parts = [(x, float(x)) for axis in (u, v, w) for x in axis]
    packed["axes"] = [[make.bits(near), nstr(x - mpf(near), 20)] for x, near in parts]
    CAMERAS.append(packed)


def wild():
    """Any finite f64, by its bits."""
    while True:
        x = struct.unpack(">d", DICE.randbytes(8))[0]
        if math.isfinite(x):
            return x


def main():
    for _ in range(40):
        camera(make.vector(9), make.vector(), at=make.vector())
        # Up next to the view, and differences of more than 100 bits.
        at, sine = make.vector(), 10 ** DICE.uniform(-14.9, -1)
        camera(make.vector(10 ** DICE.uniform(-30, -10)), [x + y for x, y in zip(at, make.vector(sine))], at=at)
        camera([wild() for _ in range(3)], [wild() for _ in range(3)], at=[wild() for _ in range(3)])
        scale = 10 ** DICE.uniform(-300, 300)
        camera(make.vector(), make.vector(1 / scale), view=make.vector(scale))
        steps = [[DICE.randrange(-9, 10) * 5e-324 for _ in range(3)] for _ in range(3)]
        if all(any(x) for x in steps) and steps[0] != steps[2]:
            camera(steps[0], make.vector(), at=steps[2])
    lines = ",\n".join(json.dumps(c, separators=(",", ":")) for c in CAMERAS)
    Path(__file__).with_name("axes.json").write_text(f"[\n{lines}\n]\n")
    print(len(CAMERAS), "cameras")


if __name__ == "__main__":
    main()
