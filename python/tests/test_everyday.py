"""What people write every day: mappings, intrinsics as a matrix, short texts, bars, float32."""

import inspect
import io
import math
import re
import sys
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from conftest import ROOT, SCENES

import halfline as hl
from halfline import _progress


def test_a_frame_is_a_mapping(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    frame = cpu.render(cloud, size=(8, 6), aovs=["color", "depth"])
    assert isinstance(frame, Mapping) and len(frame) == 3
    assert list(frame) == list(frame.keys()) == [name for name, _ in frame.items()]
    for (name, values), others in zip(frame.items(), frame.values(), strict=True):
        assert np.shares_memory(values, frame[name]) and np.shares_memory(others, values)
    assert {**frame}.keys() == dict(frame).keys() == {"color", "depth", "id"}
    assert frame.get("normal") is None and frame.get("depht", 3) == 3 and 3 not in frame
    assert frame.get("depth") is not None
    with pytest.raises(KeyError, match="aovs"):
        frame["normal"]
    for kind in (KeyError, ValueError):
        with pytest.raises(kind, match="choose from color"):
            frame["depht"]
    # Arrays have no single truth, so frames are compared by identity.
    same, other = frame, cpu.render(cloud, size=(8, 6), aovs=["color", "depth"])
    assert frame == same and frame != other and hash(frame)
    np.savez(io.BytesIO(), **frame)


POSE = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 8], [0, 0, 0, 1.0]])


