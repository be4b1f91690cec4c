"""Frames: the numbers of the command, bit for bit; cameras; reports; files."""

import json
import math
import os
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from conftest import SCENES, commands, run
from numpy.typing import NDArray

import halfline as hl

TONES: Final = ("soft", "linear")
BUFFERS = [
    "color",
    "distance",
    "depth",
    "normal",
    "position",
    "id",
    "mask",
    "certainty",
    "bound",
    "alpha",
    "occlusion",
]


@pytest.mark.parametrize("command", commands())
@pytest.mark.parametrize("name", ["weekend.toml", "inside.toml"])
def test_the_command_and_the_package_give_equal_bits(
    renderer: hl.Renderer, command: str, name: str, tmp_path: Path
) -> None:
    backend = "gpu" if renderer.is_gpu else "cpu"
    file = tmp_path / "all.npz"
    asked = "--aov=" + ",".join(BUFFERS) + f"={file}"
    said = run(
        command, "render", SCENES / name, asked, "--backend", backend, "--size", "120x90", "--json"
    )
    frame = renderer.render(hl.read(SCENES / name), size=(120, 90), aovs=BUFFERS)
    with np.load(file) as found:
        for buffer in BUFFERS:
            assert (
                frame[buffer].dtype == found[buffer].dtype
                and frame[buffer].shape == found[buffer].shape
            )
            assert frame[buffer].tobytes() == found[buffer].tobytes(), buffer
    expected = json.loads(said.stdout)
    # Times, and what a renderer that has rendered before does not send again.
    times = {"frame_ms", "host_ms", "kernel_ms", "stages_ms", "setup_ms", "bytes_up"}
    assert frame.report.keys() == expected.keys()
    assert {key: value for key, value in frame.report.items() if key not in times} == {
        key: value for key, value in expected.items() if key not in times
    }


def test_files_are_those_of_the_command(cpu: hl.Renderer, tmp_path: Path) -> None:
    frame = cpu.render(
        hl.read(SCENES / "weekend.toml"), size=(60, 40), aovs=["color", "depth", "normal"]
    )
    for name in ("c.png", "a.exr", "a.npz"):
        mine, theirs = tmp_path / name, tmp_path / f"their-{name}"
        frame.save(mine)
        both = name.startswith("a")
        aov = f"--aov=color,depth,normal,id={theirs}" if both else f"--aov=color={theirs}"
        # Without samples, lights and lines, which a picture of particles would have.
        run(
            commands()[0],
            "render",
            SCENES / "weekend.toml",
            aov,
            "--backend",
            "cpu",
            "--size",
            "60x40",
        )
        assert mine.read_bytes() == theirs.read_bytes(), name
    frame.save(tmp_path / "d.npy", aovs="depth")
    assert np.array_equal(np.load(tmp_path / "d.npy"), frame["depth"])
    with pytest.raises(ValueError, match="aovs"):
        cpu.render(hl.Scene([[0, 0, 0]], 1), size=(4, 4), aovs=["depth", "normal"]).save(
            tmp_path / "x.npy"
        )
    with pytest.raises(ValueError, match="extension"):
        frame.save(tmp_path / "x.bmp")
    with pytest.raises(FileNotFoundError) as caught:
        frame.save(tmp_path / "none" / "x.png")
    assert caught.value.filename == str(tmp_path / "none" / "x.png") and not list(
        tmp_path.glob("*.part")
    )


