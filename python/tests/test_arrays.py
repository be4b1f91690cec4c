"""Arrays go in without a copy where they can, and come out without one."""

import ctypes
import gc
import sys
import weakref
from typing import Any, ClassVar

import numpy as np
import pytest

import halfline as hl


def address(array: Any) -> int:
    found: int = array.__array_interface__["data"][0]
    return found


def test_colors_are_linear_numbers_levels_or_names() -> None:
    centers = np.arange(9.0).reshape(3, 3)
    linear = hl.Scene(centers, 1.0, ["#ff8000", "red", "#00ff40"]).colors
    assert linear is not None and linear[0, 1] == np.float32(0.2158605)  # IEC 61966-2-1 of 128/255
    levels = np.array([[255, 128, 0], [255, 0, 0], [0, 255, 64]], np.uint8)
    for given in (levels, np.c_[levels, [255, 255, 255]].astype(np.uint8)):
        found = hl.Scene(centers, 1.0, given)
        assert found.opacities is None and np.array_equal(found.colors, linear)
    numbers = hl.Scene(centers, 1.0, levels.tolist()).colors
    assert numbers is not None and numbers[0].tolist() == [255, 128, 0]  # Linear, as written.
    ghost = hl.Scene(centers, 1.0, np.c_[levels, [51, 255, 255]].astype(np.uint8))
    assert np.array_equal(ghost.colors, linear)
    assert ghost.opacities is not None and ghost.opacities.tolist() == [np.float32(0.2), 1, 1]
    assert np.array_equal(hl.Scene(centers, 1.0, levels[0]).colors, np.tile(linear[0], (3, 1)))
    scene = hl.Scene(centers, 1.0)
    assert np.array_equal(scene.with_colors(levels).colors, linear)
    for bad, message in [
        (np.ones((3, 4)), "bytes=True"),
        (["red", "blue"], "colors has 2 rows"),
        (["red", "blak", "blue"], "blak"),
        (levels[:2], "colors has 2 rows"),
        ([[1, 2], [3]], "colors is not an array"),
    ]:
        with pytest.raises(ValueError, match=message):
            hl.Scene(centers, 1.0, bad)
    alpha = np.zeros((3, 4), np.uint8)
    for call in (
        lambda: hl.Scene(centers, 1.0, alpha, opacities=0.5),
        lambda: hl.Scene(centers, 1.0, alpha),
        lambda: scene.with_colors(alpha),
    ):
        with pytest.raises(ValueError, match=r"alpha|opacit"):
            call()


def test_contiguous_arrays_are_not_copied() -> None:
    centers, radii = np.zeros((10, 3)), np.ones(10)
    colors = np.ones((10, 3), np.float32)
    scene = hl.Scene(centers, radii, colors)
    assert address(scene.centers) == address(centers)
    assert address(scene.radii) == address(radii)
    assert scene.colors is not None and address(scene.colors) == address(colors)
    # A part of a larger array that is contiguous itself.
    part = hl.Scene(np.zeros((20, 3))[5:15], np.ones(20)[5:15])
    assert len(part) == 10


@pytest.mark.parametrize(
    "centers",
    [
        np.arange(30, dtype=np.float32).reshape(10, 3),
        np.arange(30, dtype=np.int16).reshape(10, 3),
        np.arange(30, dtype=np.uint64).reshape(10, 3),
        np.arange(30, dtype=">f8").reshape(10, 3),
        np.asfortranarray(np.arange(30.0).reshape(10, 3)),
        np.arange(60.0).reshape(10, 6)[:, ::2] / 2,
        np.frombuffer(b"x" + np.arange(30.0).tobytes(), np.uint8)[1:]
        .view(np.float64)
        .reshape(10, 3),
        np.arange(30.0).reshape(10, 3).tolist(),
    ],
    ids=["float32", "int16", "uint64", "big-endian", "fortran", "strided", "misaligned", "list"],
)
def test_other_arrays_are_converted(centers: Any) -> None:
    scene = hl.Scene(centers, 1)
    assert np.array_equal(scene.centers, np.arange(30.0).reshape(10, 3))
    assert scene.centers.dtype == np.float64 and np.array_equal(scene.radii, np.ones(10))


def test_a_scene_keeps_its_arrays_and_lets_them_go() -> None:
    class Array(np.ndarray):  # type: ignore[type-arg]
        """An array that can be referenced weakly."""

    centers = np.arange(30.0).reshape(10, 3).view(Array)
    gone = weakref.ref(centers)
    scene = hl.Scene(centers, 1)
    shown = scene.centers
    count = sys.getrefcount(centers)
    del scene
    assert sys.getrefcount(centers) == count, "the view keeps the scene, and the scene the array"
    del centers
    gc.collect()
    assert shown[9, 2] == 29
    del shown
    gc.collect()
    # np.require may have made a view of a subclass, which owns nothing.
    assert gone() is None


