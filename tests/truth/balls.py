"""Writes balls.json: scenes, a light with a size, and the share of it that is hidden from what some viewing rays hit.

    python3 -m pip install mpmath==1.3.0
    python3 tests/truth/balls.py

As in lights.py with 2000 decimal digits and nothing shared with src: no point of the light is looked at. From the hit p the ball
fills a cone, as does every sphere that may hide it. Where p is in the ball or on it, the share is 0. Where all spheres miss the
cone, or are behind the ball, it is 0; where one covers the cone, or the ball is behind the surface of p, or a sphere around p
excludes it, it is 1. Where one cone, or the plane of the surface, cuts the cone of the ball, the share is the area that two caps of a
sphere have in common: known to all digits, while a picture estimates it. Where several cut it, the hit is left out; where 400
digits vanish, the case must say what is meant.

Scenes are small numbers times 2^k, which is exact, and so is every input.
"""

import json
from pathlib import Path

import make
from mpmath import acos, asin, cos, mp, mpf, pi, sin, sqrt

mp.dps = 2000
DICE = make.DICE
CASES = []
LEFT_OUT = []

# Exponents of whole scenes, whose sizes are below 2^1000.
WORLDS = [-1000, -800, -541, -513, -300, -64, 0, 64, 300, 511, 513, 800, 990]
# Exponents of a light's distance from a scene of unit size.
FAR = [3, 10, 40, 200, 511, 512, 513, 540, 800, 1000, 1020]


class Undecided(Exception):
    pass


def sign(x, size, known=None):
    """The sign of x, or the one that is known by construction where 400 digits vanish."""
    if abs(x) > make.VANISHED * size:
        return 1 if x > 0 else -1
    if known is None:
        raise Undecided
    return known


def length(a):
    return sqrt(make.dot(a, a))


def common(a, b, apart):
    """The solid angle that two cones have in common: half angles a and b, and the angle between their axes."""
    if apart >= a + b:
        return mpf(0)
    if apart + min(a, b) <= max(a, b):
        return 2 * pi * (1 - cos(min(a, b)))
    arc = lambda x, y, z: acos((cos(x) - cos(y) * cos(z)) / (sin(y) * sin(z)))
    return 2 * (pi - arc(apart, a, b) - cos(a) * arc(b, a, apart) - cos(b) * arc(a, b, apart))


def share(p, normal, spheres, own, far, ball, known):
    center, radius = make.exact(ball[:3]), mpf(ball[3])
    toward = make.minus(center, p)
    distance = length(toward)
    if sign(distance - radius, radius, known) <= 0:
        return mpf(0)
    half = asin(radius / distance)
    cuts = []
    for index, (*middle, r) in enumerate(spheres):
        middle, r = make.exact(middle), mpf(r)
        apart = length(make.minus(center, middle))
        to = make.minus(middle, p)
        away = length(to)
        inside = far if index == own else sign(away - r, r) < 0
        if inside:
            if apart - radius > r:
                return mpf(1)
            if not apart + radius < r:
                raise Undecided
        elif index == own:
            # The outward normal is against the viewing ray.
            height = make.dot(normal, toward)
            if sign(height + radius, radius, known) <= 0:
                return mpf(1)
            if sign(height - radius, radius) < 0:
                cuts.append((pi / 2, pi - acos(height / distance)))
        elif away - r <= distance:
            wide, between = asin(r / away), acos(max(mpf(-1), min(mpf(1), make.dot(to, toward) / (away * distance))))
            if between > half + wide + make.VANISHED:
                continue
            if not away + r < distance - radius:
                raise Undecided
            if between + half < wide - make.VANISHED:
                return mpf(1)
            cuts.append((wide, between))
    if len(cuts) > 1:
        raise Undecided
    return common(half, *cuts[0]) / (2 * pi * (1 - cos(half))) if cuts else mpf(0)


def case(name, k, camera, spheres, pixels, ball, known=None, light_k=None):
    """All lengths times 2^k, lengths of the light times 2^light_k. `known` is the sign where digits vanish."""
    scaled = lambda numbers, k=k: [x * 2.0**k for x in numbers]
    camera = camera | {key: scaled(camera[key]) for key in ("eye", "at") if key in camera}
    spheres, ball = [scaled(s) for s in spheres], scaled(ball, k if light_k is None else light_k)
    make.case(name, camera, spheres, pixels)
    made = make.CASES.pop()
    hits = []
    for pixel in made["pixels"]:
        if pixel["id"] < 0:
            continue
        full = {"up": [0.0, 1.0, 0.0], "size": [1, 1], "viewport": [1.0, 1.0], "distance": 1.0} | camera
        e, direction = make.ray(full, pixel["i"], pixel["j"])
        own, far = pixel["id"], pixel["root"] == "far"
        p = make.along(e, make.roots(e, direction, spheres[own])[0][far], direction)
        normal = make.scaled(make.minus(p, make.exact(spheres[own][:3])), 1 / mpf(spheres[own][3]))
        try:
            found = share(p, normal, spheres, own, far, ball, known)
        except Undecided:
            LEFT_OUT.append((name, pixel["i"], pixel["j"]))
            continue
        hits.append({"i": pixel["i"], "j": pixel["j"], "id": own, "share": float(found)})
    if hits:
        CASES.append(made | {"pixels": hits, "ball": [make.bits(x) for x in ball]})


