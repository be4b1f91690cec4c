"""Every command of the pages runs: small files stand in for those that a page names, and pictures are small.

Blocks of `console` also show what a command prints: it is compared word for word, but for times, adapters, numbers of threads and
sizes of memory. `PAGES` is what a reader reads; pages that build or test halfline are not among them.
"""

import os
import re
import shlex
import shutil
import struct
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from conftest import ROOT, commands
from numpy.typing import NDArray

PAGES = [
    "README.md",
    *(
        f"docs/{name}.md"
        for name in ("command", "reading", "selection", "film", "figure", "light")
    ),
    *(f"docs/{name}.md" for name in ("formats", "trace", "view", "parts", "accuracy")),
]

# Parts of commands that cannot run here, and the reason.
LEFT_OUT = {
    "halfline view": "it serves a page until it is ended",
    "--topology": "a trajectory of GROMACS is written by no program here",
    " | ": "it is a pipe",
    "--suite": "it takes minutes",
    "tile-*": "its tiles come from other machines",
    "--adapter llvmpipe": "it is for one adapter",
    "halfline adapters": "it is about the machine",
}

# What differs from machine to machine, and what stands for it.
MASKS = [
    (r"rendering on .*", "rendering on ADAPTER"),
    (r"\d+(\.\d+)? (ms|s|MB|GB|MiB|kB)\b", "N"),
]


def blocks(page: str, kind: str) -> list[str]:
    """The fenced blocks of a kind."""
    return re.findall(rf"(?ms)^```{kind}\n(.*?)^```$", page)


def listed(page: str) -> list[str]:
    """The commands of the blocks of a shell, and of indented lines."""
    prose = re.sub(r"(?ms)^```.*?^```$", "", page)
    indented = [
        line for line in re.sub(r"\\\n\s*", " ", prose).splitlines() if line.startswith("    ")
    ]
    lines = [
        line
        for block in blocks(page, "sh")
        for line in re.sub(r"\\\n\s*", " ", block).splitlines()
    ]
    return [line.strip() for line in lines + indented if line.strip().startswith("halfline ")]


class Atom(NamedTuple):
    """An atom of a small complex."""

    kind: str
    name: str
    residue: str
    chain: str
    number: int
    at: tuple[float, float, float]


