"""Writes frames.json: scenes at the ends of the range of f64, and the id of the sphere that each of their pixels shows.

    python3 -m pip install mpmath==1.3.0
    python3 tests/truth/frames.py

The formulas come from make.py, with as many decimal digits as a scene's numbers are apart. Nothing is shared with the
program: the basis is normalised and the quadratic solved as they stand. A pixel that digits cannot decide is refused, so
no frame holds one. Each row of a frame is a string: `.` for a miss, else the digit of the sphere.
"""

import json
import math
import random
from pathlib import Path

import make
from mpmath import mp, mpf

DICE = random.Random(20261122)
FRAMES = []


def digits(n):
    """Numbers of n digits; a discriminant that is smaller than 10^-0.8n of its terms is not decided."""
    mp.dps = n
    make.VANISHED = mpf(10) ** -(8 * n // 10)


def picture(camera, spheres):
    width, height = camera["size"]
    rows = []
    for i in range(height):
        row = ""
        for j in range(width):
            e, direction = make.ray(camera, i, j)
            best = None
            for index, sphere in enumerate(spheres):
                both, vanished = make.roots(e, direction, sphere)
                assert not vanished, f"{camera} {i} {j}: digits cannot decide"
                ahead = [t for t in both if t > 0]
                if ahead and (best is None or min(ahead) < best[0]):
                    best = (min(ahead), index)
            row += str(best[1]) if best else "."
        rows.append(row)
    return rows


def frame(name, camera, spheres):
    camera = {"up": [0.0, 1.0, 0.0], "size": [16, 16], "viewport": [1.0, 1.0], "distance": 1.0} | camera
    if "height" in camera:
        height = camera.pop("height")
        camera |= {"viewport": [height * camera["size"][0] / camera["size"][1], height], "distance": math.inf}
    packed = {
        "name": name,
        "size": camera["size"],
        "distance": make.bits(camera["distance"]),
        "viewport": [make.bits(x) for x in camera["viewport"]],
        "spheres": [[make.bits(x) for x in s] for s in spheres],
        "rows": picture(camera, spheres),
    }
    for key in ("eye", "at", "view", "up"):
        if key in camera:
            packed[key] = [make.bits(x) for x in camera[key]]
    FRAMES.append(packed)


def rolled():
    """Up next to the view, and a lens so long that a turn of 1e-17 rad moves silhouettes.

    The eye is so small beside `at` that their difference takes more than 100 bits, and `at` lies exactly on the axis.
    """
    digits(300)
    for n in range(24):
        sine = 10 ** DICE.uniform(-14.4, -13.5) if n < 18 else 10 ** DICE.uniform(-13, -10)
        at = make.vector()
        camera = {"eye": make.vector(1e-17), "at": at, "up": [x + y for x, y in zip(at, make.vector(sine))]}
        lens = {"height": 2e-17} if n % 2 else {"viewport": [2e-17, 2e-17]}
        spheres = [[k * x for x in at] + [k * DICE.uniform(1e-18, 8e-18)] for k in (1, 2, 4)]
        frame(f"A rolled {n}, sine {sine:.0e}", camera | lens, spheres)


def grounded():
    """Powers of the eye that f64 cannot hold."""
    digits(1600)
    ahead = {"eye": [0.0, 0.0, 0.0], "view": [0.0, 0.0, -1.0]}
    small = [0.0, 0.0, -1.0, 0.25]
    for tiny in (1e-170, 1e-200, 5e-324):
        # A radius of 1 leaves the eye out by tiny^2.
        frame(f"B outside by the square of {tiny:.0e}", ahead, [[0.0, tiny, -1.0, 1.0], small])
        two = [[tiny, 0.0, -1.0, 1.0], [0.0, tiny, -0.5, 0.5], [0.1, 0.0, -1.0, 0.125]]
        frame(f"B two spheres, outside by the square of {tiny:.0e}", ahead, two)
    for tiny in (1e-180, 3e-310):
        camera = {"eye": [0.0, tiny, 0.0], "view": [0.0, -0.1, -1.0], "viewport": [2.0, 2.0]}
        frame(f"B {tiny:.0e} above the ground", camera, [[0.0, -1.0, 0.0, 1.0], small])
        camera = {"eye": [tiny, 0.0, 0.0], "view": [0.2, 0.1, -1.0], "viewport": [2.0, 2.0]}
        frame(f"B {tiny:.0e} beside the touch", camera, [[0.0, 0.0, -1.0, 1.0], small])
        camera = {"eye": [0.0, 0.0, tiny], "view": [0.0, 0.3, 1.0], "viewport": [2.0, 2.0]}
        frame(f"B {tiny:.0e} before it, looking away", camera, [[0.0, 0.0, -1.0, 1.0], [0.0, 0.0, 1.0, 0.25]])


def subnormal():
    """Views made of the last bits of f64."""
    digits(1600)
    eye, step = [0.0, 0.0, 0.0], 5e-324
    frame("C at (3, 0, -1) steps", {"eye": eye, "at": [3 * step, 0.0, -step]}, [[3.0, 0.0, -1.0, 0.5]])
    frame("C at one step", {"eye": eye, "at": [0.0, 0.0, -step]}, [[0.0, 0.0, -3.0, 1.0]])
    camera = {"eye": [step, 2 * step, 0.0], "at": [2 * step, step, -step]}
    frame("C from one step to another", camera, [[1.0, -1.0, -1.0, 0.25], [2.0, -2.0, -2.5, 1.0]])
    for n in range(4):
        direction = [float(DICE.randrange(-9, 10)) for _ in range(2)] + [-5.0]
        spheres = [direction + [1.5], [2 * x + y for x, y in zip(direction, make.vector(3))] + [2.0]]
        frame(f"C steps {n}", {"eye": eye, "at": [x * step for x in direction]}, spheres)
    # So far apart that the difference of the two ends is no f64; the spheres are near the eye.
    large = 1.7e308
    camera = {"eye": [-large, 0.0, 0.0], "at": [large, 1e308, 0.0], "viewport": [0.5, 0.5]}
    spheres = [[-large + 1e294, 3e293, 0.0, 1e293], [-large + 1e295, 3.2e294, 1e294, 1e294]]
    frame("C across the range", camera, spheres)


def grazed(camera, i, j, center):
    """The sphere about `center` whose radius is a step of the subnormal numbers more, or less, than the pixel's ray passes."""
    camera = {"viewport": [1.0, 1.0], "distance": 1.0} | camera
    if "height" in camera:
        camera |= {"viewport": [camera["height"]] * 2, "distance": math.inf}
    e, direction = make.ray(camera, i, j)
    off = make.cross(make.minus(make.exact(center), e), direction)
    passes = make.sqrt(make.dot(off, off) / make.dot(direction, direction))
    return center + [float(math.floor(passes / mpf(5e-324)) + DICE.randrange(2)) * 5e-324]


def tiny():
    """Everything within the subnormal numbers, spheres four radii away; and at the other end, where squares overflow."""
    digits(300)
    for n in range(24):
        s = (1e-320, 1e-320, 4e-321, 1e-319, 1e-308)[n % 5]
        view = make.vector()
        axis = [float(x) for x in make.unit(make.exact(view))]
        camera = {"eye": make.vector(s) if n % 2 else [0.0] * 3, "view": view, "up": make.vector(), "size": [16, 16]}
        camera |= {"height": 2.5 * s} if n % 4 == 3 else {"viewport": [0.6, 0.6]}
        spheres = []
        while len(spheres) < 1 + n % 2:
            center = [e + 4 * s * x + y for e, x, y in zip(camera["eye"], axis, make.vector(0.5 * s))]
            sphere = grazed(camera, DICE.randrange(16), DICE.randrange(16), center)
            spheres += [sphere] if 0.2 * s < sphere[3] < 1.2 * s else []
        if n % 6 == 5:
            # Around the eye.
            spheres.append([x + y for x, y in zip(camera["eye"], make.vector(0.5 * s))] + [1.2 * s])
        frame(f"D tiny {n}, {s:.0e}", camera, spheres)
    for n in range(6):
        s = (1e160, 1e250, 1e299)[n // 2]
        view = make.vector()
        axis = [float(x) for x in make.unit(make.exact(view))]
        spheres = [[4 * s * x + y for x, y in zip(axis, make.vector(s))] + [s] for _ in range(2)]
        camera = {"eye": [0.0] * 3, "view": view, "up": make.vector()}
        lens = {"height": 4 * s} if n % 2 else {"viewport": [1.2, 1.2]}
        frame(f"D large {n}, {s:.0e}", camera | lens, spheres)


def main():
    for family in (rolled, grounded, subnormal, tiny):
        family()
    lines = ",\n".join(json.dumps(f, separators=(",", ":")) for f in FRAMES)
    Path(__file__).with_name("frames.json").write_text(f"[\n{lines}\n]\n")
    shown = sum(len(set("".join(f["rows"]))) > 1 for f in FRAMES)
    print(len(FRAMES), "frames,", shown, "that show more than one thing")


if __name__ == "__main__":
    main()
