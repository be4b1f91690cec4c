"""The command and the package give the same pictures, buffers, warnings and refusals for the same choices, drawn at random.

Every option that has a keyword is in the table of choices, or in the table of options which are
compared elsewhere.
"""

import json
import random
import re
import subprocess
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EVERYTHING, ROOT, commands

import halfline as hl

DRAWS = 1000 if EVERYTHING else 50

# Identifiers of options with a keyword that no draw has, and why.
ELSEWHERE = {
    "adapter": "the CPU path has none",
    "backend": "all draws are on the CPU path",
    "hold": "test_read.py compares films",
    "outline": "the earlier name of cell",
    "topology": "test_read.py reads one",
    "add": "test_read.py reads two",
    "size": "each draw has one",
    "crop": "test_render.py has it",
    "unit": "test_render.py saves depths",
    "no_return": "test_render.py saves depths",
    "group": "test_vector.py compares figures",
    "detail": "test_vector.py compares figures",
}

# The names of settings that have another one in Python.
RENAMED = {
    "aov": "aovs",
    "at": "Camera(at)",
    "eye": "Camera(eye)",
    "fit": "Camera.fit",
    "focus": "Camera.fit(focus)",
    "focus_distance": "focus",
    "frames": "frame",
    "intrinsics": "Camera(intrinsics=)",
    "legend_in": "legend",
    "lens": "Camera(lens=)",
    "lens_coefficients": "Camera(lens_coefficients=)",
    "ortho": "Camera(height=)",
    "tile": "crop",
    "vfov": "Camera(vfov=)",
    "view": "Camera(view)",
}

