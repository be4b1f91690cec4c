"""Writes cases.json: scenes and what the rays through some of their pixels hit, by the formulas of the lecture.

    python3 -m pip install mpmath==1.3.0
    python3 tests/truth/make.py

Nothing here is shared with src/exact: the basis is normalised, the quadratic is solved as it stands, both roots are
looked at, all with 1000 decimal digits. Digits alone cannot tell a touch from a near miss, so wherever the leading 400
of them vanish the case must say that it was constructed so, and what the answer is; anything else is refused.
Every input is an f64, written as the hexadecimal digits of its bits. A viewport at an infinite distance is orthographic:
its extent is in the scene's unit, and rays leave from their place in it, about the eye, along the view.
"""

import json
import math
import random
import struct
from pathlib import Path

from mpmath import mp, mpf, nstr, sqrt

mp.dps = 1000
VANISHED = mpf(10) ** -400
DICE = random.Random(20261121)
CASES = []


def bits(x):
    return struct.pack(">d", x).hex()


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), mpf(0))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def along(e, t, d):
    return [x + t * y for x, y in zip(e, d)]


def scaled(a, s):
    return [x * s for x in a]


def unit(a):
    return scaled(a, 1 / sqrt(dot(a, a)))


def exact(a):
    return [mpf(x) for x in a]


def basis(camera):
    e = exact(camera["eye"])
    view = exact(camera["view"]) if "view" in camera else minus(exact(camera["at"]), e)
    w = scaled(unit(view), -1)
    u = unit(cross(exact(camera["up"]), w))
    return e, u, cross(w, u), w


def ray(camera, i, j):
    e, u, v, w = basis(camera)
    (width, height), (vw, vh) = camera["size"], exact(camera["viewport"])
    x = ((j + mpf(1) / 2) / width - mpf(1) / 2) * vw
    y = -((i + mpf(1) / 2) / height - mpf(1) / 2) * vh
    if math.isinf(camera["distance"]):
        return along(along(e, x, u), y, v), scaled(w, -1)
    return e, along(along(scaled(u, x), y, v), -mpf(camera["distance"]), w)


def roots(e, direction, sphere):
    """Both t. A discriminant or a root that cancels by 400 digits counts as 0; `vanished` tells whether one did."""
    oc = minus(e, exact(sphere[:3]))
    a, b, c = dot(direction, direction), 2 * dot(direction, oc), dot(oc, oc) - mpf(sphere[3]) ** 2
    disc, vanished = b * b - 4 * a * c, False
    if abs(disc) <= VANISHED * (b * b + abs(4 * a * c)):
        disc, vanished = mpf(0), True
    if disc < 0:
        return [], vanished
    both = [(-b - sqrt(disc)) / (2 * a), (-b + sqrt(disc)) / (2 * a)]
    size = max(abs(t) for t in both)
    vanished = vanished or any(abs(t) <= VANISHED * size for t in both)
    return [mpf(0) if abs(t) <= VANISHED * size else t for t in both], vanished


def hit(camera, spheres, i, j, known):
    """`known` is None, or the id by construction (-1 for none): then a cancellation to 0 is intended."""
    e, direction = ray(camera, i, j)
    best, close = None, False
    for index, sphere in enumerate(spheres):
        both, vanished = roots(e, direction, sphere)
        close = close or vanished
        for which, t in enumerate(both):
            if t <= 0:
                continue
            if best and abs(t - best[0]) <= VANISHED * t:
                close = close or best[1] != index
            elif not best or t < best[0]:
                best = (t, index, which)
    found = best[1] if best else -1
    assert not close or known is not None, f"{camera} {i} {j}: only a construction can say"
    assert known is None or known == found, f"{camera} {i} {j}: {known} was meant, {found} came out"
    answer = {"i": i, "j": j, "id": found, "constructed": close}
    if best:
        t, index, which = best
        point = along(e, t, direction)
        normal = scaled(minus(point, exact(spheres[index][:3])), (1 - 2 * which) / mpf(spheres[index][3]))
        both, _ = roots(e, direction, spheres[index])
        answer |= {
            "root": "far" if which else "near",
            "tangent": both[0] == both[1],
            "t": nstr(t, 40),
            "tail": nstr(t - mpf(float(nstr(t, 40))), 20),
            "distance": nstr(t * sqrt(dot(direction, direction)), 20),
            "depth": nstr(t * (1 if math.isinf(camera["distance"]) else mpf(camera["distance"])), 20),
            "normal": [nstr(x, 20) for x in normal],
            "position": [nstr(x, 20) for x in point],
        }
    return answer