def test_particles_have_the_look_of_the_command(cpu: hl.Renderer, tmp_path: Path) -> None:
    atoms = tmp_path / "m.xyz"
    atoms.write_text("3\n\nO 0 0 0\nC 1.5 0 0\nN 0 1.5 0\n")
    scene, size = hl.read(atoms), (40, 30)
    usual = cpu.render(scene, size=size)
    soft = cpu.render(scene, size=size, look="soft")
    asked = cpu.render(scene, size=size, samples=4, accuracy="certified", aovs=["color", "depth"])
    plain = cpu.render(scene, size=size, look="plain")
    headlight = cpu.render(scene, size=size, shade="headlight")
    for frame in (soft, asked):
        assert np.array_equal(frame["color"], usual["color"])
    assert np.array_equal(plain["color"], headlight["color"])
    assert not np.array_equal(usual["color"], plain["color"])
    looks = [frame.report["look"] for frame in (usual, soft, asked, plain, headlight)]
    assert looks == ["soft", "soft", "soft", "plain", "plain"]
    many = list(cpu.render_many(scene, [hl.Camera((0, 0, 9))], size=size))
    assert many[0].report["look"] == "soft" and many[0].report["samples"] == 4
    mine, theirs = tmp_path / "mine.png", tmp_path / "theirs.png"
    usual.save(mine)
    run(commands()[0], "render", atoms, "-o", theirs, "--backend", "cpu", "--size", "40x30")
    assert mine.read_bytes() == theirs.read_bytes()
    depth = cpu.render(scene, size=size, aovs="depth")
    assert depth.report["look"] is None and depth.report["samples"] == 1
    arrays = cpu.render(hl.Scene(scene.centers, scene.radii), size=size)
    assert arrays.report["look"] == "plain"
    exposed = [cpu.render(scene, size=size, tone=tone, exposure=2) for tone in TONES]
    assert np.array_equal(exposed[0]["color"], usual["color"])
    assert not np.array_equal(exposed[0].image, exposed[1].image)
    assert [frame.report["tone"] for frame in exposed] == list(TONES)


def test_buffers_have_the_documented_shape_type_and_miss(cpu: hl.Renderer) -> None:
    scene = hl.Scene([[0, 0, 0]], 0.5, background=(0.25, 0.5, 0.75))
    frame = cpu.render(
        scene, hl.Camera((0, 0, 5)), size=(30, 20), aovs=[*BUFFERS, "shadow"], sun=(1, 1, 1)
    )
    expected: dict[str, tuple[tuple[int, ...], str, Any]] = {
        "color": ((20, 30, 3), "float32", [0.25, 0.5, 0.75]),
        "distance": ((20, 30), "float64", math.inf),
        "depth": ((20, 30), "float64", math.inf),
        "normal": ((20, 30, 3), "float32", 0),
        "position": ((20, 30, 3), "float64", math.nan),
        "id": ((20, 30), "int32", -1),
        "mask": ((20, 30), "uint8", 0),
        "certainty": ((20, 30), "uint8", 0),
        "bound": ((20, 30), "float64", 0),
        "alpha": ((20, 30), "float32", 0),
        "shadow": ((20, 30, 1), "float32", 0),
        "occlusion": ((20, 30), "float32", 1),
    }
    assert set(frame) == set(expected) and len(frame) == 12 and "depth" in frame
    for name, (shape, dtype, miss) in expected.items():
        assert (frame[name].shape, str(frame[name].dtype)) == (shape, dtype), name
        corner = frame[name][0, 0]
        assert np.array_equal(
            corner,
            np.broadcast_to(np.asarray(miss, dtype), corner.shape),
            equal_nan=dtype[0] == "f",
        )
    assert frame["id"][10, 15] == 0 and repr(frame).startswith("Frame(30 x 20: color")
    with pytest.raises(KeyError, match="aovs"):
        cpu.render(scene, size=(2, 2))["depth"]
    with pytest.raises(ValueError, match="choose from"):
        frame["dpeth"]


def test_cameras_see_what_they_should(cpu: hl.Renderer) -> None:
    scene = hl.Scene([[0, 0, -4], [2, 0, -4], [0, 1, -4]], 0.25)

    def ids(camera: hl.Camera) -> list[list[int]]:
        found: list[list[int]] = cpu.render(scene, camera, size=(5, 5))["id"].tolist()
        return found

    # A viewport of 5 x 5 at distance 4 has pixels 1 apart at the spheres.
    expected = [[-1] * 5, [-1, -1, 2, -1, -1], [-1, -1, 0, -1, 1], [-1] * 5, [-1] * 5]
    assert ids(hl.Camera((0, 0, 0), viewport=(5, 5), distance=4)) == expected
    assert (
        ids(hl.Camera((0, 0, 0), at=(0, 0, -1), vfov=2 * math.degrees(math.atan(2.5 / 4))))
        == expected
    )
    assert ids(hl.Camera((0, 0, 0), view=(0, 0, -3), height=5)) == expected
    # Focal length 4 in pixels; right, down, forward are x, -y, -z.
    pose = np.diag([1.0, -1, -1, 1])
    assert ids(hl.Camera.from_intrinsics(4, 4, 2.5, 2.5, 5, 5, pose)) == expected
    assert ids(hl.Camera.from_intrinsics(4, 4, 2, 2, 5, 5, pose[:3], pixel_center=0)) == expected
    # The principal point one pixel to the right moves everything to the right.
    moved = ids(hl.Camera.from_intrinsics(4, 4, 3.5, 2.5, 5, 5, pose))
    assert [row[1:] for row in moved] == [row[:-1] for row in expected]
    fitted = hl.Camera.fit(scene, view=(0, 0, -1), size=(5, 5))
    assert set(np.unique(cpu.render(scene, fitted, size=(200, 200))["id"])) == {-1, 0, 1, 2}
    parallel = cpu.render(
        scene, hl.Camera.fit(scene, orthographic=True), size=(64, 64), aovs=["depth", "distance"]
    )
    assert np.array_equal(parallel["depth"], parallel["distance"])