# Values of options by identifier: words behind the option (none for a flag), and the value of the keyword. Some are wrong.
Choice = tuple[str | None, Any]
SELECTIONS = ["x > 0", "chain A", "ligand", "element C", "index < 5", "name CA"]
READ: dict[str, list[Choice]] = {
    "format": [("xyz", "xyz"), ("pdb", "pdb"), ("nonsense", "nonsense")],
    "columns": [("radius=speed", {"radius": "speed"}), ("x=none", "x=none")],
    "atom_style": [("full", "full")],
    "identity": [("row", "row"), ("none", "none")],
    "model": [("1", 1), ("7", 7)],
    "altloc": [("highest", "highest"), ("A", "A"), ("all", "all")],
    "assembly": [("1", 1), ("9", "9")],
    "as_listed": [(None, True)],
    "strict": [(None, True)],
    "skip_invalid": [(None, True)],
    "select": [(text, text) for text in SELECTIONS],
    "hide": [(text, text) for text in [*SELECTIONS, "all"]],
    "radii": [("covalent", "covalent"), ("vdw", "vdw"), ("none", "none")],
    "radius": [("0.5", 0.5), ("x > 0=0.7", {"x > 0": 0.7}), ("0", 0.0), ("-1", -1.0)],
    "radius_scale": [("0.5", 0.5), ("2", 2), ("0", 0)],
    "wrap": [(None, True)],
    "unwrap": [(None, True)],
    "copies": [("2,1,1", (2, 1, 1)), ("0,1,1", (0, 1, 1))],
    "move": [
        ("x > 0=1,2,3", {"x > 0": (1, 2, 3)}),
        ("1,2,3", "1,2,3"),
        ("all=1,2", {"all": (1, 2)}),
    ],
    "clip": [("0,0,1,0.5", [(0, 0, 1, 0.5)]), ("0,0,0,1", [(0, 0, 0, 1)])],
    "cell": [(None, True), ("0.2", 0.2), ("0", 0.0)],
    "color": [
        ("red", "red"),
        ("0.5,0.25,1", (0.5, 0.25, 1)),
        ("element", "element"),
        ("x > 0=#00ff00", {"x > 0": "#00ff00"}),
        ("chain A=element", {"chain A": "element"}),
        ("x > 0=red:right side", {"x > 0": "red:right side"}),
        ("nonsense", "nonsense"),
    ],
    "opacity": [("0.5", 0.5), ("x > 0=0.25", {"x > 0": 0.25}), ("0", 0), ("1.5", 1.5)],
    "material": [("x > 0=plastic", {"x > 0": "plastic"}), ("metal", "metal"), ("wood", "wood")],
    "shine": [("10", 10), ("0", 0)],
    "color_by": [
        ("x", "x"),
        ("element", "element"),
        ("chain", "chain"),
        ("speed", "speed"),
        ("vx,vy,vz", ("vx", "vy", "vz")),
        ("none", "none"),
    ],
    "map": [
        ("batlow", "batlow"),
        ("inferno_r", "inferno_r"),
        ("category", "category"),
        ("jet", "jet"),
    ],
    "range": [("0,2", (0, 2)), ("5%,95%", ("5%", "95%")), ("1,1", (1, 1)), ("1,1.0", (1, "1.0"))],
    "log": [(None, True)],
    "nan_color": [("teal", "teal"), ("0.5,0,0", (0.5, 0, 0))],
    "legend_title": [("right / nm", "right / nm")],
    "frames": [("2", 2), ("1", 1), ("9", 9)],
}
RENDER: dict[str, list[Choice]] = {
    "samples": [("1", 1), ("3", 3), ("0", 0)],
    "seed": [("7", 7)],
    "least_size": [("3", 3), ("0.5", 0.5), ("0", 0)],
    "cut": [
        ("0,0,1,0.5", (0, 0, 1, 0.5)),
        ("1,1,0,-1", [(1, 1, 0, -1)]),
        ("0,0,0,1", (0, 0, 0, 1)),
    ],
    "cut_slab": [("0,0,1,-1,2", (0, 0, 1, -1, 2)), ("0,0,1,2,1", [(0, 0, 1, 2, 1)])],
    "cut_at": [("all", "all"), ("x > 0:1,0,1", "x > 0:1,0,1"), ("chain A:0,0,0", "chain A:0,0,0")],
    "cut_only": [("x > 0", "x > 0")],
    "cut_color": [("red", "red"), ("x > 0=0.5,0,1", {"x > 0": (0.5, 0, 1)}), ("blak", "blak")],
    "exposure": [("0.5", 0.5), ("-1", -1), ("99", 99)],
    "tone": [("soft", "soft"), ("linear", "linear"), ("film", "film")],
    "shade": [("flat", "flat"), ("normal", "normal"), ("headlight", "headlight")],
    "look": [("plain", "plain"), ("soft", "soft"), ("figure", "figure"), ("none", "none")],
    "occlusion": [(None, True), ("5", 5), ("0", 0), ("5000000000", 5000000000)],
    "reach": [("2", 2), ("0", 0)],
    "sun": [("1,1,1", (1, 1, 1)), ("0,0,0", (0, 0, 0))],
    "shadows": [(None, True)],
    "bounces": [("2", 2), ("0", 0), ("65", 65)],
    "silhouette": [(None, True)],
    "outline_width": [("3", 3), ("0.01", 0.01), ("50", 50)],
    "outline_color": [("red", "red"), ("0,0.5,1", (0, 0.5, 1)), ("blak", "blak")],
    "depth_cue": [(None, True)],
    "depth_cue_strength": [("0.9", 0.9), ("0", 0)],
    "layers": [("2", 2), ("64", 64), ("65", 65)],
    "opacity_shadows": [(None, True)],
    "ghost_rim": [(None, True)],
    "background": [("white", "white"), ("0.2,0.3,0.4", (0.2, 0.3, 0.4))],
    "legend_in": [(None, True), ("top-left", "top-left"), ("bottom-right", "bottom-right")],
    "label": [("{file} {count}", "{file} {count}"), ("{time}", "{time}"), ("{who}", "{who}")],
    "scale_bar": [(None, True), ("nm", "nm")],
    "mark": [("x > 1={z}", {"x > 1": "{z}"}), ("ligand={resname}", {"ligand": "{resname}"})],
    "mark_one": [("x > 1=many", {"x > 1": "many"})],
    "mark_all": [(None, True)],
    "accuracy": [
        ("fast", "fast"),
        ("certified", "certified"),
        ("exact", "exact"),
        ("auto", "auto"),
    ],
    "method": [("stable", "stable"), ("f64", "f64"), ("none", "none")],
    "tolerance": [("1e-3", 1e-3), ("1e-30", 1e-30)],
    "transparent": [(None, True)],
    "cryptomatte": [("id", "id"), ("chain", "chain"), ("none", "none")],
}
# Options that most files refuse, and those that files without molecules refuse too.
REFUSED = {
    "format",
    "columns",
    "atom_style",
    "model",
    "as_listed",
    "assembly",
    "identity",
    "unwrap",
}
OF_MOLECULES = {"altloc", "frames", "cell", "wrap", "copies"}
OF_PARTICLES = {
    "select",
    "move",
    "hide",
    "color",
    "color_by",
    "opacity",
    "material",
    "radius",
    "radii",
}
# Options that curved lenses refuse.
LIT = {"look", "silhouette", "depth_cue", "sun", "shadows", "occlusion", "scale_bar"}
# Options that need another one.
NEEDED = {
    **dict.fromkeys(["map", "range", "log", "nan_color", "legend_in"], "color_by"),
    "shine": "material",
    "mark_all": "mark",
    **dict.fromkeys(["cut_only", "cut_color"], "cut"),
    "depth_cue_strength": "depth_cue",
}
# These are keywords of the call that saves the picture.
SAVE: dict[str, list[Choice]] = {
    "bits": [("16", 16), ("8", 8), ("12", 12)],
    "dpi": [("300", 300), ("72.5", 72.5), ("0", 0)],
    "trim": [(None, True)],
}
# These are drawn with a camera.
LENS = {"aperture": [("0.5", 0.5)], "focus_distance": [("20", 20)]}
AOVS = ["depth", "distance", "normal", "position", "mask", "shadow", "occlusion", "alpha", "bound"]
# Options whose value follows an equals sign, since they may have none.
OPTIONAL = {"cell", "legend_in", "scale_bar", "occlusion"}
# Words of reports that say how long a frame took, where it is, and how it was asked for.
UNEQUAL = re.compile("_ms$|^(resumed|hold|bytes_|memory|number$)")


