"""Cameras that are fitted: directions by name, and a focus within the whole scene."""

from __future__ import annotations

import numpy as np
import pytest

import halfline as hl

# A sphere in the middle of four, which hide it from the sides but not from z.
CENTERS = [[0, 0, 0], [3, 0, 0], [-3, 0, 0], [0, 3, 0], [0, -3, 0]]


def scene() -> hl.Scene:
    return hl.Scene(CENTERS, 1.6)


def axes(camera: hl.Camera, size: tuple[int, int] = (60, 40)) -> tuple[np.ndarray, np.ndarray]:
    record = camera.record(size)
    return np.array(record["view"]), np.array(record["eye"])


@pytest.mark.parametrize(
    ("word", "view"),
    [
        ("front", (0, 0, -1)),
        ("back", (0, 0, 1)),
        ("left", (1, 0, 0)),
        ("right", (-1, 0, 0)),
        ("top", (0, -1, 0)),
        ("bottom", (0, 1, 0)),
    ],
)
def test_views_have_names(word: str, view: tuple[float, float, float]) -> None:
    found, eye = axes(hl.Camera.fit(scene(), view=word, size=(60, 40)))
    np.testing.assert_allclose(found / np.linalg.norm(found), view, atol=1e-15)
    # All spheres are in front of the eye.
    assert np.all((np.array(CENTERS) - eye) @ np.array(view) > 1.6)


def test_auto_shows_the_largest_face() -> None:
    flat = hl.Scene([[x, y, z] for x in range(2) for y in range(6) for z in range(4)], 0.4)
    found, _ = axes(hl.Camera.fit(flat, view="auto", size=(60, 40)))
    np.testing.assert_allclose(np.abs(found / np.linalg.norm(found)), (1, 0, 0), atol=1e-12)


@pytest.mark.parametrize("focus", [np.arange(5) == 0, [True, False, False, False, False]])
def test_a_focus_is_seen(focus: np.ndarray) -> None:
    camera = hl.Camera.fit(scene(), focus=focus, size=(60, 40))
    frame = hl.render(scene(), camera, size=(60, 40), aovs=["id"])
    ids = frame["id"]
    view, _ = axes(camera)
    # Three quarters of the height are its disc, of 30 pixels across.
    assert abs(view[2]) > 0.7 and 550 < np.count_nonzero(ids == 0) < 800
    assert not np.any(np.r_[ids[0], ids[-1], ids[:, 0], ids[:, -1]] == 0)
    front = hl.Camera.fit(scene(), focus=focus, view=(1, 0, 0), size=(60, 40))
    assert np.count_nonzero(hl.render(scene(), front, size=(60, 40), aovs=["id"])["id"] == 0) == 0
    for center in CENTERS:
        assert np.linalg.norm(np.array(center) - axes(front)[1]) > 1.6


def test_an_expression_is_a_focus() -> None:
    words = hl.Camera.fit(scene(), focus="x > 2", size=(60, 40))
    mask = hl.Camera.fit(scene(), focus=np.array(CENTERS)[:, 0] > 2, size=(60, 40))
    assert words.record((60, 40)) == mask.record((60, 40))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"focus": [True]}, r"shape \(1,\)"),
        ({"focus": [0, 1, 0, 0, 0]}, "bool"),
        ({"focus": [False] * 5}, "selects no sphere"),
        ({"view": "above"}, "front, back, left"),
    ],
)
def test_what_is_wrong_is_named(options: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        hl.Camera.fit(scene(), **options)  # type: ignore[arg-type]
