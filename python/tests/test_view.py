"""The view of a notebook without a browser: messages in, messages out."""

import base64
import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import commands, run

import halfline as hl

pytest.importorskip("anywidget", reason="anywidget is not installed")

from traitlets import TraitError

from halfline.view import View

SIZE = (160, 120)
PDB = "".join(
    f"ATOM  {k + 1:5}  CA  ALA {'AB'[k % 2]}{k:4}    {k % 5 * 2.5:8.3f}{k // 5 * 2.5:8.3f}"
    f"{k % 3:8.3f}  1.00{k:6.2f}           C\n"
    for k in range(40)
)


class Page:
    """The other end of the comm."""

    def __init__(self, view: View) -> None:
        self.view, self.last = view, 0
        self.answers: dict[int, tuple[dict[str, Any], list[bytes]]] = {}
        self.changed = threading.Condition()
        view.send = self.hear

    def hear(self, content: dict[str, Any], buffers: list[bytes] | None = None) -> None:
        json.dumps(content, allow_nan=False)
        with self.changed:
            assert content["id"] not in self.answers, "one answer for each request"
            self.answers[content["id"]] = content, buffers or []
            self.changed.notify_all()

    def send(self, route: str, body: Any) -> int:
        self.last += 1
        message = {"id": self.last, "route": route, "body": body}
        self.view._handle_custom_msg(message, [])
        return self.last

    def wait(self, number: int) -> tuple[dict[str, Any], list[bytes]]:
        with self.changed:
            assert self.changed.wait_for(lambda: number in self.answers, 60), "no answer"
            return self.answers[number]

    def ask(self, route: str, body: Any) -> tuple[dict[str, Any], list[bytes]]:
        return self.wait(self.send(route, body))

    def json(self, route: str, body: Any) -> Any:
        content, buffers = self.ask(route, body)
        assert content["status"] == 200 and not buffers, content
        return content["json"]

    def body(self, **more: Any) -> dict[str, Any]:
        return {"seq": self.last, "camera": self.view.camera, "size": list(SIZE), **more}

    def still(self, **more: Any) -> bytes:
        content, (picture,) = self.ask("/frame", self.body(**{"mode": "still", **more}))
        assert content["status"] == 200
        return picture


@pytest.fixture
def molecule(tmp_path: Path) -> hl.Scene:
    (tmp_path / "two.pdb").write_text(PDB)
    return hl.read(tmp_path / "two.pdb", color_by="chain")


@pytest.fixture
def page(molecule: hl.Scene, cpu: hl.Renderer) -> Iterator[Page]:
    view = molecule.view(renderer=cpu, size=SIZE, silhouette=True)
    yield Page(view)
    view.close()


def test_the_page_learns_the_scene(page: Page, molecule: hl.Scene) -> None:
    assert page.json("/progress", {}) == {"state": "ready", "text": ""}
    scene = page.json("/scene", {})
    assert scene["file"] == "two.pdb" and scene["count"] == 40 and scene["frames"] == 1
    assert scene["columns"]["chain"] == {"type": "text", "count": 2, "values": ["A", "B"]}
    assert scene["columns"]["bfactor"] == {"type": "number", "min": 0, "max": 39}
    assert scene["look"] == "soft" and scene["samples"] == 4 and scene["background"] == "#000000"
    assert scene["legend"].startswith("<svg")
    rows = {row["id"]: row for row in scene["controls"]}
    assert rows["look"]["values"] == ["plain", "soft", "figure"]
    assert rows["look"]["value"] == "soft"
    assert set(rows) == {"look", "samples", "layers", "background", "opacity", "cut", "clip"}
    low, high = np.array(scene["extent"])
    assert np.array_equal(low, (molecule.centers - molecule.radii[:, None]).min(axis=0))
    assert scene["radius"] == pytest.approx(np.linalg.norm(high - low) / 2)
    assert {"eye", "at", "up", "vfov"} == set(scene["camera"]) and scene["size"] == list(SIZE)


