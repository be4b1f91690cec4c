"""The conversions of docs/coming-from.md show points at the pixels where the other programs do.

The other programs' projections are written here from their documents, in float64.
"""

from typing import Any

import numpy as np
import pytest
from conftest import ROOT
from numpy.typing import NDArray
from test_pages import blocks

import halfline as hl

SIZE = (320, 200)

# Some pixels wide in all views below.
RADIUS = 0.06

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """The functions of the page."""
    names: dict[str, Any] = {}
    for _, text in blocks(ROOT / "docs" / "coming-from.md"):
        exec(text, names)
    return names


def points() -> Floats:
    """Points around the origin."""
    return np.random.default_rng(4).uniform(-0.5, 0.5, (40, 3))


def seen(camera: hl.Camera) -> tuple[Floats, Floats]:
    """Pixels (40, 2) and depths (40,) of the points, each rendered alone as a small sphere."""
    renderer = hl.Renderer("cpu")
    pixels, depths = [], []
    for point in points():
        frame = renderer.render(hl.Scene([point], RADIUS), camera, size=SIZE, aovs="depth")
        rows, columns = np.nonzero(frame["id"] == 0)
        assert rows.size > 4
        pixels.append((columns.mean() + 0.5, rows.mean() + 0.5))
        depths.append(frame["depth"][rows, columns].min() + RADIUS)
    return np.array(pixels), np.array(depths)


def compare(camera: hl.Camera, pixels: Floats, depths: Floats) -> None:
    found, lengths = seen(camera)
    # The mean of the pixels of a disc is its middle to half a pixel; the disc of a sphere of 0.06
    # from 5 away is off the projection of its centre by (0.06 / 5)^2 of the offset, 0.02 pixels.
    # The nearest pixel centre of a disc of 3 pixels is 0.7 from the middle: 0.03 radii deeper.
    assert np.abs(found - pixels).max() < 0.5, np.abs(found - pixels).max()
    assert np.abs(lengths - depths).max() < 0.01


def rotation(seed: int) -> Floats:
    """A rotation: the orthogonal factor of a random matrix, with determinant 1."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return np.asarray(q * np.sign(np.linalg.det(q)))


def opengl_pose() -> Floats:
    """A pose with the axes of OpenGL that sees the origin: x right, y up, z backward."""
    pose = np.eye(4)
    pose[:3, :3] = rotation(8)
    pose[:3, 3] = 6 * pose[:3, 2] + 0.2 * pose[:3, 0]
    return pose


def by_matrix(projection: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """Pixels and depths by a projection matrix of OpenGL: clip coordinates, then the viewport."""
    local = np.linalg.inv(pose) @ np.column_stack([points(), np.ones(40)]).T
    clip = projection @ local
    ndc = clip[:2] / clip[3]
    return np.stack([(ndc[0] + 1) / 2 * SIZE[0], (1 - ndc[1]) / 2 * SIZE[1]], axis=1), -local[2]


def test_intrinsics_of_pyrender(page: dict[str, Any]) -> None:
    fx, fy, cx, cy = 500.0, 480.0, 150.0, 110.0
    # get_projection_matrix of pyrender 0.1.45, without the rows of z.
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = 2 * fx / SIZE[0], 2 * fy / SIZE[1]
    projection[0, 2], projection[1, 2] = 1 - 2 * cx / SIZE[0], 2 * cy / SIZE[1] - 1
    projection[3, 2] = -1
    pose = opengl_pose()
    camera = page["pyrender_intrinsics"](fx, fy, cx, cy, SIZE, pose)
    compare(camera, *by_matrix(projection, pose))
    # With the axes of OpenCV the camera looks away.
    wrong = hl.Camera.from_intrinsics(fx, fy, cx, cy, *SIZE, pose)
    frame = hl.Renderer("cpu").render(hl.Scene(points(), RADIUS), wrong)
    assert frame["id"].max() == -1


def test_perspective_of_pyrender(page: dict[str, Any]) -> None:
    yfov, pose = 0.6, opengl_pose()
    projection = np.zeros((4, 4))
    projection[1, 1] = 1 / np.tan(yfov / 2)
    projection[0, 0] = projection[1, 1] * SIZE[1] / SIZE[0]
    projection[3, 2] = -1
    compare(page["pyrender_perspective"](yfov, pose), *by_matrix(projection, pose))


def test_depth_of_pyrender(page: dict[str, Any]) -> None:
    converted = page["pyrender_depth"](np.array([[2.5, np.inf]]))
    assert converted.dtype == np.float32 and converted.tolist() == [[2.5, 0]]


def test_perspective_of_fresnel(page: dict[str, Any]) -> None:
    position, look_at, up = np.array([3.0, 4, 4]), np.array([0.1, 0, 0.2]), np.array([0.0, 0, 1])
    focal_length, height = 0.5, 0.24
    # The basis of its documents: z from look_at to position, y the part of up across it.
    z = (position - look_at) / np.linalg.norm(position - look_at)
    y = up - (up @ z) * z
    y /= np.linalg.norm(y)
    x = np.cross(y, z)
    local = points() - position
    depth = -(local @ z)
    # The image plane is height high, at focal_length, centred on the line to look_at.
    across = [local @ axis * focal_length / depth / height * SIZE[1] for axis in (x, y)]
    pixels = np.stack([SIZE[0] / 2 + across[0], SIZE[1] / 2 - across[1]], axis=1)
    camera = page["fresnel_perspective"](position, look_at, up, SIZE, focal_length, height)
    compare(camera, pixels, depth)


@pytest.mark.parametrize("orthographic", [False, True])
def test_viewport_of_ovito(page: dict[str, Any], orthographic: bool) -> None:
    position, direction, fov = np.array([5.0, -4, 3]), np.array([-5.0, 4, -3]), 0.5
    if orthographic:
        fov = 1.8
    forward = direction / np.linalg.norm(direction)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    local = points() - position
    depth = local @ forward
    # The half height of the view at the point: fov itself, or by the vertical angle.
    half = np.full(40, fov) if orthographic else depth * np.tan(fov / 2)
    pixels = np.stack([local @ right, -(local @ above)], axis=1) / half[:, np.newaxis]
    pixels = np.array(SIZE) / 2 + pixels * SIZE[1] / 2
    camera = page["ovito_camera"](position, direction, fov, orthographic=orthographic)
    compare(camera, pixels, depth)
