"""Writes layers.json: scenes of translucent and opaque spheres, and what each pixel's ray meets, in order.

    python3 tests/truth/layers.py

Everything is a fraction. The cameras look along an axis, so that no basis is irrational, and two hits have the order of their
(b - s sqrt(D)) / a, which is decided by squares. Nothing is shared with the program. Each pixel is a string of letters: the
translucent spheres before the first opaque one, nearest first, then that one, or `.` for none. Of equal hits the lower id is
the nearer one. Scenes hold equal spheres, spheres that meet a ray at the same point, rays that only touch, and eyes inside.
"""

import json
import random
import struct
from fractions import Fraction
from functools import cmp_to_key
from pathlib import Path

DICE = random.Random(20261127)
WIDTH, HEIGHT = 9, 7


def bits(x):
    return struct.pack(">d", x).hex()


def sign(x):
    return (x > 0) - (x < 0)


def order(one, other):
    """The sign of t - t', where t = p + s sqrt(q) with s = +-1 and q >= 0."""
    (p, s, q), (pp, ss, qq) = one, other
    # p - pp + s sqrt(q) - ss sqrt(qq): first the sign of the two roots together, then that with the rest.
    rest, first, second = p - pp, s * q, -ss * qq
    squares = abs(first) - abs(second)
    roots = sign(first) if sign(first) * sign(second) >= 0 else sign(first) * sign(squares) if squares else 0
    if first == 0:
        roots = sign(second)
    if sign(rest) * roots >= 0:
        return sign(rest) or roots
    # (s sqrt(q) - ss sqrt(qq))^2 = q + qq - 2 s ss sqrt(q qq), against rest^2: u against v sqrt(w).
    u, v, w = rest * rest - q - qq, -2 * s * ss, q * qq
    beyond = sign(u - v * Fraction(0)) if w == 0 else compare(u, v, w)
    return sign(rest) if beyond > 0 else roots if beyond < 0 else 0


def compare(u, v, w):
    """The sign of u - v sqrt(w)."""
    if sign(u) != sign(v):
        return sign(u) or -sign(v)
    return sign(u) * sign(u * u - v * v * w)


def nearest(eye, direction, sphere):
    """The least t > 0 at which the ray meets the sphere, as (p, s, q); None where it does not."""
    *center, radius = map(Fraction, sphere)
    oc = [e - c for e, c in zip(eye, center)]
    a = sum(d * d for d in direction)
    half = sum(d * o for d, o in zip(direction, oc))
    power = sum(o * o for o in oc) - radius * radius
    disc = half * half - a * power
    if disc < 0:
        return None
    p, q = -half / a, disc / (a * a)
    for s in (-1, 1):
        if order((p, s, q), (Fraction(0), 1, Fraction(0))) > 0:
            return p, s, q
    return None


def ray(camera, i, j):
    vw, vh = map(Fraction, camera["viewport"])
    x = ((j + Fraction(1, 2)) / WIDTH - Fraction(1, 2)) * vw
    y = -((i + Fraction(1, 2)) / HEIGHT - Fraction(1, 2)) * vh
    eye = list(map(Fraction, camera["eye"]))
    if camera["parallel"]:
        return [eye[0] + x, eye[1] + y, eye[2]], [Fraction(0), Fraction(0), Fraction(-1)]
    return eye, [x, y, Fraction(-1)]


def pixel(camera, spheres, opaque, i, j):
    eye, direction = ray(camera, i, j)
    hits = [(nearest(eye, direction, sphere), n) for n, sphere in enumerate(spheres)]
    hits = [hit for hit in hits if hit[0]]
    hits.sort(key=cmp_to_key(lambda one, other: order(one[0], other[0]) or one[1] - other[1]))
    row = ""
    for _, n in hits:
        row += chr(ord("a") + n)
        if opaque[n]:
            return row
    return row + "."


def near(steps, most):
    """A multiple of 1/steps."""
    return DICE.randrange(-most * steps, most * steps + 1) / steps


def scene(n):
    parallel = n % 3 == 2
    # Pixels whose rays pass through round numbers, so that they touch and meet.
    viewport = [[9.0, 7.0], [2.25, 1.75], [1.125, 0.875]][n % 2] if parallel or n % 5 else [0.9, 0.7]
    steps = (1, 2, 8, 1 << 20)[n % 4]
    spheres = [[near(steps, 3), near(steps, 3), near(steps, 5) - 8, (1 + DICE.randrange(3 * steps)) / steps] for _ in range(4 + n % 9)]
    if n % 4 < 3:
        # Equal ones, and ones that the middle ray meets at the same point.
        spheres.append(list(DICE.choice(spheres)))
        x, y, z, r = DICE.choice(spheres)
        spheres.append([x, y, z + r - 1.0, 1.0])
    if n % 7 == 0:
        spheres.append([0.0, 0.0, -1.0, 20.0])
    DICE.shuffle(spheres)
    opaque = [DICE.random() < (0.0, 0.3, 0.6)[n // 3 % 3] for _ in spheres]
    camera = {"eye": [near(2, 1), near(2, 1), near(2, 1)], "viewport": viewport, "parallel": parallel}
    rows = [[pixel(camera, spheres, opaque, i, j) for j in range(WIDTH)] for i in range(HEIGHT)]
    return {
        "eye": [bits(x) for x in camera["eye"]],
        "viewport": [bits(x) for x in viewport],
        "parallel": parallel,
        "spheres": [[bits(x) for x in sphere] for sphere in spheres],
        "opaque": opaque,
        "rows": rows,
    }


def main():
    scenes = [scene(n) for n in range(200)]
    lines = ",\n".join(json.dumps(one, separators=(",", ":")) for one in scenes)
    Path(__file__).with_name("layers.json").write_text(f"[\n{lines}\n]\n")
    pixels = [pixel for one in scenes for row in one["rows"] for pixel in row]
    deep = [sum(len(pixel) > n for pixel in pixels) for n in range(1, 8)]
    print(len(scenes), "scenes,", len(pixels), "pixels; so many have 1, 2, .. hits before the last:", deep)


if __name__ == "__main__":
    main()