def test_what_comes_out_cannot_be_written(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    frame = cpu.render(cloud, size=(8, 8), aovs=["depth", "normal"])
    for array in (cloud.centers, cloud.radii, frame["depth"], frame["normal"], frame["id"]):
        assert not array.flags.writeable and array.flags.c_contiguous
        with pytest.raises(ValueError):
            array.flags.writeable = True
        with pytest.raises(ValueError):
            array[0] = 1


class _Tensor(ctypes.Structure):
    """DLManagedTensorVersioned of DLPack 1.0 (dlpack.h), as far as its shape."""

    _fields_: ClassVar = [
        ("version", ctypes.c_uint32 * 2),
        ("manager", ctypes.c_void_p),
        ("deleter", ctypes.c_void_p),
        ("flags", ctypes.c_uint64),
        ("data", ctypes.c_void_p),
        ("device", ctypes.c_int32 * 2),
        ("ndim", ctypes.c_int32),
        ("dtype", ctypes.c_uint8 * 4),
        ("shape", ctypes.POINTER(ctypes.c_int64)),
    ]


def test_arrays_share_their_memory_by_dlpack(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    frame = cpu.render(cloud, size=(8, 6), aovs=["color", "depth", "normal", "mask"])
    hits = cpu.trace(cloud, [[0, 0, 9.0]] * 3, [[0, 0, -1.0]] * 3)
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    arrays = [frame[name] for name in frame]
    arrays += [hits.id, hits.t, hits.distance, hits.normal, hits.certainty, cloud.centers]
    for array in arrays:
        # As PyTorch asks for it; the address comes from the protocol, read without NumPy.
        capsule = array.__dlpack__(max_version=(1, 0))
        tensor = _Tensor.from_address(pointer(capsule, b"dltensor_versioned"))
        assert tensor.data == address(array)
        assert (tuple(tensor.shape[: tensor.ndim]), tensor.device[0]) == (array.shape, 1)
        assert (tensor.flags & 1 == 1) != array.flags.writeable
        assert address(np.from_dlpack(array)) == address(array)


def test_arrays_outlive_frame_and_renderer() -> None:
    renderer = hl.Renderer("cpu")
    scene = hl.Scene([[0, 0, 0]], 1.0)
    depths = [renderer.render(scene, size=(64, 64), aovs="depth")["depth"] for _ in range(4)]
    del renderer, scene
    gc.collect()
    assert len({address(depth) for depth in depths}) == 4
    assert all(np.array_equal(depth, depths[0]) for depth in depths)


def test_memory_of_frames_is_used_again(cpu: hl.Renderer, cloud: hl.Scene) -> None:
    seen = set()
    for _ in range(8):
        seen.add(address(cpu.render(cloud, size=(256, 256), aovs="depth")["depth"]))
    # The allocator may give an address again too, but not always.
    assert len(seen) <= 3


CENTERS = np.zeros((5, 3))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((np.zeros(5), 1), ["centers", "(5,)", "(n, 3)"]),
        ((np.zeros((5, 2)), 1), ["centers", "(5, 2)", "(n, 3)"]),
        ((np.zeros((5, 3), complex), 1), ["centers", "complex128"]),
        ((np.zeros((5, 3), bool), 1), ["centers", "bool"]),
        ((np.full((5, 3), "a"), 1), ["centers", "<U1"]),
        (([[1, 2, 3], [1, 2]], 1), ["centers", "(n, 3)"]),
        ((np.ma.masked_equal(CENTERS, 0), 1), ["centers", "masked"]),
        (
            (np.where(np.arange(15).reshape(5, 3) == 10, np.nan, 0), 1),
            ["centers[3]", "NaN", "finite"],
        ),
        ((CENTERS, np.ones(4)), ["radii has 4 rows", "centers has 5"]),
        ((CENTERS, np.ones((5, 1))), ["radii", "(5, 1)", "(n,)"]),
        (
            (CENTERS, [1, 1, -1, 1, 1]),
            ["radii[2] is -1: radii are positive and finite; remove the sphere"],
        ),
        ((CENTERS, [1, 1, 1, 0, 1]), ["radii[3] is 0"]),
        ((CENTERS, [1, np.inf, 1, 0, 1]), ["radii[1] is inf"]),
        ((CENTERS, "1"), ["radii", "<U1"]),
        ((CENTERS, None), ["radii", "object"]),
        ((CENTERS, 1, np.ones((4, 3))), ["colors has 4 rows"]),
        ((CENTERS, 1, np.ones((5, 4))), ["colors", "(5, 4)"]),
        ((CENTERS, 1, np.full((5, 3), -1)), ["colors[0]", "not negative"]),
        ((CENTERS, 1, "rde"), ["rde", "red"]),
        ((CENTERS, 1, [1, 2, np.nan]), ["colors", "finite"]),
    ],
)
def test_wrong_spheres_are_refused_with_argument_and_row(
    arguments: tuple[Any, ...], words: list[str]
) -> None:
    with pytest.raises(ValueError) as caught:
        hl.Scene(*arguments)
    assert all(word in str(caught.value) for word in words), caught.value


def test_no_spheres_are_a_scene(cpu: hl.Renderer) -> None:
    frame = cpu.render(hl.Scene(np.zeros((0, 3)), []), hl.Camera((0, 0, 0)), size=(4, 4))
    assert (frame["id"] == -1).all()
