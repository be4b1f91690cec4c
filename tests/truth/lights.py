"""Writes lights.json: scenes, lights, and whether each light is hidden from what some viewing rays hit.

    python3 -m pip install mpmath==1.3.0
    python3 tests/truth/lights.py

As in make.py, with 1000 decimal digits and nothing shared with src/exact: the hit is a number, the ray from there to the light
meets each sphere at both roots of its quadratic, and whatever lies between 0 and 1 hides the light. The sphere of the hit
itself hides what is not in front of its surface. Wherever 400 digits vanish the light is left out, since digits cannot decide.
"""

import json
import math
from pathlib import Path

import make
from mpmath import mpf

DICE = make.DICE
LEFT_OUT = []


class Undecided(Exception):
    pass


def certain(x, size):
    """x, unless it is as good as 0."""
    if abs(x) <= make.VANISHED * size:
        raise Undecided
    return x


def hidden(camera, spheres, pixel, light):
    e, direction = make.ray(camera, pixel["i"], pixel["j"])
    own = pixel["id"]
    far = pixel["root"] == "far"
    p = make.along(e, make.roots(e, direction, spheres[own])[0][far], direction)
    place = make.exact(light["position"]) if "position" in light else None
    to = make.minus(place, p) if place else make.exact(light["direction"])
    for index, sphere in enumerate(spheres):
        center, radius = make.exact(sphere[:3]), mpf(sphere[3])
        if index == own and far:
            away = make.minus(place, center) if place else None
            if not place or certain(make.dot(away, away) - radius**2, radius**2) > 0:
                return True
        elif index == own:
            outward = make.minus(p, center)
            size = (make.dot(outward, outward) * make.dot(to, to)) ** mpf(0.5)
            if certain(make.dot(outward, to), size) < 0:
                return True
        else:
            both, vanished = make.roots(p, to, sphere)
            if vanished:
                raise Undecided
            if any(t > 0 and (not place or certain(t - 1, 1) < 0) for t in both):
                return True
    return False


def unit(a):
    length = math.hypot(*a)
    return [x / length for x in a]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def tangents(p, normal, spheres, own):
    """Directions and points at which f64 touches the sphere of the hit, or another."""
    across = unit(cross(normal, make.vector()))
    yield {"direction": across}
    yield {"position": [x + spheres[own][3] * y for x, y in zip(p, across)]}
    for sphere in DICE.sample(spheres, min(3, len(spheres))):
        away = [c - x for c, x in zip(sphere[:3], p)]
        distance = math.hypot(*away)
        if distance <= sphere[3] * 1.0001:
            continue
        toward, sine = [x / distance for x in away], sphere[3] / distance
        aside = unit(cross(toward, make.vector()))
        touch = [math.sqrt(1 - sine * sine) * x + sine * y for x, y in zip(toward, aside)]
        yield {"direction": touch}
        yield {"position": [x + 1.5 * distance * y for x, y in zip(p, touch)]}
        # In the middle, and beyond.
        yield {"position": sphere[:3]}
        yield {"position": [x + 2 * y for x, y in zip(p, away)]}


def case(name, camera, spheres, pixels, size):
    make.case(name, camera, spheres, pixels)
    made = make.CASES[-1]
    camera = {"up": [0.0, 1.0, 0.0], "size": [1, 1], "viewport": [1.0, 1.0], "distance": 1.0} | camera
    hits = [pixel for pixel in made["pixels"] if pixel["id"] >= 0]
    lights = [{"direction": make.vector()} for _ in range(2)]
    lights += [{"position": [x + y for x, y in zip(spheres[0][:3], make.vector(3 * size))]} for _ in range(2)]
    for pixel in hits[:2]:
        point, normal = ([float(x) for x in pixel[key]] for key in ("position", "normal"))
        lights += tangents(point, normal, spheres, pixel["id"])
    known = []
    for light in lights:
        try:
            known.append((light, [hidden(camera, spheres, pixel, light) for pixel in hits]))
        except Undecided:
            LEFT_OUT.append((name, light))
    made["lights"] = [{key: [make.bits(x) for x in value] for key, value in light.items()} for light, _ in known]
    made["pixels"] = [
        {"i": pixel["i"], "j": pixel["j"], "id": pixel["id"], "hidden": [answers[n] for _, answers in known]}
        for n, pixel in enumerate(hits)
    ]
    return len(known) * len(hits), sum(sum(answers) for _, answers in known)