def test_translucent_spheres_are_those_of_the_command(cpu: hl.Renderer, tmp_path: Path) -> None:
    random = np.random.default_rng(8)
    atoms = [
        f"{'CO'[n % 2]} {x} {y} {z}" for n, (x, y, z) in enumerate(random.uniform(-6, 6, (200, 3)))
    ]
    file = tmp_path / "cloud.xyz"
    file.write_text("\n".join(["200", "cloud", *atoms, ""]))
    rules = (
        "--opacity",
        "element C=0.25",
        "--layers",
        "2",
        "--opacity-shadows",
        "--backend",
        "cpu",
    )
    picture = tmp_path / "command.npy"
    run(commands()[0], "render", file, "-o", picture, "--size", "80x60", *rules)
    scene = hl.read(file, size=(80, 60), opacity={"element C": 0.25})
    frame = cpu.render(scene, layers=2, opacity_shadows=True)
    assert frame["color"].tobytes() == np.load(picture).tobytes()
    assert (frame.report["layers"], frame.report["opacity_shadows"]) == (2, True)
    shares = scene.opacities
    assert shares is not None
    assert np.array_equal(shares, np.where(np.arange(200) % 2, 1, 0.25).astype("f4"))
    made = hl.Scene(scene.centers, scene.radii, scene.colors, opacities=shares)
    options: dict[str, Any] = {
        "size": (80, 60),
        "look": "soft",
        "layers": 2,
        "opacity_shadows": True,
    }
    assert cpu.render(made, scene.camera, **options)["color"].tobytes() == frame["color"].tobytes()
    opaque = hl.Scene(scene.centers, scene.radii, scene.colors)
    plain = cpu.render(opaque, scene.camera, size=(80, 60), look="soft")
    assert opaque.opacities is None and plain.report["layers"] is None
    assert np.array_equal(plain["id"], frame["id"]) and not np.array_equal(
        plain["color"], frame["color"]
    )
    part = hl.sift(
        made.centers, made.radii, made.colors, opacities=shares, camera=scene.camera, size=(80, 60)
    )
    assert np.array_equal(
        cpu.render(part)["color"], cpu.render(made, scene.camera, size=(80, 60))["color"]
    )
    for wrong, words in (
        ({"opacities": [0.5]}, "opacities has 1 rows"),
        ({"opacities": np.where(np.arange(200) == 7, 0, 0.5)}, r"opacities\[7\] is 0"),
        ({"opacities": 1.5}, r"opacities\[0\] is 1.5"),
    ):
        with pytest.raises(ValueError, match=words):
            hl.Scene(scene.centers, scene.radii, **wrong)
    with pytest.raises(ValueError, match="opacity is 0; give a number above 0"):
        hl.read(file, opacity=0)
    with pytest.raises(ValueError, match=r"`?layers"):
        cpu.render(scene, layers=65)


def test_materials_are_those_of_the_command(cpu: hl.Renderer, tmp_path: Path) -> None:
    file = tmp_path / "two.xyz"
    file.write_text("2\ntwo\nC -1.8 0 0\nO 1.8 0 0\n")
    picture = tmp_path / "command.npy"
    rules = ("--material", "element O=plastic", "--material", "element C=metal", "--shine", "9")
    run(
        commands()[0], "render", file, "-o", picture, "--size", "80x60", "--backend", "cpu", *rules
    )
    materials = {"element O": "plastic", "element C": "metal"}
    scene = hl.read(file, size=(80, 60), material=materials, shine=9)
    assert cpu.render(scene)["color"].tobytes() == np.load(picture).tobytes()
    with pytest.raises(ValueError, match="wood"):
        hl.read(file, material="wood")
    with pytest.raises(ValueError, match="shine belongs to plastic"):
        hl.read(file, shine=9)
    with pytest.raises(ValueError, match="shine is -1"):
        hl.read(file, material="plastic", shine=-1)


