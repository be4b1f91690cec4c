"""The viewer ``halfline`` of ASE, which finds it by the entry point of this package."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from .atoms import from_ase


def __getattr__(name: str) -> Any:
    """``VIEWER``, the object of the entry point, which only ASE can make."""
    if name != "VIEWER":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    viewer: Any = import_module("ase.utils.plugins").ExternalViewer
    return viewer(
        desc="Spheres to turn, to pick and to select, every pixel certified", module=__name__
    )


def view_halfline(
    atoms: Any,
    data: None = None,
    repeat: int | tuple[int, int, int] | None = None,
    **options: Any,
) -> Any:
    """What ``ase.visualize.view(atoms, viewer="halfline")`` shows: in a notebook the widget of
    `Scene.view`, elsewhere the page of ``halfline view``, which ends after half an hour without a
    request.

    Args:
        atoms: An ``ase.Atoms``; outside of a notebook also a list of them, which is a film.
        data: Volumes are not drawn.
        repeat: Copies of the cell along its vectors.
        **options: Options of `Scene.view`; outside of a notebook also options of the command, such
            as ``port=8700``.

    Returns:
        The widget, or the process that serves the page.

    Raises:
        ValueError: for data, and in a notebook for a list.
    """
    if data is not None:
        raise ValueError("data is a volume, and halfline draws atoms; leave it out")
    if not _is_notebook():
        command = [sys.executable, "-m", "halfline", "view", *_flags({"idle": "30m"} | options)]
        # It writes a file of a temporary folder, and removes it when the command ends.
        viewer = import_module("ase.visualize.viewers").CLIViewer("halfline", "extxyz", command)
        return viewer.view(atoms, repeat=repeat)
    if isinstance(atoms, list | tuple):
        raise ValueError(
            f"atoms is a list of {len(atoms)}, and a view shows one; give one, such as atoms[-1]"
        )
    return from_ase(atoms if repeat is None else atoms.repeat(repeat)).view(**options)


def _is_notebook() -> bool:
    """Whether a kernel runs this code."""
    python = sys.modules.get("IPython")
    shell = None if python is None else python.get_ipython()
    return getattr(shell, "kernel", None) is not None


def _flags(options: Mapping[str, Any]) -> list[str]:
    """Options of the package as options of the command."""
    flags: list[str] = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if value is True:
            flags.append(flag)
        elif isinstance(value, Mapping):
            flags += [f"{flag}={key}={one}" for key, one in value.items()]
        elif isinstance(value, list | tuple):
            flags.append(f"{flag}={('x' if name == 'size' else ',').join(map(str, value))}")
        elif value not in (None, False):
            flags.append(f"{flag}={value}")
    return flags
