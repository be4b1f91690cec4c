#!/usr/bin/env python3
"""Measures the grain of pictures: how far the sky's rays of one version are from all of the sky, beside another version.

    benches/grain.py FOLDER NEW OLD

FOLDER holds 1tii.pdb and 1IHM.pdb of the wwPDB, NEW and OLD are two halfline commands. Of scenes/cover.toml the truth is the
picture with 65,536 rays for each pixel, at the same samples. In the look soft no option gives the centres of pixels that many
rays; there the reference R has 1,024 samples and so 1,024 rays at each centre. What the samples themselves are off by is the same
for both versions, and their noises are independent: with a = |old - R|^2 - |new - R|^2 and b = |old - new|^2 the mean squares of
the noises are (b + a)/2 and (b - a)/2. That holds for 16 samples; from 64 on the noise of R is no longer small beside them.
"""

import math
import pathlib
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TRUTH = 65536


def color(command, arguments):
    """The linear colours of a picture."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "picture.pfm")
        subprocess.run([command, "render", *arguments, "--backend", "cpu", "-o", file], check=True, stderr=subprocess.DEVNULL)
        _, size, _, numbers = file.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    return struct.unpack(f"<{3 * width * height}f", numbers[: 12 * width * height])


def square(a, b):
    """The mean square of the differences."""
    return sum((x - y) ** 2 for x, y in zip(a, b)) / len(a)


def report(name, samples, new, old):
    print(f"| {name} | {samples} | {old:.5f} | {new:.5f} | {new / old:.2f} |", flush=True)


def main():
    folder, new, old = sys.argv[1:]
    print("| picture | samples | old | new | new / old |\n| --- | --- | --- | --- | --- |")
    for samples in (1, 4, 16, 64):
        sums = [0.0, 0.0]
        for x, y in ((500, 420), (300, 380)):
            options = [ROOT / "scenes/cover.toml", "--samples", str(samples), "--crop", f"{x},{y},{x + 12},{y + 12}"]
            truth = color(new, [*options, "--occlusion", str(TRUTH // samples)])
            for k, command in enumerate((new, old)):
                sums[k] += square(color(command, options), truth) / 2
        report("cover", samples, *map(math.sqrt, sums))
    for name, options in (
        ("close-up", [f"{folder}/1tii.pdb", "--zoom", "4"]),
        ("capsid", [f"{folder}/1IHM.pdb", "--assembly", "1"]),
    ):
        options += ["--look", "soft", "--size", "300x300", "--crop", "130,130,170,170"]
        reference = color(new, [*options, "--samples", "1024"])
        a, b = (color(command, [*options, "--samples", "16"]) for command in (new, old))
        more, between = square(b, reference) - square(a, reference), square(a, b)
        report(name, 16, math.sqrt(max(between - more, 0.0) / 2), math.sqrt((between + more) / 2))


if __name__ == "__main__":
    main()