def number(size):
    """Some multiple of 2^-16 below `size`: times a power of two it is still exact."""
    return DICE.randrange(-size * 65536, size * 65536 + 1) / 65536


def vector(size):
    return [number(size) for _ in range(3)]


def some(count):
    return [(DICE.randrange(7), DICE.randrange(9)) for _ in range(count)]


def clusters():
    for k in WORLDS:
        for n in range(5):
            spheres = [[*vector(3), 0.5 + abs(number(1))] for _ in range(4)]
            camera = {"eye": [9.0, number(3), number(3)], "at": spheres[0][:3], "size": [9, 7], "viewport": [0.5, 0.4]}
            ball = [*vector(6), [0.25, 2.0, 0.001953125, 9.0, 1.0][n]]
            case(f"2^{k} {n}", k, camera, spheres, some(8), ball)


def distant():
    """A scene of unit size, and a light far away; of a size that is seen, and small."""
    for k in FAR:
        for n, radius in enumerate([0.5, 0.125, 2.0**-40, 0.9375]):
            spheres = [[*vector(3), 0.5 + abs(number(1))] for _ in range(4)]
            camera = {"eye": [9.0, number(3), number(3)], "at": spheres[0][:3], "size": [9, 7], "viewport": [0.5, 0.4]}
            toward = [[1.0, 0.5, 0.25], [0.0, 0.0, 1.0], [-0.75, 0.5, 0.5], [0.5, -1.0, 0.5]][n]
            case(f"light at 2^{k}, {n}", 0, camera, spheres, some(8), [*toward, radius], light_k=k)
            # Around everything.
            case(f"within 2^{k}, {n}", 0, camera, spheres, some(4), [*make.scaled(toward, 0.0625), 1.0], light_k=k)


def small():
    """Lights that are so small, or so near, that their squares vanish beside the squares of the scene."""
    for k in [-40, -300, -541, -800, -1000]:
        for n in range(3):
            spheres = [[*vector(3), 0.5 + abs(number(1))] for _ in range(4)]
            camera = {"eye": [9.0, number(3), number(3)], "at": spheres[0][:3], "size": [9, 7], "viewport": [0.5, 0.4]}
            case(f"light of 2^{k}, {n}", 0, camera, spheres, some(8), [*vector(6), 2.0**k])


def attacked():
    """A light behind a sphere, whose square is beyond f64; and from the eye it is hidden."""
    spheres = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 20.0, 10.0]]
    camera = {"eye": [0.0, 0.0, 9.0], "view": [0.0, 0.0, -1.0], "size": [9, 7], "viewport": [0.07, 0.06]}
    for place, radius in [(1e155, 1e140), (1e155, 1e154), (1e200, 1e150), (1e307, 1e300), (1e155, 1.0), (1e3, 1.0)]:
        case(f"light at {place}", 0, camera, spheres, [(3, 4), (0, 0), (6, 2)], [0.0, 0.0, place, radius])


def touched():
    """The hit lies on the light, or beside it by one step of f64: (0, 0, -4) and, by 3^2 + 4^2, (0.6, 0, -4.2) times 5."""
    for k in [-900, -541, -100, 0, 100, 511, 900]:
        for reach in (1.0, 1024.0, 2.0**40):
            sphere, camera = [0.0, 0.0, -5.0, 1.0], {"eye": [0.0] * 3, "view": [0.0, 0.0, -1.0]}
            behind = [0.0, 0.0, -4.0 - reach]
            for step, known in ((-1, 1), (0, -1), (1, -1)):
                radius = reach * (1 + step * 2.0 ** (-53 if step < 0 else -52))
                # The light is behind the surface: hidden, unless the hit is on it.
                case(f"touch 2^{k} {reach} {step}", k, camera, [sphere], [(0, 0)], [*behind, radius], known)


def main():
    for family in (clusters, distant, small, attacked, touched):
        family()
    lines = ",\n".join(json.dumps(c, separators=(",", ":")) for c in CASES)
    Path(__file__).with_name("balls.json").write_text(f"[\n{lines}\n]\n")
    shares = [pixel["share"] for c in CASES for pixel in c["pixels"]]
    some = sum(0 < x < 1 for x in shares)
    print(f"{len(CASES)} scenes, {len(shares)} hits: {shares.count(0)} lit, {shares.count(1)} hidden, {some} between; "
          f"{len(LEFT_OUT)} left out")


if __name__ == "__main__":
    main()
