#!/usr/bin/env python3
"""Measures the grain of pictures: how far the sky's rays of one version are from all of the sky, beside another version.

    benches/grain.py FOLDER NEW OLD

FOLDER holds 3SN6.cif, 1tii.pdb and 1IHM.pdb of the wwPDB, NEW and OLD are two halfline commands. The truth is the picture with 16,384
rays of its own for each pixel, by OLD at the same samples: what the samples are off by is the same in all of them. Printed are the
root mean square of the differences in linear colour, and that after a Gaussian of 1.5 pixels, which is closer to what an eye sees.
"""

import math
import pathlib
import subprocess
import sys
import tempfile
from array import array

ROOT = pathlib.Path(__file__).resolve().parent.parent
RAYS = 16384
# Name, samples, arguments, crop.
PICTURES = (
    ("weekend", 4, [ROOT / "scenes/weekend.toml"], "420,300,620,460"),
    ("cover", 1, [ROOT / "scenes/cover.toml"], "520,340,640,440"),
    ("pocket", 4, ["3SN6.cif", "--focus", "ligand", "--color", "ligand=magenta"], "300,200,480,360"),
    ("close-up", 4, ["1tii.pdb", "--zoom", "4"], "300,200,480,360"),
    ("protein", 4, ["3SN6.cif", "--color-by", "chain"], "300,200,480,360"),
    ("capsid", 4, ["1IHM.pdb", "--assembly", "1"], "300,200,440,320"),
)
SIGMA = 1.5


def color(command, folder, arguments):
    """Width, and the linear colours of a picture."""
    with tempfile.TemporaryDirectory() as place:
        file = pathlib.Path(place, "picture.pfm")
        run = [command, "render", *arguments, "--backend", "cpu", "-o", file]
        subprocess.run(run, check=True, stderr=subprocess.DEVNULL, cwd=folder)
        _, size, _, numbers = file.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    colors = array("f", numbers[: 12 * width * height])
    if sys.byteorder == "big":
        colors.byteswap()
    return width, colors


def blurred(width, values):
    """The values of one channel after a Gaussian; beyond the edges the nearest pixel counts."""
    reach = math.ceil(4 * SIGMA)
    weights = [math.exp(-0.5 * (n / SIGMA) ** 2) for n in range(-reach, reach + 1)]
    weights = [weight / sum(weights) for weight in weights]

    def along(line):
        padded = [line[0]] * reach + line + [line[-1]] * reach
        return [sum(w * padded[n + k] for k, w in enumerate(weights)) for n in range(len(line))]

    rows = [along(values[first : first + width]) for first in range(0, len(values), width)]
    return [value for column in zip(*rows) for value in along(list(column))]


def grain(width, picture, truth):
    """Root mean square of the differences, and after the Gaussian."""
    channels = [[a - b for a, b in zip(picture[k::3], truth[k::3])] for k in range(3)]

    def rms(channels):
        return math.sqrt(sum(x * x for channel in channels for x in channel) / len(picture))

    return rms(channels), rms([blurred(width, channel) for channel in channels])


def main():
    folder, new, old = sys.argv[1:]
    print("| picture | samples | old | new | new / old | old, blurred | new, blurred | new / old |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, samples, arguments, crop in PICTURES:
        arguments = [*arguments, "--samples", str(samples), "--crop", crop]
        width, truth = color(old, folder, [*arguments, "--occlusion", str(RAYS // samples)])
        both = [grain(width, color(command, folder, arguments)[1], truth) for command in (old, new)]
        cells = [f"{a:.4f} | {b:.4f} | {b / a:.2f}" for a, b in zip(*both)]
        print(f"| {name} | {samples} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