def case(name, camera, spheres, pixels):
    """`pixels` are (i, j) or (i, j, known id)."""
    camera = {"up": [0.0, 1.0, 0.0], "size": [1, 1], "viewport": [1.0, 1.0], "distance": 1.0} | camera
    answers = [hit(camera, spheres, p[0], p[1], p[2] if len(p) > 2 else None) for p in pixels]
    packed = {
        "name": name,
        "size": camera["size"],
        "distance": bits(camera["distance"]),
        "viewport": [bits(x) for x in camera["viewport"]],
        "spheres": [[bits(x) for x in s] for s in spheres],
        "pixels": answers,
    }
    for key in ("eye", "at", "view", "up"):
        if key in camera:
            packed[key] = [bits(x) for x in camera[key]]
    CASES.append(packed)


def vector(s=1.0):
    return [DICE.uniform(-s, s) for _ in range(3)]


def some(size, n):
    """The central pixel and n others."""
    width, height = size
    return [(height // 2, width // 2)] + [(DICE.randrange(height), DICE.randrange(width)) for _ in range(n)]


def cluster(center, s, n):
    return [[c + x for c, x in zip(center, vector(s))] + [s * DICE.uniform(0.2, 0.7)] for _ in range(n)]


def oblique():
    for n in range(14):
        size = [DICE.randrange(1, 60), DICE.randrange(1, 60)]
        camera = {"eye": vector(5), "at": vector(), "up": vector(), "size": size}
        camera |= {"viewport": [DICE.uniform(0.5, 1), DICE.uniform(0.5, 1)], "distance": DICE.uniform(0.5, 3)}
        case(f"oblique {n}", camera, cluster([0, 0, 0], 1.5, 8), some(size, 7))


def scales():
    for s in (1e-20, 1e-9, 1e7, 1e20):
        for n in range(2):
            camera = {"eye": vector(4 * s), "at": vector(s), "up": vector(1 / s), "size": [31, 17]}
            camera |= {"viewport": [s, 0.6 * s], "distance": s}
            case(f"scale {s:g} {n}", camera, cluster([0, 0, 0], 1.5 * s, 8), some([31, 17], 7))
    spheres = cluster([0, 0, 0], 1.0, 3) + cluster([1e-9, 0, 0], 1e-9, 3) + [[3e20, -2e20, 1e20, 1e20]]
    camera = {"eye": [1e-9, 4e-9, 3e-9], "view": [3.0, -2.0, 1.0], "size": [31, 17]}
    case("scales mixed", camera | {"viewport": [2.0, 1.0]}, spheres, some([31, 17], 8))


def far():
    for k in (3, 5, 7, 9, 12, 15):
        eye = scaled(unit(exact(vector())), 10**k)
        lens = {"viewport": [4 / 10.0**k, 3 / 10.0**k], "size": [160, 120]}
        camera = {"eye": [float(x) for x in eye], "at": [0.0, 0.0, 0.0], "up": vector()}
        case(f"far eye 1e{k}", camera | lens, cluster([0, 0, 0], 1.0, 12), some([160, 120], 8))


def lenses():
    for name, extent in (("narrow", 1e-6), ("wide", 50.0), ("very wide", 1e6)):
        at = vector()
        camera = {"eye": vector(3), "at": at, "up": vector(), "viewport": [extent, extent], "size": [41, 41]}
        spheres = cluster(at, min(1.0, extent), 5) + [[0.0, 0.0, 0.0, 9.0]] + cluster([0, 0, 0], 3.0, 6)
        case(f"{name} lens", camera, spheres, some([41, 41], 8))
    view = vector()
    up = [x + 1e-7 * y for x, y in zip(view, vector())]
    camera = {"eye": [1.0, 2.0, 3.0], "view": view, "up": up, "size": [15, 15], "viewport": [3.0, 3.0]}
    case("up nearly along the view", camera, cluster([1, 2, 3], 4.0, 14), some([15, 15], 8))


def around():
    """Inside, near a planet's ground, and on the surface, which no number of digits distinguishes from near it."""
    eye = vector()
    camera = {"eye": eye, "view": vector(), "up": vector(), "size": [9, 9], "viewport": [4.0, 4.0]}
    spheres = [[x + y for x, y in zip(eye, vector(0.3))] + [1 + 0.1 * n] for n in range(4)]
    case("inside four", camera, spheres + cluster(eye, 0.4, 3), some([9, 9], 8))
    r = 6371e3
    ground = {"eye": [r + 1.7, 0.3, -0.2], "view": [-0.05, 1.0, 0.3], "up": [1.0, 0.0, 0.0], "size": [40, 30]}
    spheres = [[0.0, 0.0, 0.0, r], [r, 40.0, 12.0, 1.5], [0.0, 0.0, 0.0, r * (1 + 2.0**-40)]]
    case("on a planet", ground | {"viewport": [1.5, 1.0]}, spheres, some([40, 30], 9))
    # (2, 3, 6) has length 7.
    eye = [0.5, -8.0, 3.0]
    surface = [eye[0] + 2, eye[1] + 3, eye[2] + 6, 7.0]
    inward = {"eye": eye, "view": [1.0, 2.0, 3.0], "size": [5, 5]}
    case("eye on a surface, in", inward, [surface], [(2, 2, 0), (0, 0, 0), (4, 1, 0)])
    outward = inward | {"view": [-1.0, -2.0, -3.0]}
    case("eye on a surface, out", outward, [surface], [(2, 2, -1), (0, 0, -1), (4, 1, -1)])
    # (3, 2, -2) is orthogonal to (2, 3, 6).
    case("eye on a surface, along", inward | {"view": [3.0, 2.0, -2.0]}, [surface], [(2, 2, -1)])


def touches():
    """Discriminants that are exactly 0."""
    flat = {"eye": [0.0, 0.0, 0.0], "view": [0.0, 0.0, -1.0]}
    for x, y, r in ((0.75, 0.0, 0.75), (3.0, 4.0, 5.0), (-20.0, 21.0, 29.0)):
        for z in (-1.5, -64.0, -(2.0**40) - 1):
            for k, known in ((0, 0), (-1, -1), (1, 0)):
                case(f"touch {x} {z} {k:+}", flat, [[x, y, z, r * (1 + k * 2.0**-52)]], [(0, 0, known)])
    # alpha = beta = sqrt(2): the right pixel of three looks along (3, 1, 0)/sqrt(2), and (-2, 6, 3) across, 7 long.
    slant = {"eye": [5.0, -7.0, 11.0], "view": [1.0, 1.0, 0.0], "up": [0.0, 0.0, 1.0], "size": [3, 1]}
    slant |= {"viewport": [3.0, 1.0], "distance": 2.0}
    for m in (3.0, 77.5, 2.0**36):
        for k, known in ((0, 0), (-1, -1), (1, 0)):
            center = [5 + 3 * m - 2, -7 + m + 6, 11.0 + 3]
            case(f"slanted touch {m} {k:+}", slant, [center + [7 * (1 + k * 2.0**-52)]], [(0, 2, known)])
    # Straight along (1, 2, 3), beta = sqrt(14).
    for q, r in across([1, 2, 3]):
        camera = {"eye": [0.25, 1.0, -3.0], "view": [1.0, 2.0, 3.0], "up": [0.3, 1.0, 0.1]}
        center = [0.25 + 5 + q[0], 1 + 10 + q[1], -3 + 15 + q[2]]
        case(f"touch across {q}", camera, [center + [r], [9.0, 18.0, 27.0, 2.0]], [(0, 0, 0)])


def across(view):
    """Integer vectors of integer length, orthogonal to the view."""
    span = range(-30, 31)
    found = []
    for x in span:
        for y in span:
            z, rest = divmod(-(view[0] * x + view[1] * y), view[2])
            n = x * x + y * y + z * z
            r = int(n**0.5 + 0.5)
            if rest == 0 and n > 0 and r * r == n:
                found.append(([x, y, z], float(r)))
    return found[:3]


def ties():
    """Equal t by construction: the lower index wins."""
    camera = {"eye": vector(4), "at": [0.0, 0.0, 0.0], "up": vector(), "size": [9, 9]}
    twice = [[0.1, 0.2, 0.3, 0.7], [0.5, 0.0, 0.0, 0.25], [0.1, 0.2, 0.3, 0.7]]
    case("coincident", camera, twice, [(4, 4, 0)])
    case("coincident behind", camera, [[50.0, 0.0, 0.0, 0.1]] + twice, [(4, 4, 1)])
    # Mirrored in the plane of view and up, on which the central column looks: A3 = (1, -2, 3) x -(4, 5, 6) = (27, -6,
    # -13).
    mirror = {"eye": [1.0, 0.0, -2.0], "view": [4.0, 5.0, 6.0], "up": [1.0, -2.0, 3.0], "size": [3, 7]}
    pair = [[1 + 40 + s * 27, 50.0 - s * 6, -2 + 60.0 - s * 13, 45.0] for s in (1, -1)]
    for spheres in (pair, pair[::-1]):
        case("mirrored", mirror | {"viewport": [0.2, 0.2]}, spheres, [(3, 1, 0), (2, 1, 0), (5, 1, 0)])
    # Different spheres through one point ahead; the last is entered from inside.
    view = [1.0, 2.0, 3.0]
    balls = [[9.0 + 2, 18.0 + 3, 27.0 + 6, 7.0], [9.0 + 2, 18.0 + 1, 27.0 + 2, 3.0], [9.0 - 1, 18.0 - 2, 27.0 + 2, 3.0]]
    balls.append([9.0 - 20, 18.0 - 40, 27.0 - 40, 60.0])
    for first in balls:
        for second in balls:
            if first != second:
                case("one point", {"eye": [0.0, 0.0, 0.0], "view": view}, [first, second], [(0, 0, 0)])


def shells():
    for gap in (1e-9, 1e-12, 2.0**-50, 2.0**-52):
        center, r = vector(), DICE.uniform(0.5, 1.5)
        spheres = [center + [r * (1 - gap)], center + [r], center + [r * (1 - 2 * gap)]]
        camera = {"eye": [x + y for x, y in zip(center, vector(6))], "at": center, "up": vector(), "size": [64, 64]}
        case(f"shells {gap:.0e}", camera, spheres, some([64, 64], 5))
        case(f"shells {gap:.0e} inside", camera | {"eye": center, "at": vector(9)}, spheres, some([64, 64], 3))


def grazes():
    """Spheres that the ray passes at r (1 +- 2^-k), as nearly as f64 can place them."""
    for k in (4, 10, 20, 30, 40, 48, 52):
        for sign in (1, -1):
            size = [25, 25]
            camera = {"eye": vector(9), "at": vector(), "up": vector(), "size": size}
            i, j = DICE.randrange(25), DICE.randrange(25)
            bare = {"viewport": [1.0, 1.0], "distance": 1.0} | camera
            e, direction = ray(bare, i, j)
            side = unit(cross(direction, exact(vector())))
            spheres = []
            for r in (1.0, 0.001, 300.0):
                t = 2 * (r + DICE.uniform(1, 9))
                foot = along(e, t / sqrt(dot(direction, direction)), direction)
                center = [float(x) for x in along(foot, r * (1 + sign * mpf(2) ** -k), side)]
                spheres.append(center + [r])
            spheres.append([float(x) for x in along(e, 2000, direction)] + [700.0])
            case(f"graze {sign:+} 2^-{k}", camera, spheres, [(i, j)])


def parallel(name, camera, height, spheres, pixels):
    """The width follows from the image's shape, as the library rounds it."""
    width = height * camera["size"][0] / camera["size"][1]
    case(name, camera | {"viewport": [width, height], "distance": math.inf}, spheres, pixels)


def orthographic():
    for n in range(8):
        size = [DICE.randrange(1, 60), DICE.randrange(1, 60)]
        camera = {"eye": vector(4), "at": vector(), "up": vector(), "size": size}
        parallel(f"parallel {n}", camera, DICE.uniform(1, 4), cluster([0, 0, 0], 1.5, 9), some(size, 7))
    for s in (1e-20, 1e20):
        camera = {"eye": vector(4 * s), "at": vector(s), "up": vector(1 / s), "size": [31, 17]}
        parallel(f"parallel scale {s:g}", camera, 3 * s, cluster([0, 0, 0], 1.5 * s, 9), some([31, 17], 7))
    for k in (3, 7, 12):
        eye = [float(x) for x in scaled(unit(exact(vector())), 10**k)]
        camera = {"eye": eye, "at": [0.0, 0.0, 0.0], "up": vector(), "size": [40, 30]}
        parallel(f"parallel far eye 1e{k}", camera, 2.5, cluster([0, 0, 0], 1.0, 12), some([40, 30], 8))
        camera = {"eye": vector(10.0**k), "view": vector(), "up": vector(), "size": [40, 30]}
        around = cluster(camera["eye"], 1.5, 12) + [camera["eye"] + [0.75]]
        parallel(f"parallel far origin 1e{k}", camera, 2.5, around, some([40, 30], 8))
    # alpha = beta = 5 and right is (4, -3, 0)/5; a unit right and one up of the eye, 4 aside and 3 below the centre.
    slant = {"eye": [5.0, -7.0, 11.0], "view": [3.0, 4.0, 0.0], "up": [0.0, 0.0, 1.0], "size": [3, 3]}
    for m in (3.0, 77.5, 2.0**36):
        for k, known in ((0, 0), (-1, -1), (1, 0)):
            center = [5 + 3 * m + 4, -7 + 4 * m - 3, 11.0 + 4]
            parallel(f"parallel touch {m} {k:+}", slant, 3.0, [center + [5 * (1 + k * 2.0**-52)]], [(0, 2, known)])
    # On the surface, looking in and out.
    parallel("parallel on a surface, in", slant, 3.0, [[8.0, -3.0, 11.0, 5.0]], [(1, 1, 0)])
    parallel("parallel on a surface, out", slant, 3.0, [[2.0, -11.0, 11.0, 5.0]], [(1, 1, -1)])
    # Lower ids win, from the front and at a touch.
    pair = [[20.0, 13.0, 12.0, 5.0], [21.0, 6.0, 12.0, 5.0]]
    for spheres in (pair, pair[::-1]):
        parallel("parallel tie", slant, 3.0, spheres, [(0, 1, 0)])
    for k in (10, 30, 48, 52):
        for sign in (1, -1):
            camera = {"eye": vector(9), "at": vector(), "up": vector(), "size": [25, 25]}
            i, j = DICE.randrange(25), DICE.randrange(25)
            bare = {"viewport": [3.0, 3.0], "distance": math.inf} | camera
            e, direction = ray(bare, i, j)
            side = unit(cross(direction, exact(vector())))
            spheres = []
            for r in (1.0, 0.001, 300.0):
                foot = along(e, 2 * (r + DICE.uniform(1, 9)), direction)
                spheres.append([float(x) for x in along(foot, r * (1 + sign * mpf(2) ** -k), side)] + [r])
            spheres.append([float(x) for x in along(e, 2000, direction)] + [700.0])
            parallel(f"parallel graze {sign:+} 2^-{k}", camera, 3.0, spheres, [(i, j)])


def main():
    for make in (oblique, scales, far, lenses, around, touches, ties, shells, grazes, orthographic):
        make()
    lines = ",\n".join(json.dumps(c, separators=(",", ":")) for c in CASES)
    Path(__file__).with_name("cases.json").write_text(f"[\n{lines}\n]\n")
    answers = [a for c in CASES for a in c["pixels"]]
    hits = sum(a["id"] >= 0 for a in answers)
    assert 2 * hits > len(answers), "most rays should hit something"
    print(len(CASES), "cases,", len(answers), "rays,", hits, "hits,", sum(a["constructed"] for a in answers), "constructed")


if __name__ == "__main__":
    main()