def test_intrinsics_are_a_matrix(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    matrix = np.array([[120.0, 0, 61.5], [0, 110, 40], [0, 0, 1]])
    one = hl.Camera.from_intrinsics(K=matrix, width=120, height=90, pose=POSE)
    other = hl.Camera.from_intrinsics(120, 110, 61.5, 40, 120, 90, POSE)
    assert one.record() == other.record() and repr(one) == repr(other)
    first, second = (cpu.render(cloud, camera, aovs="depth")["depth"] for camera in (one, other))
    assert np.array_equal(first, second)
    opencv: dict[str, Any] = {"width": 120, "height": 90, "pixel_center": 0}
    whole = hl.Camera.from_intrinsics(K=[[120, 0, 60], [0, 120, 45], [0, 0, 1]], **opencv)
    assert whole.record()["intrinsics"]["cx"] == 60.5


@pytest.mark.parametrize(
    ("options", "kind", "words"),
    [
        ({"K": np.eye(4)}, ValueError, r"K has the shape \(4, 4\)"),
        ({"K": "x"}, ValueError, "K has the shape"),
        ({"K": [[1, 2], [3]]}, ValueError, "K has the shape"),
        ({"K": [[9, 0.3, 4], [0, 9, 4], [0, 0, 1]]}, ValueError, "skew 0.3.*rectangles"),
        ({"K": [[9, 0, 4], [1, 9, 4], [0, 0, 1]]}, ValueError, "row 1, column 0"),
        ({"K": [[9, 0, 0], [0, 9, 0], [4, 4, 1]]}, ValueError, "last row of K"),
        ({"K": [[9, 0, 4], [0, 9, 4], [0, 0, 2]]}, ValueError, "divide K"),
        ({"K": [[np.nan, 0, 4], [0, 9, 4], [0, 0, 1]]}, ValueError, "fx is nan"),
        ({"K": np.eye(3), "fx": 3}, ValueError, "K and fx exclude each other"),
        ({"fx": 3, "cx": 2}, TypeError, "needs fy, cy, or K="),
    ],
)
def test_wrong_matrices_are_refused(
    options: dict[str, Any], kind: type[Exception], words: str
) -> None:
    with pytest.raises(kind, match=words):
        hl.Camera.from_intrinsics(**options, width=8, height=8)
    with pytest.raises(TypeError, match="width and height"):
        hl.Camera.from_intrinsics(K=np.eye(3))  # type: ignore[call-overload]


def test_texts_are_short(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    rays = np.random.default_rng(1).normal(size=(300, 40, 3))
    hits = cpu.trace(cloud, (0, 0, 9), rays)
    text = repr(hits)
    assert text.count("\n") == 1 and len(text) < 300
    assert text.startswith(f"Hits({np.count_nonzero(hits.hit)} of 12000 rays hit\n")
    assert "normal float32 (300, 40, 3)" in text and "certainty uint8 (300, 40)" in text
    blocked = repr(cpu.trace(cloud, (0, 0, 9), [[0, 0, -1]], any=True))
    assert blocked.startswith("Occlusion(") and "of 1 ray hit" in blocked
    fitted = hl.Camera.fit(cloud, vfov=40)
    assert "vfov=40)" in repr(fitted) and len(repr(fitted)) < 200
    assert "height=" in repr(hl.Camera.fit(cloud, orthographic=True))
    assert repr(cpu.render(cloud, size=(4, 3))) == "Frame(4 x 3: color, id)"


def test_lengths_are_float32_on_request(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    aovs: Any = ["color", "distance", "depth", "position", "bound"]
    exact = cpu.render(cloud, size=(64, 48), aovs=aovs)
    for dtype in ("float32", np.float32):
        frame = cpu.render(cloud, size=(64, 48), aovs=aovs, dtype=dtype)  # type: ignore[call-overload]
        for name in ("distance", "depth", "position"):
            # NumPy rounds to nearest, ties to even.
            assert frame[name].dtype == np.float32
            assert np.array_equal(frame[name], exact[name].astype(np.float32), equal_nan=True)
            assert np.shares_memory(frame[name], frame[name])
            with pytest.raises(ValueError, match="read-only"):
                frame[name][0] = 0
        assert np.isposinf(frame["depth"][frame["id"] < 0]).all()
        assert np.isnan(frame["position"][frame["id"] < 0]).all()
        for name in ("color", "bound", "id"):
            assert np.array_equal(frame[name], exact[name])
    views = cpu.render_many(
        cloud, [hl.Camera((0, 0, 9))], size=(8, 8), aovs="depth", dtype="float32"
    )
    assert next(iter(views))["depth"].dtype == np.float32


def test_lengths_beyond_float32_are_infinite(cpu: hl.Renderer, tmp_path: Path) -> None:
    far = hl.Scene([[0, 0, -1e40]], 1e39)
    camera = hl.Camera((0, 0, 0), vfov=10)
    frame = cpu.render(far, camera, size=(5, 5), aovs="depth", dtype="float32")
    assert frame["id"][2, 2] == 0 and np.isposinf(frame["depth"][2, 2])
    # The file has the number.
    frame.save(tmp_path / "d.npy", aovs="depth")
    found = np.load(tmp_path / "d.npy")
    assert found.dtype == np.float64 and math.isclose(found[2, 2], 9e39, rel_tol=1e-5)


def test_a_scene_shows_itself_in_a_notebook(cloud: hl.Scene) -> None:
    empty = hl.Scene(np.zeros((0, 3)), np.zeros(0))
    odd = hl.Scene([[0, 0, 0], [1e300, 0, 0]], [1e-300, 1.0])
    for scene in (cloud, empty, odd, hl.read(SCENES / "weekend.toml")):
        png = scene._repr_png_()
        assert png is None or png.startswith(b"\x89PNG")
    png = cloud._repr_png_()
    assert png is not None
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    assert max(width, height) == 320
    assert hl.read(SCENES / "weekend.toml")._repr_png_() is not None


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Bars:
    """A stand-in for tqdm that remembers its bars."""

    made: ClassVar[list["Bars"]]

    def __init__(self, **options: Any) -> None:
        self.options, self.closed, self.n = options, False, 0
        self.totals: list[int | None] = []
        self.unit, self.unit_scale = "it", False
        type(self).made.append(self)

    def set_description(self, text: str, refresh: bool = True) -> None:
        self.options["desc"] = text

    def reset(self, total: int | None = None) -> None:
        self.totals.append(total)

    def refresh(self) -> None:
        assert not self.closed

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def bars(monkeypatch: pytest.MonkeyPatch) -> type[Bars]:
    class Fresh(Bars):
        made: ClassVar[list[Bars]] = []

    module = types.ModuleType("tqdm.auto")
    module.tqdm = Fresh  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "tqdm", types.ModuleType("tqdm"))
    monkeypatch.setitem(sys.modules, "tqdm.auto", module)
    return Fresh


def test_one_bar_for_many_views_which_is_gone_at_the_end(
    cpu: hl.Renderer, cloud: hl.Scene, bars: type[Bars], monkeypatch: pytest.MonkeyPatch
) -> None:
    cameras = [hl.Camera((0, 0, z)) for z in range(9, 16)]
    monkeypatch.setattr(sys, "stderr", Terminal())
    seen = list(cpu.render_many(cloud, cameras, size=(8, 8), progress=True))
    (bar,) = bars.made
    assert len(seen) == 7 and bar.closed and bar.n == 7 and bar.options["total"] == 7
    assert bar.options["leave"] is False and (bar.unit, bar.unit_scale) == (" frames", False)
    # The steps of one frame have one bar too.
    with _progress.reporter(True) as report:
        assert report is not None
        report("read", 1, 2, "rows")
        report("render", 3, 9, "tiles")
    bar = bars.made[1]
    assert len(bars.made) == 2 and bar.totals == [2, 9] and bar.closed
    assert (bar.options["desc"], bar.n) == ("render", 3)


def test_there_is_no_bar_where_nobody_sees_it(
    cpu: hl.Renderer,
    cloud: hl.Scene,
    bars: type[Bars],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    camera = hl.Camera((0, 0, 9))
    list(cpu.render_many(cloud, [camera], size=(8, 8), progress=True))
    assert not bars.made and capsys.readouterr().err == ""
    # A notebook shows standard error, which is no terminal.
    shell = types.SimpleNamespace(kernel=object())
    ipython = types.ModuleType("IPython")
    ipython.get_ipython = lambda: shell  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    list(cpu.render_many(cloud, [camera] * 3, size=(8, 8), progress=True))
    assert len(bars.made) == 1 and bars.made[0].closed
    with pytest.raises(TypeError, match="progress is 1"):
        cpu.render(cloud, size=(8, 8), progress=1)  # type: ignore[arg-type]


def test_a_line_without_tqdm_is_wiped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with _progress.reporter(True) as report:
        assert report is not None
        report("render", 10, 100, "tiles")
        report("end", 1, 1, "x")
    lines = terminal.getvalue().split("\r")
    assert lines[1] == "render: 10 of 100 tiles" and lines[2].startswith("end: 1 of 1 x")
    # What is left on the line are blanks, and the cursor is at its beginning.
    assert len(lines[2]) == len(lines[1]) and lines[-2].strip() == "" and lines[-1] == ""


def test_errors_speak_of_keywords(cpu: hl.Renderer, cloud: hl.Scene, tmp_path: Path) -> None:
    file = tmp_path / "two.xyz"
    file.write_text("1\na\nC 0 0 0\n1\nb\nC 1 0 0\n")
    wrong: list[tuple[Any, str]] = [
        (lambda: hl.read(file, frame=3), "use other frame, or another model"),
        (lambda: hl.read(file, wrap=True), "wrap"),
        (lambda: hl.read(file, assembly=1), "remove assembly"),
        (lambda: cpu.render(cloud, size=(4, 4), reach=2), "reach"),
        (
            lambda: cpu.render(cloud, hl.Camera((0, 0, 9), height=2), method="unit"),
            "remove method",
        ),
    ]
    for call, words in wrong:
        with pytest.raises(ValueError) as caught:
            call()
        assert words in str(caught.value) and "--" not in str(caught.value), str(caught.value)


# The package reads no streams, and its cameras have no zoom.
UNREACHED = {"stream", "zoom"}


def test_every_setting_that_the_library_names_is_a_keyword() -> None:
    keywords: set[str] = set()
    for options in (hl.Options, hl.ReadOptions, hl.SaveOptions, hl.VectorOptions):
        keywords |= set(options.__annotations__)
    for call in (
        hl.read,
        hl.read_frames,
        hl.measure,
        hl.Camera.__init__,
        hl.Camera.fit,
        hl.Frame.save,
        hl.Renderer.__init__,
        hl.Renderer.trace,
        hl.Sieve.__init__,
    ):
        keywords |= set(inspect.signature(call).parameters)
    table = (ROOT / "command" / "src" / "option_table.rs").read_text(encoding="utf-8")
    rows = re.findall(r'row\(\s*"(\w+)",\s*(?:Keyword\(\w+, |Elsewhere\()"([^"]+)"', table)
    renamed = {name: word for name, word in rows if name != word}
    assert renamed["aov"] == "aovs" and renamed["tile"] == "crop"
    settings = (ROOT / "ground" / "src" / "quote" / "setting.rs").read_text(encoding="utf-8")
    named = set(re.findall(r'\b[A-Z_]+ "([a-z_]+)",', settings))
    assert len(named) > 40
    lost = named - keywords - renamed.keys() - UNREACHED
    assert not lost, lost
