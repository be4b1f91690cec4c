"""The viewer of ASE."""

import json
import sys
import time
import urllib.request
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

import numpy as np
import pytest


def atoms() -> Any:
    """A cell of two atoms."""
    ase = pytest.importorskip("ase")
    return ase.Atoms("NaCl", [[0, 0, 0], [2.8, 0, 0]], cell=[5.6, 5.6, 5.6], pbc=True)


def show(what: Any, **options: Any) -> Any:
    return import_module("ase.visualize").view(what, viewer="halfline", **options)


def test_the_viewer_is_registered() -> None:
    (found,) = (point for point in entry_points(group="ase.visualize") if point.name == "halfline")
    assert found.value == "halfline._ase:VIEWER"


def served(what: Any, capfd: pytest.CaptureFixture[str], **options: Any) -> Any:
    """The answer of the page's server about its scene."""
    child = show(what, port=0, no_open=True, **options)
    try:
        text = ""
        for _ in range(300):
            text += capfd.readouterr().out
            if "\n" in text:
                break
            time.sleep(0.1)
        address, token = text.split()[0].split("/#")
        head = {"Authorization": f"Bearer {token}"}
        question = urllib.request.Request(f"{address}/scene", b"{}", head)
        with urllib.request.urlopen(question, timeout=30) as answer:
            return json.load(answer)
    finally:
        assert child.wait(30) == 0, "it ends by itself"


@pytest.mark.skipif(
    sys.platform == "win32", reason="the process of a process is not awaited there"
)
def test_a_script_gets_the_page_of_halfline_view(capfd: pytest.CaptureFixture[str]) -> None:
    said = served(atoms(), capfd, repeat=(2, 1, 1), size=(120, 80), idle="2s")
    assert (said["count"], said["frames"], said["size"]) == (4, 1, [120, 80])
    film = served([atoms(), atoms()], capfd, idle="2s")
    assert (film["count"], film["frames"]) == (2, 2)


def test_a_notebook_gets_a_widget(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = atoms()
    monkeypatch.setattr("halfline._ase._is_notebook", lambda: True)
    view = show(pair, repeat=(1, 1, 2), size=(120, 80))
    assert type(view).__name__ == "View"
    with pytest.raises(ValueError, match="such as atoms\\[-1\\]"):
        show([pair, pair])
    with pytest.raises(ValueError, match="data is a volume"):
        show(pair, data=np.zeros((2, 2, 2)))
    assert "4 spheres" in repr(view)