def test_marks_are_those_of_the_command(cpu: hl.Renderer, tmp_path: Path) -> None:
    file = tmp_path / "moons.csv"
    file.write_text("name,x,y,z,radius,mass\nIo,0,0,0,1,0.0149\nEuropa,5,2,0,1,0.008\n")
    picture = tmp_path / "command.png"
    rules = ("--mark", "name Io={name} of {mass}", "--backend", "cpu", "--size", "160x120")
    run(commands()[0], "render", file, "-o", picture, *rules)
    scene = hl.read(file, size=(160, 120), keep=True)
    frame = cpu.render(scene, mark={"name Io": "{name} of {mass}"})
    own = tmp_path / "own.png"
    frame.save(own)
    assert own.read_bytes() == picture.read_bytes()
    with pytest.raises(ValueError, match="no such column"):
        cpu.render(scene, mark={"all": "{colour}"})
    with pytest.raises(ValueError, match="mark is 'x'"):
        cpu.render(scene, mark="x")  # type: ignore[arg-type]


def test_poses_of_opengl_are_those_of_opencv_with_two_axes_turned() -> None:
    q, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    opencv = np.eye(4)
    opencv[:3, :3], opencv[:3, 3] = q * np.sign(np.linalg.det(q)), (1, 2, 3)
    opengl = opencv @ np.diag([1.0, -1, -1, 1])
    lens = (50, 60, 21, 15, 40, 30)
    camera = hl.Camera.from_intrinsics(*lens, opengl, convention="opengl")
    same = hl.Camera.from_intrinsics(*lens, opencv)
    named = hl.Camera.from_intrinsics(*lens, opencv, convention="opencv")
    assert camera.record() == same.record() == named.record()
    assert np.allclose(camera.record()["view"], -opengl[:3, 2])
    with pytest.raises(ValueError, match="convention is 'blender'; give 'opencv' or 'opengl'"):
        hl.Camera.from_intrinsics(*lens, opengl, convention="blender")  # type: ignore[arg-type]