def clusters():
    for n, s in enumerate([1.0, 1.0, 1.0, 1e-20, 1e-9, 1e7, 1e20]):
        camera = {"eye": make.vector(5 * s), "at": make.vector(s), "up": make.vector(), "size": [9, 7]}
        camera |= {"viewport": [0.9 * s, 0.7 * s], "distance": s}
        yield case(f"cluster {n}", camera, make.cluster([0, 0, 0], 2.5 * s, 4 + n), make.some([9, 7], 6), s)


def far():
    """At 1e6 and 1e9 radii from the origin."""
    for n, s in enumerate([1e6, 1e9, 1e9]):
        middle = make.vector(s)
        spheres = make.cluster(middle, 2.5, 6)
        camera = {"eye": [x + y for x, y in zip(middle, make.vector(6))], "at": middle, "up": make.vector(), "size": [9, 7]}
        yield case(f"far {n}", camera | {"viewport": [0.9, 0.7]}, spheres, make.some([9, 7], 6), 1.0)


def touching():
    """A grid of spheres that touch, seen from outside and from the middle of one."""
    spheres = [[2.0 * x, 2.0 * y, 2.0 * z, 1.0] for x in range(3) for y in range(3) for z in range(2)]
    for n, eye in enumerate([[9.0, 7.5, 8.25], [2.125, 2.25, 0.0625], [1.03, 0.98, 5.0]]):
        camera = {"eye": eye, "at": [2.0, 2.1, 0.9], "size": [9, 7], "viewport": [0.9, 0.7]}
        yield case(f"touching {n}", camera, spheres, make.some([9, 7], 6), 2.0)


def shells():
    """Spheres around spheres, with the eye between them."""
    spheres = [[0.0, 0.0, 0.0, 8.0], [0.5, 0.0, 0.0, 5.0], [1.0, 0.5, 0.0, 1.0], [-6.4, 0.0, 0.3, 0.25], [0.0, 3.0, 0.0, 1.5]]
    for n, eye in enumerate([[-7.0, 0.25, 0.0], [4.0, 0.5, -0.25], [20.0, 1.0, 3.0]]):
        camera = {"eye": eye, "at": [0.6, 0.4, 0.1], "size": [9, 7], "viewport": [1.9, 1.5]}
        yield case(f"shells {n}", camera, spheres, make.some([9, 7], 6), 4.0)


def ground():
    """On a planet, with small spheres on it."""
    r = 6.378e6
    stones = [[x, y, math.sqrt(r * r - x * x - y * y) + 0.4, 0.5] for x, y, _ in (make.vector(6) for _ in range(8))]
    camera = {"eye": [0.0, -12.0, r + 2.0], "at": [0.0, 0.0, r], "up": [0.0, 0.0, 1.0], "size": [9, 7]}
    spheres = [[0.0, 0.0, 0.0, r], *stones]
    yield case("ground", camera | {"viewport": [0.9, 0.7]}, spheres, make.some([9, 7], 9), 5.0)


def main():
    counts = [count for family in (clusters, far, touching, shells, ground) for count in family()]
    lines = ",\n".join(json.dumps(c, separators=(",", ":")) for c in make.CASES)
    Path(__file__).with_name("lights.json").write_text(f"[\n{lines}\n]\n")
    rays, blocked = map(sum, zip(*counts))
    print(f"{len(counts)} scenes, {rays} rays, {blocked} hidden, {len(LEFT_OUT)} lights left out as undecided")


if __name__ == "__main__":
    main()