def test_a_still_is_what_is_saved_and_copied(
    page: Page, molecule: hl.Scene, cpu: hl.Renderer, tmp_path: Path
) -> None:
    content, (picture,) = page.ask("/frame", page.body(mode="still"))
    frame = cpu.render(molecule, page.view.to_camera(), size=SIZE, silhouette=True)
    frame.save(tmp_path / "saved.png")
    assert (tmp_path / "saved.png").read_bytes() == picture == frame.to_png() == page.view.still
    info = content["info"]
    assert info["look"] == "soft" and info["samples"] == 4 and info["adapter"] == "cpu"
    assert info["certified"] <= 1 and info["settled"] >= 0 and info["ms"] > 0
    assert info["unit"] == pytest.approx(
        2 * np.tan(np.radians(15)) * np.linalg.norm(np.subtract(*pair(page.view.camera))) / 120
    )


def pair(camera: dict[str, Any]) -> tuple[Any, Any]:
    return camera["eye"], camera["at"]


@pytest.mark.parametrize("select", [None, "chain A and x > 2"])
def test_copied_lines_render_what_is_seen(
    page: Page, molecule: hl.Scene, select: str | None, tmp_path: Path, monkeypatch: Any
) -> None:
    page.view.camera = {"eye": [9, 3, 40.5], "at": [5, 5, 0], "up": [0, 1, 0], "height": 25}
    options = {"look": ["figure"], "samples": ["2"], "clip": ["1,0,0,7"], "opacity": ["0.5"]}
    body = page.body(select=select, options=options, mode="still")
    picture = page.still(**body)
    lines = page.json("/command", body)
    monkeypatch.chdir(tmp_path)
    exec(lines["python"], {})
    assert (tmp_path / "two-view.png").read_bytes() == picture, lines["python"]
    (tmp_path / "two-view.png").unlink()
    for command in commands():
        program = tmp_path / "halfline"
        program.unlink(missing_ok=True)
        program.symlink_to(command)
        script = f"PATH={tmp_path}:$PATH; {lines['shell']}"
        done = subprocess.run(["sh", "-c", script], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "two-view.png").read_bytes() == picture, lines["shell"]