def test_intrinsics_bring_their_size(cpu: hl.Renderer) -> None:
    camera = hl.Camera.from_intrinsics(50, 50, 20, 15, 40, 30)
    scene = hl.Scene([[0, 0, 5]], 1)
    assert cpu.render(scene, camera)["id"].shape == (30, 40) and camera.size == (40, 30)
    assert cpu.render(scene, camera)["id"][15, 20] == 0
    with pytest.raises(ValueError, match="intrinsics belong to"):
        cpu.render(scene, camera, size=(80, 60))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (np.diag([-1.0, 1, 1]), "pose: its rotation is mirrored"),
        (np.diag([1.0, 1, 1.01]), "lengths 1, 1, 1.01"),
        (np.diag([2.0, 2, 2]), "lengths 2, 2, 2"),
        (np.array([[1, 0.01, 0], [0, 1, 0], [0, 0, 1]]), "columns 0 and 1 .* 89.4"),
        (np.zeros((3, 3)), "is 0"),
    ],
)
def test_poses_that_are_no_rotations_are_refused(
    change: NDArray[np.float64], words: str, tmp_path: Path
) -> None:
    pose = np.eye(4)
    angle = 0.4
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    # Rounding to float32 or to four digits leaves a rotation.
    for rounded in (pose.astype("f4"), pose.round(4)):
        hl.Camera.from_intrinsics(50, 50, 20, 15, 40, 30, rounded)
    pose[:3, :3] = pose[:3, :3] @ change
    with pytest.raises(ValueError, match=words):
        hl.Camera.from_intrinsics(50, 50, 20, 15, 40, 30, pose)
    path = tmp_path / "poses.json"
    path.write_text(json.dumps([{"pose": np.eye(4).tolist()}, {"pose": pose.tolist()}]))
    if "2, 2, 2" in words:
        # The axes of lists need not be normalised.
        assert len(hl.read_cameras(path, vfov=30)) == 2
    else:
        with pytest.raises(ValueError, match=f"camera 1 pose.*{words.removeprefix('pose: ')}"):
            hl.read_cameras(path, vfov=30)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"eye": (0, 0)}, ["eye", "three numbers"]),
        ({"eye": (0, 0, math.nan)}, ["eye", "finite"]),
        ({"eye": (0, 0, 0), "at": (0, 0, 0)}, ["camera.at"]),
        ({"eye": (0, 0, 0), "view": (0, 0, 0)}, ["camera.view"]),
        ({"eye": (0, 0, 0), "view": (0, 1, 0)}, ["camera.up"]),
        ({"eye": (0, 0, 0), "at": (0, 0, 1), "view": (0, 0, 1)}, ["at and view"]),
        ({"eye": (0, 0, 0), "vfov": 180}, ["vfov", "180"]),
        ({"eye": (0, 0, 0), "vfov": 20, "height": 3}, ["vfov and height"]),
        ({"eye": (0, 0, 0), "height": -3}, ["height"]),
        ({"eye": (0, 0, 0), "viewport": (1, 2, 3)}, ["viewport", "two numbers"]),
        ({"eye": (0, 0, 0), "vfov": "wide"}, ["vfov", "number"]),
    ],
)
def test_wrong_cameras_are_refused(arguments: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as caught:
        hl.Camera(**arguments)
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"size": (0, 5)}, ValueError, ["size[0]", "0"]),
        ({"size": (5, 2**20 + 1)}, ValueError, ["1048577"]),
        ({"size": 5}, ValueError, ["size"]),
        ({"size": (2.5, 2)}, ValueError, ["size[0]", "whole"]),
        ({"aovs": "depht"}, ValueError, ["depht", "choose from"]),
        ({"aovs": [1]}, ValueError, ["aovs[0]"]),
        ({"accuracy": "good"}, ValueError, ["good", "certified"]),
        ({"accuracy": "certified", "method": "stable"}, ValueError, ["method"]),
        ({"tolerance": 0}, ValueError, ["tolerance"]),
        ({"samples": 0}, ValueError, ["samples"]),
        ({"seed": -1}, ValueError, ["seed"]),
        ({"crop": (0, 0, 50, 50)}, ValueError, []),
        ({"sun": (0, 0, 0)}, ValueError, ["sun", "not all 0"]),
        ({"reach": 3}, ValueError, ["reach", "occlusion"]),
        ({"occlusion": 2**30}, ValueError, ["occlusion"]),
        ({"bounces": 100}, ValueError, ["bounces"]),
        ({"look": "nice"}, ValueError, ["nice", "soft"]),
        ({"tone": "loud"}, ValueError, ["loud", "linear"]),
        ({"exposure": 40}, ValueError, ["exposure", "40", "32"]),
        ({"colour": 3}, TypeError, ["colour", "choose from"]),
        ({"progress": 3}, TypeError, ["progress"]),
        ({"background": "blak"}, ValueError, ["blak", "black"]),
    ],
)
def test_wrong_options_are_refused_in_words_of_python(
    cpu: hl.Renderer,
    cloud: hl.Scene,
    options: dict[str, Any],
    error: type[Exception],
    words: list[str],
) -> None:
    with pytest.raises(error) as caught:
        cpu.render(cloud, **{"size": (32, 32), **options})
    assert all(word in str(caught.value) for word in words) and "--" not in str(caught.value), (
        caught.value
    )


