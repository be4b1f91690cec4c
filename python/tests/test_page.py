"""Pages without a server: `Scene.page`. What they do in a browser is tested by page/tests/run."""

import base64
import gzip
import html
import re

import numpy as np
import pytest

import halfline as hl
from halfline.page import Page


def pixels(png: bytes) -> bytes:
    """The data of a PNG file without its texts, which say the camera in other words."""
    data, at = b"", 8
    while at < len(png):
        length, kind = int.from_bytes(png[at : at + 4], "big"), png[at + 4 : at + 8]
        data += png[at : at + 12 + length] if kind in (b"IHDR", b"IDAT") else b""
        at += 12 + length
    return data


CENTERS = np.random.default_rng(4).uniform(-1, 1, (40, 3)).round(3)


@pytest.fixture(scope="module")
def scene() -> hl.Scene:
    return hl.Scene(CENTERS, 0.2)


@pytest.fixture(scope="module")
def page(scene: hl.Scene) -> Page:
    try:
        return scene.page(look="plain", size=(64, 48), renderer=hl.Renderer("cpu"))
    except ValueError as error:
        if "without the program of pages" not in str(error):
            raise
        pytest.skip(str(error))


def test_a_page_has_its_picture_and_its_spheres(page: Page, scene: hl.Scene) -> None:
    picture = re.search(r'src="data:image/png;base64,([^"]+)"', page.html)
    assert picture is not None
    expected = hl.Renderer("cpu").render(scene, size=(64, 48), look="plain").to_png()
    assert pixels(base64.b64decode(picture[1])) == pixels(expected)
    packed = re.search(r'id="content">([^<]+)<', page.html)
    assert packed is not None
    content = gzip.decompress(base64.b64decode(packed[1]))
    # Differences of thousandths in 4 bytes each, and no list for the equal radii.
    assert content.endswith(content[-3 * 4 * 40 :]) and len(content) < 3 * 4 * 40 + 700


def test_a_page_is_shown_and_saved(page: Page, tmp_path: object) -> None:
    path = f"{tmp_path}/a.html"
    page.save(path)
    with open(path, encoding="utf-8") as file:
        assert file.read() == page.html
    frame = page._repr_html_()
    assert html.unescape(frame[frame.index("srcdoc=") + 8 : -len('"></iframe>')]) == page.html
    assert "allow-same-origin" not in frame
    assert repr(page).startswith("Page(Scene")


def test_mistakes_are_named(scene: hl.Scene, page: Page) -> None:
    with pytest.raises(ValueError, match="a page shows whole pictures"):
        scene.page(crop=(0, 0, 1, 1))
    with pytest.raises((ValueError, KeyError), match="charge"):
        scene.page(columns=["charge"])
    with pytest.raises(TypeError, match="give a Camera"):
        scene.page(3)  # type: ignore[arg-type]
