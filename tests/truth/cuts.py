"""Writes cuts.json: scenes of spheres that planes cut, and what each pixel's ray meets first.

    python3 tests/truth/cuts.py

Everything is a fraction, as in layers.py, whose rays and order of two hits it takes. Nothing is shared with the program. A plane keeps
N.p <= D. A ball is removed where N.c - r |N| >= D, whole where N.c + r |N| <= D for all planes, else cut; a spared one is whole. Of a ray the
planes keep t_in < t < t_out. Each pixel is the letter of the sphere, as a capital where a plane shows its inside, or `.` for none.
Scenes hold equal and nested spheres, planes through centres, at tangents, through the eye, along rays and parallel ones, and eyes inside.
"""

import json
import random
from fractions import Fraction
from functools import cmp_to_key
from pathlib import Path

from layers import HEIGHT, WIDTH, bits, order, ray

DICE = random.Random(20261130)


def rational(t):
    return (Fraction(t), 1, Fraction(0))


def side(sphere, planes, spared):
    """Whether planes leave the sphere out, cut it, or leave it whole."""
    *center, radius = map(Fraction, sphere)
    cut = False
    for *normal, distance in planes:
        beyond = sum(Fraction(n) * c for n, c in zip(normal, center)) - Fraction(distance)
        squares = beyond * beyond - radius * radius * sum(Fraction(n) ** 2 for n in normal)
        if beyond > 0 and squares >= 0 and not spared:
            return "removed"
        cut |= not (beyond < 0 and squares >= 0)
    return "cut" if cut and not spared else "whole"


def kept(eye, direction, planes):
    """t_in, whether a plane gives it, and t_out; `None` for no end. `None` where planes keep nothing of the ray."""
    entry, exit = None, None
    for *normal, distance in planes:
        along = sum(Fraction(n) * d for n, d in zip(normal, direction))
        gap = Fraction(distance) - sum(Fraction(n) * e for n, e in zip(normal, eye))
        if along == 0:
            if gap < 0:
                return None
            continue
        t = gap / along
        if along > 0:
            exit = t if exit is None else min(exit, t)
        elif t > 0:
            entry = t if entry is None else max(entry, t)
    start = Fraction(0) if entry is None else entry
    return None if exit is not None and start >= exit else (start, entry is not None, exit)


def roots(eye, direction, sphere):
    *center, radius = map(Fraction, sphere)
    oc = [e - c for e, c in zip(eye, center)]
    a = sum(d * d for d in direction)
    half = sum(d * o for d, o in zip(direction, oc))
    disc = half * half - a * (sum(o * o for o in oc) - radius * radius)
    return None if disc < 0 else [(-half / a, s, disc / (a * a)) for s in (-1, 1)]


def hit(eye, direction, sphere, kind, part):
    """The place of a hit and whether it is a face; `None` for no hit."""
    both = roots(eye, direction, sphere)
    if both is None or kind == "removed":
        return None
    near, far = both
    zero = rational(0)
    if kind == "whole":
        return next(((root, False) for root in both if order(root, zero) > 0), None)
    if part is None:
        return None
    start, is_plane, exit = part
    before = lambda root: exit is None or order(root, rational(exit)) < 0
    if order(near, rational(start)) > 0:
        return (near, False) if before(near) else None
    if is_plane:
        return (rational(start), True) if order(far, rational(start)) > 0 else None
    return (far, False) if order(far, zero) > 0 and before(far) else None


def pixel(case, kinds, i, j):
    eye, direction = ray(case, i, j)
    part = kept(eye, direction, case["planes"])
    hits = []
    for n, sphere in enumerate(case["spheres"]):
        found = hit(eye, direction, sphere, kinds[n], part)
        if found:
            hits.append((*found, sphere[3], n))

    def first(one, other):
        faces = one[1] and other[1]
        ranks = [(not one[1], one[2] if faces else 0, one[3]), (not other[1], other[2] if faces else 0, other[3])]
        return order(one[0], other[0]) or (-1 if ranks[0] < ranks[1] else 1)

    if not hits:
        return "."
    _, is_face, _, n = min(hits, key=cmp_to_key(first))
    letter = chr(ord("a") + n)
    return letter.upper() if is_face else letter


def near(steps, most):
    """A multiple of 1/steps."""
    return DICE.randrange(-most * steps, most * steps + 1) / steps


def plane(spheres, eye, steps):
    normal = DICE.choice([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, 1, 0], [1, 0, 2], [-1, 1, 1], [3, 4, 0], [0, -3, 4], [2, 1, -2]])
    length = sum(n * n for n in normal) ** 0.5
    x, y, z, r = DICE.choice(spheres)
    at = sum(n * c for n, c in zip(normal, (x, y, z)))
    through_eye = sum(n * e for n, e in zip(normal, eye))
    # Tangent where the length is a whole number.
    return [*map(float, normal), DICE.choice([at, at, at + r * length, at - r * length, through_eye, at + near(steps, 1)])]


def scene(n):
    parallel = n % 3 == 2
    # Pixels whose rays pass through round numbers, so that they touch and meet, and run along planes.
    viewport = [[9.0, 7.0], [2.25, 1.75], [1.125, 0.875]][n % 2] if parallel or n % 5 else [0.9, 0.7]
    steps = (1, 2, 8, 1 << 16)[n % 4]
    spheres = [[near(steps, 3), near(steps, 3), near(steps, 4) - 6, (1 + DICE.randrange(3 * steps)) / steps] for _ in range(5 + n % 8)]
    if n % 4 < 3:
        # Equal ones, and nested ones.
        spheres.append(list(DICE.choice(spheres)))
        x, y, z, r = DICE.choice(spheres)
        spheres.append([x, y, z, r / 2])
    if n % 7 == 0:
        spheres.append([0.0, 0.0, -1.0, 20.0])
    DICE.shuffle(spheres)
    eye = [near(2, 1), near(2, 1), near(2, 1)]
    planes = [plane(spheres, eye, steps) for _ in range(1 + n // 2 % 3)]
    if n % 9 == 0:
        planes.append([2.0 * x for x in planes[0]])
    spared = [DICE.random() < (0.0, 0.25)[n // 4 % 2] for _ in spheres]
    case = {"eye": eye, "viewport": viewport, "parallel": parallel, "spheres": spheres, "planes": planes}
    kinds = [side(sphere, planes, is_spared) for sphere, is_spared in zip(spheres, spared)]
    rows = ["".join(pixel(case, kinds, i, j) for j in range(WIDTH)) for i in range(HEIGHT)]
    return {
        "eye": [bits(x) for x in eye],
        "viewport": [bits(x) for x in viewport],
        "parallel": parallel,
        "spheres": [[bits(x) for x in sphere] for sphere in spheres],
        "planes": [[bits(x) for x in plane] for plane in planes],
        "spared": spared,
        "rows": rows,
    }


def main():
    scenes = [scene(n) for n in range(200)]
    lines = ",\n".join(json.dumps(one, separators=(",", ":")) for one in scenes)
    Path(__file__).with_name("cuts.json").write_text(f"[\n{lines}\n]\n")
    pixels = [pixel for one in scenes for row in one["rows"] for pixel in row]
    kinds = [sum(test(pixel) for pixel in pixels) for test in (str.islower, str.isupper, lambda pixel: pixel == ".")]
    print(len(scenes), "scenes,", len(pixels), "pixels: surfaces, faces and misses:", kinds)


if __name__ == "__main__":
    main()