def molecule() -> str:
    """Two chains with a ligand, a cell, and a place with two locations."""
    rows = []
    draw = random.Random(1)
    names = ["N", "CA", "C", "O"]
    for n in range(24):
        chain, residue = "AB"[n // 12], n // 4 + 1
        place = [draw.uniform(-4, 4) for _ in range(3)]
        location = "AB"[n % 2] if n in (8, 9) else " "
        name = names[n % 4]
        rows.append(("ATOM  ", n + 1, name, location, "GLY", chain, residue, place, name[0]))
    for n in range(8):
        place = [n * 1.3 - 4, 0.5 * (n % 2), 5.0]
        rows.append(("HETATM", 25 + n, f"C{n}", " ", "LIG", "A", 99, place, "C"))
    lines = ["CRYST1   10.000   10.000   10.000  90.00  90.00  90.00 P 1           1"]
    for kind, number, name, location, residue, chain, resid, (x, y, z), element in rows:
        lines.append(
            f"{kind}{number:5d}  {name:<3}{location}{residue} {chain}{resid:4d}    "
            f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00{number:6.2f}          {element:>2}"
        )
    return "\n".join([*lines, "END", ""])


def table() -> str:
    draw = random.Random(2)
    rows = ["x,y,z,radius,speed,vx,vy,vz"]
    for n in range(30):
        numbers = [draw.uniform(-3, 3) for _ in range(3)]
        speed = "nan" if n in (3, 17) else f"{draw.uniform(-1, 4):.4f}"
        v = [f"{draw.uniform(-1, 1):.3f}" for _ in range(3)]
        rows.append(
            ",".join([*(f"{x:.4f}" for x in numbers), f"{draw.uniform(0.2, 0.9):.3f}", speed, *v])
        )
    return "\n".join([*rows, ""])


def frames() -> str:
    draw = random.Random(3)
    text = ""
    for _ in range(3):
        text += (
            '12\nLattice="6 0 0 0 6 0 0 0 6" Properties=species:S:1:pos:R:3:speed:R:1 Time=2.5\n'
        )
        for n in range(12):
            x, y, z = (draw.uniform(-1, 7) for _ in range(3))
            text += f"{'CNO'[n % 3]} {x:.4f} {y:.4f} {z:.4f} {draw.random():.4f}\n"
    return text


SCENE = """
[camera]
eye = [0.0, 1.0, 9.0]
at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
vfov = 40.0
[image]
size = [30, 20]
[[light]]
direction = [1, 2, 3]
[[sphere]]
center = [0.0, 0.0, 0.0]
radius = 1.5
color = [0.4, 0.2, 0.1]
[[sphere]]
center = [1.5, 0.5, 1.0]
radius = 0.7
"""
NAMED: dict[str, tuple[list[str], dict[str, Any]]] = {
    "lens fisheye": (["--lens", "fisheye", "--vfov", "70"], {"lens": "fisheye", "vfov": 70}),
    "lens equirectangular": (["--lens", "equirectangular"], {"lens": "equirectangular"}),
    "lens opencv": (
        [
            *("--lens", "opencv", "--intrinsics", "30,31,14,10"),
            "--lens-coefficients=-0.1,0.01,0.001,-0.002,0.003",
        ],
        {
            "lens": "opencv",
            "intrinsics": (30, 31, 14, 10),
            "lens_coefficients": [-0.1, 0.01, 0.001, -0.002, 0.003],
        },
    ),
}
POSE = [[1, 0, 0, 0.5], [0, 1, 0, 0.25], [0, 0, 1, 14.0], [0, 0, 0, 1]]
LENSES = {
    "distorted": {
        "fl_x": 30,
        "fl_y": 30,
        "cx": 15,
        "cy": 10,
        "k1": 0.05,
        "camera_model": "OPENCV",
    },
    "fisheye": {
        "fl_x": 14,
        "fl_y": 14,
        "cx": 15,
        "cy": 10,
        "camera_model": "OPENCV_FISHEYE",
        "k1": 0.01,
    },
    "panorama": {"camera_model": "EQUIRECTANGULAR"},
    "pinhole": {"fl_x": 30, "fl_y": 31, "cx": 14, "cy": 10},
}
CURVED = ("distorted", "fisheye", "panorama", *NAMED)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("choices")
    for name, text in [
        ("m.pdb", molecule()),
        ("t.csv", table()),
        ("f.xyz", frames()),
        ("s.toml", SCENE),
    ]:
        (folder / name).write_text(text)
    for name, lens in LENSES.items():
        camera = {**lens, "w": 30, "h": 20, "frames": [{"transform_matrix": POSE}]}
        (folder / f"{name}.json").write_text(json.dumps(camera))
    return folder


class Draw:
    """The choices of one picture, in the words of the command and as keywords."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.words: list[str] = []
        self.refusal = ""
        self.read: dict[str, Any] = {}
        self.render: dict[str, Any] = {}
        self.save: dict[str, Any] = {}
        self.file = self.random.choice(["m.pdb"] * 3 + ["t.csv"] * 2 + ["f.xyz"] * 2 + ["s.toml"])
        self.camera, self.pose = self.of_camera()
        chosen = self.random.sample(sorted(READ), self.random.choice([0, 0, 1, 2, 3, 4]))
        # Most draws have no option that the file refuses.
        if self.random.random() < 0.9:
            refused = OF_MOLECULES if self.file != "m.pdb" else REFUSED
            if self.file == "s.toml":
                refused = refused | OF_PARTICLES
            chosen = [name for name in chosen if name not in REFUSED | refused]
        if self.camera in [*LENSES, "fit", "focus"]:
            # Frame 2 has camera 2 of a list. The camera that shows all spheres belongs to frame 1.
            chosen = [name for name in chosen if name != "frames"]
        if self.camera == "focus":
            # The command selects a focus in the file, Python in the scene: of what is left, and of all copies.
            chosen = [name for name in chosen if name not in ("select", "hide", "copies")]
        drawn = self.random.sample(sorted(RENDER), self.random.choice([0, 1, 2, 3, 4]))
        if self.camera in ("fit", "focus"):
            # A camera that Python fits knows no legend.
            drawn = [name for name in drawn if name != "legend_in"]
        if self.camera in CURVED and self.random.random() < 0.8:
            drawn = [name for name in drawn if name not in LIT]
        for name, needed in NEEDED.items():
            # Most draws have what an option needs, and scenes have none of it.
            if self.file == "s.toml":
                chosen, drawn = (
                    [other for other in all if other != name] for all in (chosen, drawn)
                )
            elif (
                name in chosen + drawn
                and needed not in chosen + drawn
                and self.random.random() < 0.9
            ):
                (chosen if needed in READ else drawn).append(needed)
        for name in chosen:
            self.add(name, READ, self.read)
        for name in drawn:
            self.add(name, RENDER, self.render)
        is_wide = self.camera not in LENSES and self.render.keys() & {
            "label",
            "legend",
            "scale_bar",
        }
        self.size = (160, 120) if is_wide else (30, 20)
        if self.render.keys() & {"mark", "cryptomatte"}:
            self.read["keep"] = True
        self.aovs = self.random.sample(AOVS, self.random.choice([0, 0, 1, 2]))
        if self.random.random() < 0.8:
            lit = self.camera not in CURVED
            refused = {"shadow"} if lit else {"shadow", "occlusion", "bound"}
            self.aovs = [name for name in self.aovs if name not in refused]
        # Python's masks are in files of any buffers.
        is_matte = "cryptomatte" in self.render
        self.has_picture = self.random.random() < 0.9 or not self.aovs or is_matte
        self.ending = (
            ".exr"
            if "cryptomatte" in self.render
            else self.random.choice([".png", ".png", ".exr"])
        )
        if self.has_picture and self.random.random() < 0.2:
            self.add(self.random.choice(sorted(SAVE)), SAVE, self.save)

    def add(self, name: str, choices: dict[str, list[Choice]], keywords: dict[str, Any]) -> None:
        word, value = self.random.choice(choices[name])
        # Most draws have no mistake.
        if self.random.random() < 0.75:
            word, value = choices[name][0]
        option = "--" + name.replace("_", "-")
        if word is None:
            self.words.append(option)
        elif name in OPTIONAL:
            self.words.append(f"{option}={word}")
        else:
            self.words += [option, word]
        keywords[{"frames": "frames", "legend_in": "legend"}.get(name, name)] = value

    def of_camera(self) -> tuple[str, dict[str, Any]]:
        """A camera: its kind, and the keywords of a `Camera`."""
        kind = self.random.choice(
            ["own", "own", "eye", "height", "aperture", *NAMED, "fit", "focus", *LENSES]
        )
        x, y = self.random.uniform(-3, 3), self.random.uniform(-3, 3)
        eye, at = (x, y, 20.0), (0.0, 0.5, 0.25)
        pose: dict[str, Any] = {"eye": eye, "at": at}
        written = ["--eye", f"{x!r},{y!r},20", "--at", "0,0.5,0.25"]
        match kind:
            case "eye":
                self.words += [*written, "--vfov", "35"]
                pose["vfov"] = 35
            case "height":
                self.words += [*written, "--ortho", "11"]
                pose["height"] = 11
            case "aperture":
                self.words += [
                    *written,
                    "--vfov",
                    "35",
                    "--aperture",
                    "0.5",
                    "--focus-distance",
                    "19",
                ]
                pose |= {"vfov": 35, "aperture": 0.5, "focus": 19}
            case "lens fisheye" | "lens equirectangular" | "lens opencv":
                words, lens = NAMED[kind]
                self.words += [*written, *words]
                pose |= lens
            case "fit" if self.file != "s.toml":
                view = self.random.choice(["right", "top", "iso", "auto"])
                self.words += ["--view", view]
                pose = {"view": view}
            case "focus" if self.file == "m.pdb":
                self.words += ["--focus", "ligand"]
                pose = {"focus": "ligand"}
            case "fit" | "focus":
                kind = "own"
        return kind, pose

    def command(self, folder: Path, out: Path) -> list[str]:
        words = [
            "render",
            str(folder / self.file),
            *self.words,
            "--backend",
            "cpu",
            "--json",
            "--quiet",
        ]
        if self.camera in LENSES:
            words += ["--cameras", str(folder / f"{self.camera}.json")]
        else:
            words += ["--size", "{}x{}".format(*self.size)]
        if self.has_picture:
            words += ["-o", str(out / f"picture{self.ending}")]
        return words + [f"--aov={name}={out / f'{name}.npy'}" for name in self.aovs]

    def package(
        self, folder: Path, out: Path, renderer: hl.Renderer
    ) -> tuple[hl.Frame, list[str]]:
        """The frame and the warnings of Python."""
        size = None if self.camera in LENSES else self.size
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            options = dict(self.read)
            number = options.pop("frames", None)
            if number is None:
                scene = hl.read(folder / self.file, size=size, **options)
            else:
                scene = next(hl.read_frames(folder / self.file, str(number), size=size, **options))
            camera = None
            if self.camera in LENSES:
                camera = hl.read_cameras(folder / f"{self.camera}.json")[0]
            elif "eye" in self.pose and self.camera != "own":
                camera = hl.Camera(**self.pose)
            elif self.camera in ("fit", "focus"):
                camera = hl.Camera.fit(scene, size=size, **self.pose)
            aovs = (["color"] if self.has_picture else []) + self.aovs
            frame = renderer.render(scene, camera, size=size, aovs=aovs, **self.render)
            if self.has_picture:
                frame.save(out / f"package{self.ending}", aovs=["color"], **self.save)
        return frame, [str(warning.message) for warning in caught]


def in_keywords(message: str) -> str:
    """A message of the command with keywords in place of options."""

    def keyword(found: re.Match[str]) -> str:
        name = found[1].replace("-", "_")
        return RENAMED.get(name, name)

    return re.sub("--([a-z]+(?:-[a-z]+)*)", keyword, message)


def differences(draw: Draw, folder: Path, out: Path, renderer: hl.Renderer) -> list[str]:
    """What the command and the package do not have in common."""
    code = "import sys; from halfline import _halfline; sys.exit(_halfline.command(sys.argv[1:]))"
    command = ["python", "-c", code] if not commands() else [commands()[0]]
    done = subprocess.run(
        [*command, *draw.command(folder, out)], capture_output=True, text=True, timeout=120
    )
    fault: Exception | None = None
    try:
        frame, caught = draw.package(folder, out, renderer)
    except (ValueError, MemoryError) as error:
        fault = error
    expected = {0: type(None), 2: ValueError, 3: ValueError, 5: MemoryError, 7: hl.AccuracyError}
    if not isinstance(fault, expected.get(done.returncode, ())):
        return [f"exit code {done.returncode}: {done.stderr}", f"and Python: {fault!r}"]
    if fault is not None:
        draw.refusal = str(fault)
        return []
    found = []
    if draw.has_picture:
        one, other = (
            (out / f"{name}{draw.ending}").read_bytes() for name in ("picture", "package")
        )
        if one != other:
            found.append("the bytes of the pictures")
    for name in draw.aovs:
        if not np.array_equal(np.load(out / f"{name}.npy"), frame[name], equal_nan=True):
            found.append(f"the buffer {name}")
    report = json.loads(done.stdout)
    said = sorted(in_keywords(warning) for warning in report["warnings"])
    if said != sorted([*frame.warnings, *caught]):
        found.append(f"warnings: {said} and {[*frame.warnings, *caught]}")
    for name in report.keys() & frame.report.keys() - {"warnings"}:
        if not UNEQUAL.search(name) and report[name] != frame.report[name]:
            found.append(f"{name}: {report[name]!r} and {frame.report[name]!r}")
    return found


def test_the_same_choices_are_the_same_pictures(
    folder: Path, tmp_path: Path, cpu: hl.Renderer
) -> None:
    wrong, refused = [], 0
    for seed in range(DRAWS):
        draw = Draw(seed)
        found = differences(draw, folder, tmp_path, cpu)
        if found:
            line = " ".join([draw.file, *draw.words])
            wrong.append("\n  ".join([f"{seed}: {line} ({draw.camera})", *found]))
        refused += bool(draw.refusal)
    print(f"{DRAWS} draws; both refuse {refused} of them")
    assert not wrong, f"{len(wrong)} of {DRAWS}:\n" + "\n".join(wrong)


def test_every_option_with_a_keyword_is_drawn() -> None:
    text = (ROOT / "command/src/option_table.rs").read_text()
    rows = re.findall(r'row\(\s*"(\w+)",\s*Keyword\((\w+),', text)
    assert len(rows) > 60, "the table of options"
    drawn = READ.keys() | RENDER.keys() | SAVE.keys() | LENS.keys() | ELSEWHERE.keys()
    lacking = {name for name, _ in rows} - drawn
    assert not lacking, f"options without a choice here: {sorted(lacking)}"
    stale = drawn - {name for name, _ in rows}
    assert not stale, f"choices of options without a keyword: {sorted(stale)}"


def test_public_names_are_those_that_are_listed() -> None:
    assert sorted(dir(hl)) == sorted(hl.__all__)
    leaked = {
        name
        for name, value in vars(hl).items()
        if not name.startswith("_")
        and name not in hl.__all__
        and value.__class__.__name__ != "module"
    }
    assert not leaked
    modules = {name for name, value in vars(hl).items() if value.__class__.__name__ == "module"}
    assert {name for name in modules if not getattr(hl, name).__name__.startswith("halfline")} == {
        "_os"
    }