def atoms() -> list[Atom]:
    """Two chains of protein, a ligand between them, water and an ion."""
    found = []
    for n in range(48):
        at = (3.0 * float(np.cos(n)), 3.0 * float(np.sin(n)), 0.4 * n - 9.6)
        residue = ("ALA", "SER")[n // 4 % 2]
        found.append(
            Atom("ATOM", ("N", "CA", "C", "O")[n % 4], residue, "AR"[n // 24], n // 4 + 1, at)
        )
    found += [
        Atom("HETATM", f"C{k}", "P0G", "R", 50, (0.4 * k, 0.9 * k - 4.0, 0.0)) for k in range(9)
    ]
    found.append(Atom("HETATM", "O", "HOH", "A", 60, (9.0, 0.0, 0.0)))
    return [*found, Atom("HETATM", "CL", "CL", "A", 61, (8.0, 3.0, 0.0))]


def pdb() -> str:
    """The complex as a PDB file, with an assembly of two copies."""
    head = "REMARK 350 BIOMOLECULE: 1\nREMARK 350 APPLY THE FOLLOWING TO CHAINS: A, R\n"
    for copy, shift in ((1, 0.0), (2, 20.0)):
        for row in (1, 2, 3):
            turn = " ".join(f"{float(row == k):9.6f}" for k in (1, 2, 3))
            head += f"REMARK 350   BIOMT{row}   {copy} {turn}     {shift:10.5f}\n"
    lines = ""
    for n, one in enumerate(atoms()):
        place = "".join(f"{x:8.3f}" for x in one.at)
        of = f"{one.kind:6}{n + 1:5} {one.name:^4} {one.residue:>3} {one.chain}{one.number:4}    "
        lines += f"{of}{place}  1.00 10.00          {one.name[:2] if one.name == 'CL' else one.name[0]:>2}\n"
    return f"{head}{lines}END\n"


def cif() -> str:
    """The same as mmCIF."""
    names = "group_PDB id type_symbol label_atom_id label_comp_id label_asym_id label_seq_id"
    names += " Cartn_x Cartn_y Cartn_z auth_seq_id auth_asym_id pdbx_PDB_model_num"
    rows = ""
    for n, one in enumerate(atoms()):
        symbol = one.name if one.name == "CL" else one.name[0]
        place = " ".join(f"{x:.3f}" for x in one.at)
        own = f"{one.name} {one.residue} {one.chain} {one.number}"
        rows += f"{one.kind} {n + 1} {symbol} {own} {place} {one.number} {one.chain} 1\n"
    head = "".join(f"_atom_site.{name}\n" for name in names.split())
    return f"data_3SN6\nloop_\n{head}{rows}"


def dump(frames: int) -> str:
    """Steps of a dump of LAMMPS."""
    random = np.random.default_rng(3)
    text = ""
    for step in range(frames):
        text += f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n6\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n"
        text += "ITEM: ATOMS id type x y z vx vy vz c_ke\n"
        for n in range(6):
            values = " ".join(f"{value:.3f}" for value in random.uniform(0, 9, 7))
            text += f"{n + 1} {n % 3 + 1} {values}\n"
    return text


SCENE = """[camera]
eye = [0.0, 0.0, 9.0]
at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
vfov = 40.0
[[sphere]]
center = [0.0, 0.0, 0.0]
radius = 1.0
"""


def table(rows: int) -> NDArray[np.float64]:
    random = np.random.default_rng(5)
    return np.c_[random.uniform(-2, 2, (rows, 3)), np.full(rows, 0.2)]


def prepare(folder: Path) -> None:
    """Writes the files that the pages name."""

    def write(name: str, text: str) -> None:
        (folder / name).write_text(text)

    write("3SN6.cif", cif())
    for name in ("1IHM.pdb", "1tii.pdb", "molecule.pdb", "protein.pdb", "open.pdb", "closed.pdb"):
        write(name, pdb())
    write("run.dump", dump(100))
    write(
        "cell.xyz",
        '2\nLattice="4 0 0 0 4 0 0 0 4" Properties=species:S:1:pos:R:3\nNa 0 0 0\nCl 2 2 2\n',
    )
    points = "\n".join(" ".join(f"{x:.3f}" for x in row[:3]) for row in table(20))
    head = "ply\nformat ascii 1.0\nelement vertex 20\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    write("cloud.ply", f"{head}{points}\n")
    write("points.txt", f"{points}\n")
    rows = "\n".join(",".join(f"{x:.3f}" for x in row) for row in table(20))
    write("halos.csv", f"pos_x,pos_y,pos_z,r200\n{rows}\n")
    write("particles.csv", f"x,y,z,radius\n{rows}\n")
    solar = [
        ("sun", 0, 0, 0, 695700),
        ("earth", 76581691, 114937971, 49852728, 6371),
        ("moon", 76200000, 114800000, 49700000, 1737),
    ]
    solar += [
        ("jupiter", -209152599, 685745421, 299026573, 69911),
        ("io", -209000000, 685500000, 299000000, 1821),
    ]
    write(
        "solar_system.csv",
        "name,x,y,z,radius\n" + "".join(",".join(map(str, row)) + "\n" for row in solar),
    )
    for name in ("particles", "street", "huge", "a", "b"):
        np.save(folder / f"{name}.npy", table(50))
    box = "0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n"
    data = (
        "LAMMPS data file\n\n2 atoms\n1 atom types\n" + box + "\nMasses\n\n1 12.0\n\nAtoms{}\n\n"
    )
    write("system.data", data.format(" # full") + "1 1 1 0.0 1 2 3\n2 1 1 0.0 4 5 6\n")
    write(
        "grains.data", data.format(" # hybrid") + "1 1 1 2 3 0.0 1.0 1.0\n2 1 4 5 6 0.0 1.0 1.0\n"
    )
    write("own.data", data.format("") + "1 1 0.0 1 2 3\n2 1 0.0 4 5 6\n")
    write(
        "balls_s4.nff",
        "v\nfrom 2 2 2\nat 0 0 0\nup 0 0 1\nangle 45\nhither 1\nresolution 64 64\nf 1 0.7 0.3 1 0 0 0 0\ns 0 0 0 0.5\n",
    )
    for name in ("scene.toml", "s.toml", "capsid.toml"):
        write(name, SCENE)
    ray = np.array([[0, 0, 9, 0, 0, -1], [0, 0, 9, 0.5, 0, -1]], float)
    np.save(folder / "rays.npy", ray)
    write(
        "rays.csv", "ox,oy,oz,dx,dy,dz\n" + "".join(",".join(map(str, row)) + "\n" for row in ray)
    )
    pose = "[[1,0,0,0],[0,1,0,0],[0,0,1,30],[0,0,0,1]]"
    write(
        "poses.json",
        f'{{"frames": [{{"transform_matrix": {pose}}}, {{"transform_matrix": {pose}}}]}}',
    )
    for name in ("expected", "new"):
        np.save(folder / f"{name}.npy", np.ones((4, 4)))
    far = blocks((ROOT / "docs/accuracy.md").read_text(encoding="utf-8"), "toml")
    write("far.toml", next(text for text in far if "10000.0" in text))
    (folder / "cloud.las").write_bytes(las(table(20)))
    (folder / "scenes").symlink_to(ROOT / "scenes")


def las(rows: NDArray[np.float64]) -> bytes:
    """A file of LAS 1.2 with points of format 0, in hundredths of a unit."""
    head = struct.pack(
        "<4sHH16sBB32s32sHHHIIBHI20x",
        b"LASF",
        0,
        0,
        b"",
        1,
        2,
        b"",
        b"",
        1,
        2026,
        227,
        227,
        0,
        0,
        20,
        len(rows),
    )
    low, high = rows[:, :3].min(0), rows[:, :3].max(0)
    ends = [end for axis in range(3) for end in (high[axis], low[axis])]
    head += struct.pack("<12d", 0.01, 0.01, 0.01, 0.0, 0.0, 0.0, *ends)
    points = (
        struct.pack("<3iHBBbBH", *(round(100 * float(x)) for x in row[:3]), 0, 0, 0, 0, 0, 0)
        for row in rows
    )
    return head + b"".join(points)


def small(words: list[str]) -> list[str]:
    """The command with small pictures, few samples and few frames: where a page has large ones."""
    line = shlex.join(words)
    line = re.sub(r"(--size )(\d+)", lambda found: f"{found[1]}{int(found[2]) // 3}", line)
    line = re.sub(r"(--size \d+x)(\d+)", lambda found: f"{found[1]}{int(found[2]) // 3}", line)
    for pattern, word in ((r"--samples \d+", "--samples 4"), (r"--spin \d+", "--spin 3")):
        line = re.sub(pattern, word, line)
    return shlex.split(re.sub(r"--frames 1-\d+ ", "--frames 1-2 ", line))


def reason(line: str) -> str | None:
    """The reason why a command is left out."""
    if (".mp4" in line or ".gif" in line) and not shutil.which("ffmpeg"):
        return "there is no ffmpeg"
    return next((why for part, why in LEFT_OUT.items() if part in line), None)


@pytest.mark.parametrize("name", PAGES)
def test_the_commands_of_a_page_run(name: str, tmp_path: Path) -> None:
    prepare(tmp_path)
    page = (ROOT / name).read_text(encoding="utf-8")
    lines = listed(page)
    ran, failed = 0, []
    for line in lines:
        why = reason(line)
        if why:
            print(f"LEFT OUT: a command of the pages: {why}")
            continue
        # Two spaces and a comment, or a file for standard output.
        words = shlex.split(re.sub(r"\s+#.*| > \S+$", "", line))
        done = subprocess.run(
            [commands()[0], *small(words[1:])],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        ran += 1
        lacks = "without the program of pages" in done.stderr
        expected = 1 if words[1] == "compare" and done.returncode == 1 else 0
        if done.returncode != expected and not lacks:
            failed.append(f"{line}\n  exit code {done.returncode}: {done.stderr.strip()[-600:]}")
    print(f"{ran} of {len(lines)} commands of {name} ran")
    assert not failed, "\n".join([f"{name}: {len(failed)} commands fail", *failed])


def masked(text: str) -> str:
    for pattern, word in MASKS:
        text = re.sub(pattern, word, text)
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


def test_commands_print_what_the_pages_show(tmp_path: Path) -> None:
    if os.environ.get("HALFLINE_NO_GPU"):
        pytest.skip("HALFLINE_NO_GPU is set")
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    compared = 0
    for name in PAGES:
        page = (ROOT / name).read_text(encoding="utf-8")
        for line, shown in re.findall(
            r"(?ms)^\$ (halfline [^\n]*)\n(.*?)(?=^\$ |\Z)", "\n".join(blocks(page, "console"))
        ):
            if reason(line):
                continue
            done = subprocess.run(
                [commands()[0], *shlex.split(line)[1:]],
                cwd=tmp_path,
                capture_output=True,
                text=True,
                timeout=300,
                check=False,
            )
            quiet = "\n".join(
                row
                for row in (done.stderr + done.stdout).splitlines()
                if "XDG_RUNTIME_DIR" not in row
            )
            assert masked(quiet) == masked(shown), f"{name}: {line}"
            compared += 1
    assert compared >= 3
