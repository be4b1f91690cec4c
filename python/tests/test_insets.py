"""Legend, label, scale bar and cell of pictures: the same as the command's, byte for byte."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SCENES, commands, run

import halfline as hl

DUMP = """\
ITEM: TIMESTEP
700
ITEM: NUMBER OF ATOMS
4
ITEM: BOX BOUNDS pp pp pp
0 10
0 8
0 6
ITEM: ATOMS id type x y z speed
1 1 1 1 1 0.5
2 1 9 1 1 1.5
3 2 1 7 5 2.5
4 2 9 7 5 3.5
"""

# The look of the package, for the command.
PLAIN = ["--look", "plain", "--samples", "1", "--backend", "cpu", "--size", "300x200"]


@pytest.fixture
def dump(tmp_path: Path) -> Path:
    path = tmp_path / "run.dump"
    path.write_text(DUMP)
    return path


@pytest.mark.parametrize(
    ("reading", "drawing", "arguments"),
    [
        ({"color_by": "speed"}, {"legend": True}, ["--color-by", "speed", "--legend-in"]),
        (
            {"color_by": "speed"},
            {"legend": "top-left", "label": "{file} {count}"},
            ["--color-by", "speed", "--legend-in=top-left", "--label", "{file} {count}"],
        ),
        ({}, {"label": "step {step}, frame {frame}"}, ["--label", "step {step}, frame {frame}"]),
        ({}, {"scale_bar": "nm"}, ["--scale-bar=nm"]),
        ({}, {"scale_bar": True}, ["--scale-bar"]),
        ({}, {"cell": True}, ["--cell"]),
        (
            {"copies": (2, 1, 1), "color_by": "type"},
            {"cell": 0.2, "legend": "bottom-right"},
            "--copies 2,1,1 --color-by type --cell=0.2 --legend-in=bottom-right".split(),
        ),
    ],
)
def test_pictures_are_those_of_the_command(
    cpu: hl.Renderer,
    dump: Path,
    tmp_path: Path,
    reading: dict[str, Any],
    drawing: dict[str, Any],
    arguments: list[str],
) -> None:
    theirs, mine = tmp_path / "theirs.png", tmp_path / "mine.png"
    run(commands()[0], "render", dump, "-o", theirs, *PLAIN, *arguments)
    frame = cpu.render(hl.read(dump, **reading), size=(300, 200), look="plain", **drawing)
    frame.save(mine)
    assert mine.read_bytes() == theirs.read_bytes()


def test_numbers_do_not_show_what_is_drawn(cpu: hl.Renderer, dump: Path, tmp_path: Path) -> None:
    scene = hl.read(dump, color_by="speed")
    # Without a camera the spheres would be framed beside the legend.
    camera = hl.Camera((5, 4, 30))
    plain = cpu.render(scene, camera, size=(300, 200), aovs=["color", "depth"])
    drawn = cpu.render(
        scene, camera, size=(300, 200), aovs=["color", "depth"], legend=True, label="x"
    )
    assert np.isfinite(plain["depth"]).any()
    assert np.array_equal(plain["color"], drawn["color"])
    assert not np.array_equal(plain.image, drawn.image)
    # Only where the panels are.
    assert np.array_equal(plain.image[-20:, :100], drawn.image[-20:, :100])
    assert drawn._repr_png_() != plain._repr_png_()
    for frame, name in ((plain, "plain.npy"), (drawn, "drawn.npy")):
        frame.save(tmp_path / name, aovs="color")
    assert np.array_equal(np.load(tmp_path / "plain.npy"), np.load(tmp_path / "drawn.npy"))
    assert np.array_equal(plain["color"], drawn["color"])


def test_the_legend_has_a_file_of_its_own(cpu: hl.Renderer, dump: Path, tmp_path: Path) -> None:
    scene = hl.read(dump, color_by="speed")
    for name in ("legend.svg", "legend.png"):
        theirs = tmp_path / f"their-{name}"
        arguments = ["--color-by", "speed", "--legend", theirs, "-o", tmp_path / "x.png"]
        run(commands()[0], "render", dump, *PLAIN, *arguments)
        frame = cpu.render(scene, size=(30, 20), legend=tmp_path / name)
        assert (tmp_path / name).read_bytes() == theirs.read_bytes()
        assert np.array_equal(frame.image, cpu.render(scene, size=(30, 20)).image)
    cameras = [hl.Camera((5, 4, z)) for z in (30, 40)]
    list(cpu.render_many(scene, cameras, size=(30, 20), legend=tmp_path / "many.svg"))
    assert (tmp_path / "many.svg").read_bytes() == (tmp_path / "legend.svg").read_bytes()


def test_many_views_have_their_label_and_the_cell(cpu: hl.Renderer, dump: Path) -> None:
    scene = hl.read(dump)
    cameras = [hl.Camera((5, 4, z)) for z in (30, 40)]
    options: dict[str, Any] = {"size": (200, 150), "label": "view {frame}", "cell": True}
    frames = list(cpu.render_many(scene, cameras, **options))
    assert frames[0]["id"].max() >= len(scene)
    bare = [cpu.render(scene, camera, size=(200, 150), cell=True) for camera in cameras]
    for frame, other in zip(frames, bare, strict=True):
        assert np.array_equal(frame["color"], other["color"])
        assert not np.array_equal(frame.image, other.image)
    one = cpu.render(scene, cameras[1], size=(200, 150), label="view 2", cell=True)
    assert np.array_equal(frames[1].image, one.image)


def test_the_cell_is_drawn_once_and_leaves_the_scene(cpu: hl.Renderer, dump: Path) -> None:
    scene = hl.read(dump)
    frame = cpu.render(scene, size=(80, 60), cell=True)
    assert len(scene) == 4 and frame.report["spheres"] > 4
    outlined = hl.read(dump, cell=True)
    assert len(outlined) == frame.report["spheres"]
    for options in ({}, {"cell": True}):
        other = cpu.render(outlined, size=(80, 60), **options)  # type: ignore[arg-type]
        assert np.array_equal(other["id"], frame["id"])
        assert other.report["spheres"] == len(outlined)
    ids = frame["id"]
    inside = (ids >= 0) & (ids < len(scene))
    assert set(np.unique(ids[inside])) == {0, 1, 2, 3}
    # Without a camera the beads are in the picture too, as in the command.
    assert cpu.plan(scene, size=(80, 60), cell=True)["spheres"] == frame.report["spheres"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"legend": True}, "legend: the spheres have neither elements nor a column.*color_by"),
        ({"legend": "x.svg"}, "legend: the spheres have neither"),
        ({"legend": "left"}, "legend: there is no corner 'left'; choose from right, top-left"),
        (
            {"legend": "x.pdf"},
            "a legend cannot be written to x.pdf; use the file name extension .svg",
        ),
        ({"legend": 3}, "legend is 3"),
        ({"label": "{time}"}, "^label has {time}, but the frame has no time.*or use {step}"),
        ({"label": "{who}"}, "{frame}, {file}, {count}, {time} or {step}"),
        ({"label": " "}, "the label is empty"),
        ({"label": 3}, "label is 3"),
        ({"scale_bar": 3}, "scale_bar is 3"),
        ({"label": "x", "crop": (0, 0, 9, 9)}, "legend, label and scale_bar.*remove crop"),
        ({"label": "x", "aovs": "depth"}, "add 'color' to aovs"),
        ({"label": "x" * 20, "size": (20, 12)}, "too small.*use a larger size"),
        ({"cell": -1}, "cell is -1"),
        ({"cell": "x"}, "cell is 'x'"),
        ({"dtype": "float16"}, "dtype is 'float16'; give 'float32' or 'float64'"),
        ({"dtype": "real"}, "dtype is 'real'"),
    ],
)
def test_misuse_names_the_keyword(
    cpu: hl.Renderer, dump: Path, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        cpu.render(hl.read(dump), **{"size": (300, 200), **options})
    assert "--" not in str(caught.value)


def test_what_a_scene_lacks_is_said(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    with pytest.raises(ValueError, match="the scene has no file"):
        cpu.render(cloud, size=(90, 60), label="{file}")
    with pytest.raises(ValueError, match="needs a periodic cell"):
        cpu.render(cloud, size=(90, 60), cell=True)
    away = hl.Camera((0, 0, 9), view=(0, 0, 1))
    with pytest.raises(ValueError, match=r"scale_bar needs the middle.*Camera"):
        cpu.render(cloud, away, size=(90, 60), scale_bar=True)
    assert cpu.render(cloud, size=(90, 60), label="{count} of {frame}").image.shape == (60, 90, 3)


def test_letters_that_the_font_lacks_are_warned_of(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    frame = cpu.render(cloud, size=(200, 100), label="a\ue000")
    assert any("U+E000" in warning for warning in frame.warnings)


def test_scene_files_have_labels_too(cpu: hl.Renderer, tmp_path: Path) -> None:
    theirs, mine = tmp_path / "theirs.exr", tmp_path / "mine.exr"
    scene = SCENES / "weekend.toml"
    words = ["--size", "300x200", "--backend", "cpu", "--label", "{file}", "--scale-bar=m"]
    run(commands()[0], "render", scene, "-o", theirs, *words)
    frame = cpu.render(hl.read(scene), size=(300, 200), label="{file}", scale_bar="m")
    frame.save(mine, aovs="color")
    assert mine.read_bytes() == theirs.read_bytes()


def test_mattes_are_those_of_the_command(cpu: hl.Renderer, dump: Path) -> None:
    scene = hl.read(dump, keep=True)
    layers = ["type", "id", "serial"]
    frame = cpu.render(scene, size=(300, 200), look="plain", samples=4, cryptomatte=layers)
    frame.save(dump.parent / "own.exr", aovs="color")
    words = [word for layer in layers for word in ("--cryptomatte", layer)]
    plain = "--look plain --samples 4 --backend cpu --size 300x200".split()
    run(commands()[0], "render", dump, "-o", dump.parent / "other.exr", *plain, *words)
    own, other = ((dump.parent / name).read_bytes() for name in ("own.exr", "other.exr"))
    assert b"CryptoType" in own and own == other
    with pytest.raises(ValueError, match="cryptomatte names spheres by `chain`"):
        cpu.render(scene, cryptomatte="chain")
    single = cpu.render(scene, size=(30, 20), cryptomatte="id", aovs="depth")
    single.save(dump.parent / "depth.exr")
    assert b"CryptoId" in (dump.parent / "depth.exr").read_bytes()
