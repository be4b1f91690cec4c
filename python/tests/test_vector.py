"""Figures without pixels: paths, names, files as the command writes them, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import commands, run

import halfline as hl

ATOMS = """\
ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  9.00           N
ATOM      2  CA  GLY A   1       1.200   0.300   0.100  1.00  9.00           C
ATOM      3  O   GLY B   2       0.300   1.500   0.900  1.00  9.00           O
"""


def scene() -> hl.Scene:
    return hl.Scene(
        [[0, 0, 0], [1, 0.5, 0], [0, 0, -2]], [1.0, 1.0, 0.1], ["red", "blue", "green"]
    )


def test_a_figure_has_a_path_for_each_visible_sphere(tmp_path: Path) -> None:
    camera = hl.Camera((0, 0, 9), at=(0, 0, 0), vfov=30)
    figure = scene().vector(camera, size=(200, 150), shade="flat")
    assert figure.paths == 2 and repr(figure) == "Vector(2 paths)"
    assert set(re.findall(r'<path id="(s\d)"', figure.svg)) == {"s0", "s1"}
    assert figure._repr_svg_() == figure.svg
    assert figure.pdf.startswith(b"%PDF-1.7")
    figure.save(tmp_path / "a.svg")
    figure.save(str(tmp_path / "a.PDF"))
    assert (tmp_path / "a.svg").read_text() == figure.svg
    assert (tmp_path / "a.PDF").read_bytes() == figure.pdf
    with pytest.raises(ValueError, match=r"\.svg or \.pdf"):
        figure.save(tmp_path / "a.png")


def test_names_and_groups_are_those_of_columns(tmp_path: Path) -> None:
    (tmp_path / "a.pdb").write_text(ATOMS)
    molecule = hl.read(tmp_path / "a.pdb")
    lit = molecule.vector(size=(300, 200), label="atoms", mark={"chain A": "here"})
    assert (
        'data-residue="A/GLY/1"' in lit.svg
        and ">atoms</text>" in lit.svg
        and ">here</text>" in lit.svg
    )
    by_chain = molecule.vector(size=(300, 200), group="chain", detail=0)
    assert re.findall(r'<g id="(chain-.)"', by_chain.svg) == ["chain-A", "chain-B"]
    assert 'width="25.4mm"' in molecule.vector(size=(300, 200), dpi=300).svg


@pytest.mark.skipif(not commands(), reason="there is no command")
def test_figures_are_those_of_the_command(tmp_path: Path) -> None:
    (tmp_path / "a.pdb").write_text(ATOMS)
    words = "--size 300x200 --backend cpu --group chain --detail 0.5 --look plain --label atoms"
    words += " --background white --mark-one chain~A=here"
    given = [word.replace("~", " ") for word in words.split()]
    run(commands()[0], "render", tmp_path / "a.pdb", "-o", tmp_path / "a.svg", *given)
    molecule = hl.read(tmp_path / "a.pdb")
    figure = molecule.vector(
        size=(300, 200),
        group="chain",
        detail=0.5,
        look="plain",
        label="atoms",
        background="white",
        mark_one={"chain A": "here"},
    )
    assert figure.svg == (tmp_path / "a.svg").read_text()


def test_faces_of_planes_are_paths() -> None:
    camera = hl.Camera((0, 0, 9), at=(0, 0, 0), vfov=30)
    figure = scene().vector(camera, size=(200, 150), cut=[0, 0, 1, 0.5])
    assert "s0-cut0" in figure.svg


def test_what_only_pixels_show_is_refused() -> None:
    for keywords, mend in [
        ({"sun": [1, 1, 1]}, "remove the suns"),
        ({"samples": 4}, "samples are of pixels"),
        ({"shade": "normal"}, "flat or headlight"),
        ({"depth_cue": True}, "depth cue"),
        ({"crop": (0, 0, 9, 9)}, "parts of a picture"),
        ({"group": "nothing"}, "no such column"),
        ({"detail": -1}, "from 0 to 100"),
    ]:
        with pytest.raises(ValueError, match=mend):
            scene().vector(size=(40, 30), **keywords)  # type: ignore[arg-type]
    clear = hl.Scene(np.zeros((1, 3)), 1.0, opacities=0.5)
    with pytest.raises(ValueError, match="remove the opacity"):
        clear.vector(size=(40, 30))
    with pytest.raises(TypeError, match="group"):
        hl.render(scene(), group="chain")  # type: ignore[call-arg]