def test_a_memory_that_does_not_exist_is_refused(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    with pytest.raises(MemoryError):
        cpu.render(cloud, size=(2**20, 2**20), aovs=["position"])


def test_an_adapter_that_does_not_exist_is_refused_with_those_that_do() -> None:
    with pytest.raises(
        hl.AdapterError, match=None if os.environ.get("HALFLINE_NO_GPU") else "quantum"
    ):
        hl.Renderer("gpu", adapter="quantum")
    with pytest.raises(ValueError, match="backend"):
        hl.Renderer("abacus")  # type: ignore[arg-type]


def test_many_cameras_give_the_frames_of_one(renderer: hl.Renderer, cloud: hl.Scene) -> None:
    cameras = [
        hl.Camera((math.sin(a) * 6, 0, math.cos(a) * 6), at=(0, 0, 0))
        for a in np.linspace(0, 3, 7)
    ]
    frames = list(renderer.render_many(cloud, cameras, size=(48, 32), aovs=["depth", "color"]))
    assert len(frames) == 7
    for camera, frame in zip(cameras, frames, strict=True):
        alone = renderer.render(cloud, camera, size=(48, 32), aovs=["depth", "color"])
        assert frame["depth"].tobytes() == alone["depth"].tobytes()
        assert frame["color"].tobytes() == alone["color"].tobytes()
    # An iterator that is forgotten ends its work; the renderer is free between frames.
    some = renderer.render_many(cloud, cameras, size=(48, 32))
    next(some)
    assert renderer.render(cloud, size=(8, 8)).size == (8, 8)
    del some
    with pytest.raises(ValueError, match="size"):
        renderer.render_many(cloud, cameras, size=(0, 3))
    with pytest.raises(TypeError, match="Camera"):
        renderer.render_many(cloud, [3])  # type: ignore[list-item]


def test_traced_rays_are_those_of_the_command(
    renderer: hl.Renderer, cloud: hl.Scene, tmp_path: Path
) -> None:
    random = np.random.default_rng(2)
    # More than a block, so that the parts meet where they should.
    count = 600_000
    rays = np.column_stack(
        [random.normal(size=(count, 3)) * 3, random.normal(size=(count, 3)), np.full(count, 5.0)]
    )
    np.save(tmp_path / "rays.npy", rays)
    np.save(tmp_path / "spheres.npy", np.column_stack([cloud.centers, cloud.radii]))
    backend = "gpu" if renderer.is_gpu else "cpu"
    out = tmp_path / "hits.npz"
    run(
        commands()[0],
        "trace",
        tmp_path / "spheres.npy",
        "--rays",
        tmp_path / "rays.npy",
        "-o",
        out,
        "--backend",
        backend,
    )
    hits = renderer.trace(cloud, rays[:, :3], rays[:, 3:6], rays[:, 6])
    with np.load(out) as found:
        for name in ("id", "t", "distance", "normal", "certainty"):
            assert getattr(hits, name).tobytes() == found[name].tobytes(), name
    any_hit = renderer.trace(cloud, rays[:, :3], rays[:, 3:6], 5.0, any=True)
    assert np.array_equal(any_hit.hit, hits.hit)


def test_rays_keep_their_shape_and_are_checked(cpu: hl.Renderer) -> None:
    scene = hl.Scene([[0, 0, -3]], 1)
    directions = np.zeros((4, 5, 3))
    directions[..., 2] = -1
    hits = cpu.trace(scene, (0, 0, 0), directions)
    assert hits.t.shape == (4, 5) and hits.normal.shape == (4, 5, 3) and (hits.t == 2).all()
    assert not cpu.trace(scene, (0, 0, 0), directions, 1.5).hit.any()
    assert cpu.trace(scene, (0, 0, 0), np.zeros((0, 3))).id.shape == (0,)
    directions[2, 3] = 0
    with pytest.raises(ValueError, match=r"directions\[13\] is \[0, 0, 0\]"):
        cpu.trace(scene, (0, 0, 0), directions)
    with pytest.raises(ValueError, match="origins has the shape"):
        cpu.trace(scene, np.zeros((3, 3)), np.ones((4, 3)))
    with pytest.raises(ValueError, match=r"origins\[1\]"):
        cpu.trace(scene, [[0, 0, 0], [np.inf, 0, 0]], np.ones((2, 3)))
    with pytest.raises(ValueError, match="tmax"):
        cpu.trace(scene, (0, 0, 0), np.ones((4, 3)), np.ones(3))
    with pytest.raises(ValueError, match=r"tmax\[2\] is NaN"):
        cpu.trace(scene, (0, 0, 0), np.ones((3, 3)), [1, 2, np.nan])


def test_given_rays_hit_faces(cpu: hl.Renderer, tmp_path: Path) -> None:
    """Planes cut spheres for given rays and scanners, as for pictures, also planes of scene files."""
    scene = hl.Scene([[0, 0, 0], [0, 0, 0]], [4.0, 2.0])
    down = [[0, 0, -1], [3, 0, -9]]
    hits = cpu.trace(scene, (0, 0, 10), down, cut=(0, 0, 1, 1))
    assert hits.id.tolist() == [1, 0] and hits.t.tolist() == [9.0, 1.0]
    assert hits.normal.tolist() == [[0, 0, 1]] * 2
    same = cpu.trace(scene, (0, 0, 10), down, cut_slab=(0, 0, 1, -50, 1))
    assert same.id.tolist() == hits.id.tolist() and same.t.tolist() == hits.t.tolist()
    assert not cpu.trace(scene, (0, 0, 10), [[0, 0, -1]], 9.0, any=True, cut=(0, 0, 1, 1)).hit[0]
    sweep = cpu.scan(
        scene, "lidar:rings=1,step=90", hl.Camera((9, 0, 0), view=(-1, 0, 0)), cut=(1, 0, 0, 1)
    )
    assert sweep.distance[sweep.hit].tolist() == [8.0]
    file = tmp_path / "cut.toml"
    camera = "[camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n"
    ball = "[[sphere]]\ncenter = [0, 0, 0]\nradius = 4\n"
    file.write_text(f"{camera}{ball}[[cut]]\nnormal = [0, 0, 1]\ndistance = 1\n")
    assert cpu.trace(hl.read(file), (0, 0, 10), [[0, 0, -1]]).t.tolist() == [9.0]
    with pytest.raises(ValueError, match="no view"):
        cpu.trace(scene, (0, 0, 10), down, cut_at="all")
    with pytest.raises(TypeError, match="trace takes no 'look'"):
        cpu.trace(scene, (0, 0, 10), down, look="soft")  # type: ignore[call-overload]


@pytest.mark.filterwarnings("error")
def test_positions_of_rays_are_on_the_spheres(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    random = np.random.default_rng(7)
    origins, directions = random.normal(size=(2, 20, 30, 3))
    # Misses with zeros: infinity times 0.
    directions[0, :3] = np.eye(3)
    origins[0, :3] = (50, 60, 70)
    for starts in (origins, (0, 0, 9.0), [[0, 0, 9.0]]):
        hits = cpu.trace(cloud, starts, directions)
        assert hits.position.shape == (20, 30, 3) and hits.position.dtype == np.float64
        assert np.isnan(hits.position[~hits.hit]).all() and hits.hit.any() and not hits.hit.all()
        spheres = hits.id[hits.hit]
        away = np.linalg.norm(hits.position[hits.hit] - cloud.centers[spheres], axis=1)
        # Certified distances are within 1e-5, and no ray is 20 long.
        assert np.abs(away - cloud.radii[spheres]).max() < 2e-4
    one = hl.Scene([[0, 0, -3]], 1)
    assert cpu.trace(one, [[0, 0, 0.5]], (0, 0, -1)).position.tolist() == [0, 0, -2]
    assert np.isnan(cpu.trace(one, (0, 0, 0), (0, 0, 1)).position).all()


def test_a_plan_says_what_a_frame_requires(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    plan = cpu.plan(cloud, aovs=["depth"], accuracy="certified")
    assert plan["accuracy"] == "certified" and plan["spheres"] == 500


def test_methods_are_measured(cloud: hl.Scene) -> None:
    methods = ["stable", "exact"]
    record = hl.measure(cloud, size=(24, 24), methods=methods, backend="cpu", repeat=1)
    assert record["schema"] == "halfline-measure", record.keys()
    with pytest.raises(ValueError, match="nonsense"):
        hl.measure(cloud, methods="nonsense")


def test_pictures_and_datasets(cpu: hl.Renderer, cloud: hl.Scene, tmp_path: Path) -> None:
    frame = cpu.render(cloud, size=(40, 30), aovs=BUFFERS)
    assert frame.image.shape == (30, 40, 3) and frame.image.dtype == np.uint8
    for name in frame:
        assert frame.picture(name).shape == (30, 40, 3), name
    miss = frame["id"] < 0
    assert (frame.picture("depth")[miss] == 0).all() and (frame.picture("id")[miss] == 0).all()
    image = pytest.importorskip("PIL.Image")
    (tmp_path / "n.png").write_bytes(frame._repr_png_())
    frame.save(tmp_path / "f.png")
    for file in ("n.png", "f.png"):
        assert np.array_equal(np.asarray(image.open(tmp_path / file).convert("RGB")), frame.image)


def test_copies_are_read_by_other_programs(
    cpu: hl.Renderer, cloud: hl.Scene, tmp_path: Path
) -> None:
    image = pytest.importorskip("PIL.Image")
    frame = cpu.render(cloud, size=(40, 30), look="soft", label="in the picture")
    frame.save(tmp_path / "f.png")
    levels = np.asarray(image.open(tmp_path / "f.png").convert("RGB")).astype(int)
    for ending, most in (("tif", 0), ("jpg", 3), ("webp", 0)):
        frame.save(tmp_path / f"f.{ending}", dpi=300)
        copy = image.open(tmp_path / f"f.{ending}")
        # The mean, since JPEG is within a level or two but for single pixels at edges.
        assert abs(np.asarray(copy.convert("RGB")).astype(int) - levels).mean() <= most, ending
        exif = copy.getexif()
        assert "halfline:scene: " in exif[270] and exif[282] == 300, ending


def test_an_open_height_is_that_of_the_command(cpu: hl.Renderer, tmp_path: Path) -> None:
    rows = "".join(f"{n},{n * n % 7},{n % 3},0.5\n" for n in range(40))
    (tmp_path / "wide.csv").write_text("x,y,z,radius\n" + rows)
    scene = hl.read(tmp_path / "wide.csv")
    frame = cpu.render(scene, size=(90, None), look="plain")
    file, picture = tmp_path / "wide.csv", tmp_path / "wide.png"
    options = ["--size", "90xauto", "--look", "plain", "--backend", "cpu"]
    run(commands()[0], "render", file, *options, "-o", picture)
    frame.save(tmp_path / "own.png")
    assert (tmp_path / "own.png").read_bytes() == picture.read_bytes()
    assert frame["id"].shape[0] < 45
    ids = frame["id"]
    rows_shown, columns = np.nonzero(ids >= 0)
    frame.save(tmp_path / "trimmed.npy", aovs=["id"], trim=True)
    inside = ids[rows_shown.min() : rows_shown.max() + 1, columns.min() : columns.max() + 1]
    assert np.array_equal(np.load(tmp_path / "trimmed.npy"), inside)
    with pytest.raises(ValueError, match="size"):
        cpu.render(scene, size=(None, 90))


def test_a_frame_is_a_dataset(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    pytest.importorskip("xarray")
    dataset = cpu.render(cloud, size=(40, 30), aovs=["color", "depth"]).to_xarray()
    assert dataset["depth"].dims == ("y", "x") and dataset["color"].dims == ("y", "x", "rgb")
    assert (
        list(dataset["rgb"].values) == ["r", "g", "b"]
        and json.loads(dataset.attrs["report"])["spheres"] == 500
    )


def test_progress_is_reported_to_the_end(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    heard: list[tuple[str, int, int, str]] = []
    cpu.render(cloud, size=(64, 64), progress=lambda *words: heard.append(words))
    assert heard and heard[-1][1] == heard[-1][2] > 0
    list(
        cpu.render_many(
            cloud,
            [hl.Camera((0, 0, 9))] * 3,
            size=(9, 9),
            progress=lambda *words: heard.append(words),
        )
    )
    assert heard[-1] == ("render", 3, 3, "frames")


def test_an_exception_of_the_callback_ends_the_frame(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    def callback(*_: object) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        cpu.render(
            cloud, size=(2000, 2000), aovs=["position"], accuracy="exact", progress=callback
        )
    assert cpu.render(cloud, size=(4, 4)).size == (4, 4)


def test_depths_are_saved_as_the_command_writes_them(tmp_path: Path, cpu: hl.Renderer) -> None:
    scene = hl.Scene([[0, 0, -3]], 1.0)
    camera = hl.Camera((0, 0, 0), vfov=60)
    frame = cpu.render(scene, camera, size=(5, 3), aovs="depth")
    frame.save(tmp_path / "d.npy", aovs=["depth"], no_return="nan")
    saved = np.load(tmp_path / "d.npy")
    assert np.isnan(saved[frame["id"] < 0]).all() and saved[1, 2] == 2.0
    levels = []
    for unit in (0.001, 0.01):
        frame.save(tmp_path / "d.png", aovs=["depth"], unit=unit)
        levels.append((tmp_path / "d.png").read_bytes())
    assert levels[0] != levels[1]
    for wrong in ({"unit": 0}, {"unit": "far"}, {"no_return": "none"}, {"bits": 12}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            frame.save(tmp_path / "d.png", aovs=["depth"], **wrong)
    with pytest.raises(ValueError, match=r"dpi applies to \.png"):
        frame.save(tmp_path / "d.npy", aovs=["depth"], dpi=300)
    with pytest.raises(TypeError, match="no option 'quality'"):
        frame.save(tmp_path / "d.png", aovs=["depth"], quality=3)  # type: ignore[call-arg]