def test_copied_lines_have_every_keyword(cpu: hl.Renderer, tmp_path: Path) -> None:
    (tmp_path / "a b.csv").write_text("pos,y,z,r,speed\n0,0,0,1,0.5\n3,0,0,1,0.1\n0,3,0,1,2\n")
    scene = hl.read(
        tmp_path / "a b.csv",
        columns={"x": "pos", "radius": "r"},
        select=iter(["speed > 0", "x < 9"]),
        clip=[(0, 0, 1, 5.0)],
        color={"speed > 1": (1, 0, 0), "x > 2": "gold"},
        radius_scale=float(np.float32(0.5)),
    )
    camera = hl.Camera((2, 1, 20), at=(1, 1, 0), vfov=20, aperture=0.5, focus=19)
    options: Any = {
        "sun": [[1, 1, 1], [0, 1, 0]],
        "shadows": True,
        "occlusion": 4,
        "legend": "top-left",
        "label": "{file}: it's",
        "scale_bar": True,
        "background": (1, 1, 0.5),
        "samples": 3,
        "exposure": 0.25,
    }
    page = Page(scene.view(camera, renderer=cpu, size=SIZE, **options))
    body = page.body(mode="still")
    picture = page.still()
    assert picture == cpu.render(scene, camera, size=SIZE, **options).to_png()
    lines = page.json("/command", body)
    names: dict[str, Any] = {}
    exec(lines["python"].rpartition("frame.save")[0], names)
    assert names["frame"].to_png() == picture, lines["python"]
    shell = lines["shell"].replace("halfline render", 'exec "$0" render')
    done = subprocess.run(
        ["sh", "-c", shell, commands()[0]], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a b-view.png").read_bytes() == picture, shell


def test_scenes_of_arrays_have_lines_too(cloud: hl.Scene, cpu: hl.Renderer) -> None:
    page = Page(cloud.view(renderer=cpu, size=SIZE))
    picture = page.still(select="x > 0")
    lines = page.json("/command", page.body(select="x > 0"))
    assert lines["shell"] is None and page.json("/scene", {})["file"] == "scene"
    names: dict[str, Any] = {"scene": cloud}
    exec(lines["python"].rpartition("frame.save")[0], names)
    assert names["frame"].to_png() == picture
    assert "hl.render(" in Page(cloud.view()).json("/command", page.body())["python"]


@pytest.mark.parametrize(
    ("read", "shown", "select"),
    [(False, True, None), (True, False, "index 0"), (0.1, 0.2, None), (False, 0.1, "x > 5")],
)
def test_copied_lines_draw_the_cell(
    read: Any, shown: Any, select: str | None, cpu: hl.Renderer, tmp_path: Path
) -> None:
    (tmp_path / "a.gro").write_text(
        "t\n    2\n    1ALA     CA    1   0.100   0.000   0.000\n"
        "    2HOH     OW    2   1.900   0.000   0.000\n   2.0 2.0 2.0\n"
    )
    scene = hl.read(tmp_path / "a.gro", radius=3, cell=read)
    page = Page(scene.view(renderer=cpu, size=SIZE, cell=shown, label="{count}"))
    picture = page.still(select=select)
    lines = page.json("/command", page.body(select=select, mode="still"))
    names: dict[str, Any] = {}
    exec(lines["python"].rpartition("frame.save")[0], names)
    assert names["frame"].to_png() == picture, lines["python"]
    shell = lines["shell"].replace("halfline render", 'exec "$0" render')
    words = ["sh", "-c", shell, commands()[0]]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a-view.png").read_bytes() == picture, shell
    found = page.json("/select", {"expr": "x > 5 or not (x > 5)"})
    assert (found["count"], found["of"]) == (2, 2), "beads of the cell are no spheres of the scene"


def test_a_moving_picture_is_small_and_plain(page: Page) -> None:
    content, (picture,) = page.ask("/frame", page.body(mode="move"))
    assert picture.startswith(b"\xff\xd8\xff") and picture.endswith(b"\xff\xd9")
    assert content["info"]["look"] == "plain" and content["info"]["samples"] == 1
    assert page.view._still is None


def test_picks_equal_the_id_buffer(page: Page, molecule: hl.Scene, cpu: hl.Renderer) -> None:
    frame = cpu.render(
        molecule, page.view.to_camera(), size=SIZE, aovs=["distance", "position", "certainty"]
    )
    random = np.random.default_rng(3)
    last = None
    for x, y in random.integers(SIZE, size=(200, 2)).tolist():
        picked = page.json("/pick", page.body(x=x, y=y, **{"from": last}))
        found = int(frame["id"][y, x])
        if found < 0:
            assert picked is None
            continue
        assert picked["id"] == picked["row"] == found
        assert picked["center"] == molecule.centers[found].tolist()
        assert picked["radius"] == molecule.radii[found]
        # Only the spheres near the ray are asked, so these are other numbers within the promise.
        assert picked["position"] == pytest.approx(frame["position"][y, x], rel=1e-5)
        assert picked["distance"] == pytest.approx(frame["distance"][y, x], rel=1e-5)
        assert picked["certainty"] in ("certified", "settled")
        assert picked["columns"]["chain"] == molecule.columns["chain"][found]
        assert picked["columns"]["residue"] == molecule.columns["residue"][found]
        if last is not None:
            apart = molecule.centers[found] - molecule.centers[last]
            assert picked["from"]["distance"] == pytest.approx(np.linalg.norm(apart), rel=1e-15)
            assert picked["from"]["minimum_image"] is None
        last = found
    assert last is not None


def test_distances_in_a_cell_are_those_of_the_nearest_images(
    cpu: hl.Renderer, tmp_path: Path
) -> None:
    (tmp_path / "a.gro").write_text(
        "t\n    2\n    1ALA     CA    1   0.100   0.000   0.000\n"
        "    2HOH     OW    2   1.900   0.000   0.000\n   2.0 2.0 2.0\n"
    )
    scene = hl.read(tmp_path / "a.gro", radius=3, select="index 0 1")
    page = Page(
        scene.view(hl.Camera((10, 3, 90), at=(10, 3, 0)), renderer=cpu, size=(161, 121), cell=True)
    )
    camera = page.view.to_camera()
    ids = cpu.render(scene, camera, size=(161, 121), aovs="id", cell=True)["id"]
    assert (ids >= 2).any()
    for number in (1, int(ids.max())):
        y, x = np.argwhere(ids == number)[0]
        body = {**page.body(x=int(x), y=int(y), **{"from": 0}), "size": [161, 121]}
        picked = page.json("/pick", body)
        if number >= 2:
            assert picked is None, "a bead of the cell"
            continue
        assert picked["from"]["id"] == 0
        assert picked["from"]["distance"] == pytest.approx(18)
        assert picked["from"]["minimum_image"] == pytest.approx(2)


def test_a_selection_is_orange(
    page: Page, molecule: hl.Scene, cpu: hl.Renderer, tmp_path: Path
) -> None:
    found = page.json("/select", {"expr": "chain A"})
    assert found["count"] == 20 and found["of"] == 40 and found["notes"] == []
    assert "chain A" in found["legend"]
    assert "no particle has it" in page.json("/select", {"expr": "chain Q"})["notes"][0]
    picture = page.still(select="chain A")
    colors = {"not (chain A)": "silver", "(chain A)": "darkorange"}
    read = hl.read(tmp_path / "two.pdb", color_by="chain", color=colors)
    camera = page.view.to_camera()
    same = cpu.render(read, camera, size=SIZE, silhouette=True)
    assert same.to_png() == picture
    # The legend is also the reader's.
    painted = molecule.with_colors(colors)
    assert np.shares_memory(painted.centers, molecule.centers)
    assert np.array_equal(painted.colors, read.colors)  # type: ignore[arg-type]
    for by in ("chain", "element", "bfactor"):
        both = [
            hl.read(tmp_path / "two.pdb", color_by=by).with_colors(colors),
            hl.read(tmp_path / "two.pdb", color_by=by, color=colors),
        ]
        one, other = (cpu.render(s, camera, size=SIZE, legend=True).to_png() for s in both)
        assert one == other, by
    assert painted.columns["chain"].tolist() == molecule.columns["chain"].tolist()


def test_the_traits_go_both_ways(page: Page, molecule: hl.Scene) -> None:
    view = page.view
    sent: list[dict[str, Any]] = []
    view._send = lambda message, buffers=None: sent.append(message)
    moved = {"eye": [0, 0, 30], "at": [5, 5, 0], "up": [0, 1, 0], "vfov": 20}
    # The page moves: what it said is not said back.
    view.set_state({"camera": moved, "picked": [{"id": 3}], "selection": "chain B"})
    assert view.camera == moved and view.selection == "chain B" and view.picked == [{"id": 3}]
    assert [m for m in sent if m["method"] == "update"] == []
    assert repr(view.to_camera()) == repr(hl.Camera((0, 0, 30), at=(5, 5, 0), vfov=20))
    # Python moves.
    view.camera = {**moved, "vfov": 25}
    view.selection = " chain A "
    view.camera = hl.Camera((1, 2, 30), view=(0, 0, -2), height=9)
    assert view.camera["at"][:2] == [1, 2] and view.camera["height"] == 9
    states = [m["state"] for m in sent if m["method"] == "update"]
    assert [list(state) for state in states] == [["camera"], ["selection"], ["camera"]]
    assert states[1]["selection"] == "chain A"
    for wrong, words in [
        ({**moved, "vfov": 0}, "vfov"),
        ({**moved, "height": 3}, "either"),
        ({**moved, "eye": [1, 2]}, "eye"),
        (3, "give eye"),
    ]:
        with pytest.raises(TraitError, match=words):
            view.camera = wrong  # type: ignore[assignment]
    with pytest.raises(TraitError, match="not a selection"):
        view.selection = "chain ("
    view.selection = ""


@pytest.mark.parametrize(
    ("route", "change", "status", "words"),
    [
        ("/frame", {"camera": None}, 400, "not valid"),
        ("/frame", {"camera": {"eye": [0, 0, 0]}}, 400, "at"),
        (
            "/frame",
            {"camera": {"eye": [0, 0, 0], "at": [0, 0, 0], "up": [0, 1, 0], "vfov": 3}},
            400,
            "",
        ),
        ("/frame", {"size": [0, 3]}, 400, "size"),
        ("/frame", {"size": "big"}, 400, "not valid"),
        (
            "/frame",
            {"options": {"look": ["odd"]}, "mode": "still"},
            400,
            "look is odd; choose from plain",
        ),
        (
            "/frame",
            {"options": {"samples": ["0"]}, "mode": "still"},
            400,
            "samples is 0; give a whole number",
        ),
        ("/frame", {"select": "chain ("}, 400, "not a selection"),
        ("/frame", {"select": 3}, 400, "expected a string"),
        ("/pick", {"x": 160, "y": 0}, 400, "crop"),
        ("/pick", {"x": -1, "y": 0}, 400, "`-1`"),
        ("/pick", {"y": 0}, 400, "`x`"),
        ("/pick", {"x": 3, "y": 4, "from": "a"}, 400, "not valid"),
        ("/select", {"expr": 3}, 400, "expected a string"),
        ("/select", {"expr": "speed > 3"}, 400, "speed"),
        ("/command", {"camera": {}}, 400, "eye"),
        ("/nothing", {}, 404, "no such question"),
    ],
)
def test_mistakes_are_error_objects(
    page: Page, route: str, change: dict[str, Any], status: int, words: str
) -> None:
    content, buffers = page.ask(route, {**page.body(), **change})
    assert content["status"] == status and not buffers
    error = content["json"]["error"]
    assert (error["kind"], error["exit"]) in [("settings", 2), ("scene", 3)], error
    assert words in error["message"], error
    assert set(error) == {"kind", "message", "exit"}


def test_odd_messages_are_no_harm(page: Page) -> None:
    odd: list[Any] = [None, 3, {}, {"route": "/keep"}, {"id": None, "route": "/scene"}, []]
    for content in odd:
        page.view._handle_custom_msg(content, [])
    bodies: list[Any] = [None, 3, [], "x"]
    for body in bodies:
        assert page.ask("/frame", body)[0]["status"] == 400
        assert page.ask("/pick", body)[0]["status"] == 400
    assert page.ask("/frame", page.body(seq="x"))[0]["status"] == 400
    assert page.ask("/frame", page.body())[0]["status"] == 200


def test_the_newest_frame_wins(page: Page) -> None:
    # A still that takes long is given up, and so is a move that waits.
    slow = page.send("/frame", page.body(size=[4000, 4000], samples=64, mode="still", seq=10))
    time.sleep(0.3)
    waits = page.send("/frame", page.body(mode="move", seq=11))
    newest = page.send("/frame", page.body(mode="move", seq=12))
    # It may have had its turn before the newest arrived.
    assert page.wait(waits)[0]["status"] in (200, 204)
    assert page.wait(newest)[0]["status"] == 200
    assert page.wait(slow)[0] == {"id": slow, "status": 204, "json": None}
    # A page that begins again counts from the start.
    assert page.ask("/frame", page.body(mode="move", seq=1))[0]["status"] == 200


def threads() -> int:
    return sum(thread.name == "halfline answer" for thread in threading.enumerate())


def wait_for_threads() -> None:
    end = time.monotonic() + 60
    while threads():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_frames_come_one_by_one_and_threads_end_with_them(page: Page) -> None:
    # Those that wait are given up, and a later one with a smaller number has its turn.
    slow = page.send("/frame", page.body(size=[4000, 4000], mode="move", seq=9))
    numbers = [page.send("/frame", page.body(mode="move", seq=seq)) for seq in (2, 3, 5, 4)]
    picked = page.json("/pick", page.body(x=3, y=4))
    assert picked is None or picked["id"] >= 0
    statuses = [page.wait(number)[0]["status"] for number in [slow, *numbers]]
    assert statuses == [200, 204, 204, 200, 200]
    wait_for_threads()


def test_an_answer_that_is_lost_is_not_the_end(page: Page, caplog: Any) -> None:
    def fail(content: Any, buffers: Any = None) -> None:
        raise OSError("the notebook is gone")

    page.view.send = fail
    page.send("/frame", page.body(mode="move"))
    wait_for_threads()
    assert "an answer to the view was lost" in caplog.text
    page.view.send = page.hear
    assert page.ask("/frame", page.body(mode="move"))[0]["status"] == 200


def test_a_view_that_is_closed_gives_up(page: Page) -> None:
    slow = page.send("/frame", page.body(size=[4000, 4000], samples=64, mode="still", seq=1))
    waits = page.send("/frame", page.body(mode="still", seq=1))
    time.sleep(0.2)
    page.view.close()
    assert [page.wait(number)[0]["status"] for number in (slow, waits)] == [204, 204]
    assert page.ask("/frame", page.body())[0]["status"] == 204
    assert page.view.still.startswith(b"\x89PNG")


def test_wrong_options_are_refused(cloud: hl.Scene) -> None:
    for options, kind, words in [
        ({"aovs": "depth"}, ValueError, "remove aovs"),
        ({"crop": (0, 0, 1, 1)}, ValueError, "remove crop"),
        ({"legend": "a.svg"}, ValueError, "writes no files"),
        ({"sise": (3, 3)}, TypeError, "no option 'sise'"),
        ({"size": (0, 3)}, ValueError, "size"),
        ({"camera": 3}, TypeError, "give a Camera"),
    ]:
        with pytest.raises(kind, match=words):
            cloud.view(**options)  # type: ignore[arg-type]


def test_without_anywidget_the_error_has_the_mend() -> None:
    code = """
import sys
import halfline as hl
assert not {"anywidget", "traitlets", "ipywidgets"} & set(sys.modules)
sys.modules["anywidget"] = None
try:
    hl.Scene([[0, 0, 0]], 1.0).view()
except ImportError as error:
    print(error)
"""
    done = run(sys.executable, "-c", code)
    assert "pip install 'halfline[jupyter]'" in done.stdout


def test_the_saved_notebook_has_the_picture(tmp_path: Path) -> None:
    nbformat: Any = pytest.importorskip("nbformat", reason="nbclient is not installed")
    nbclient: Any = pytest.importorskip("nbclient", reason="nbclient is not installed")
    cells = [
        "import halfline as hl\n"
        "scene = hl.Scene([[0, 0, 0], [2, 0, 0]], 1.0, 'tomato')\n"
        "view = scene.view(renderer=hl.Renderer('cpu'), size=(80, 60))\nview",
        "frame = hl.Renderer('cpu').render(scene, view.to_camera(), size=(80, 60))\n"
        "frame.save('same.png')",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in cells])
    client = nbclient.NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": tmp_path}}
    )
    client.execute()
    nbformat.write(notebook, tmp_path / "saved.ipynb")
    saved = json.loads((tmp_path / "saved.ipynb").read_text())
    data = saved["cells"][0]["outputs"][-1]["data"]
    assert "application/vnd.jupyter.widget-view+json" in data
    text = "".join(data["text/plain"])
    assert text == "View(Scene(2 spheres), 80 x 60): run the cell to turn it."
    picture = base64.b64decode("".join(data["image/png"]))
    assert picture == (tmp_path / "same.png").read_bytes()
