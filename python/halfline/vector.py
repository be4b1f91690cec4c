"""Figures without pixels: `Vector`, which `Scene.vector` makes."""

from __future__ import annotations

import warnings
from os import PathLike, fspath

from . import _halfline
from .camera import Camera, native_camera
from .options import VectorOptions


class Vector:
    """The visible part of every sphere as a path, sharp at any size: `Scene.vector` makes it.

    In a notebook it is shown as SVG.
    """

    paths: int
    """The number of paths."""
    small: int
    """Spheres, and visible parts of spheres, that are left out because they are smaller than
    ``detail``."""

    def __init__(
        self, scene: _halfline.Scene, camera: Camera | None, options: VectorOptions
    ) -> None:
        native = None if camera is None else native_camera(camera)
        self._native = _halfline.Figure(scene, native, dict(options))
        self.paths, self.small, _ = self._native.counts
        for warning in self._native.warnings:
            warnings.warn(warning, stacklevel=3)

    @property
    def svg(self) -> str:
        """The figure as SVG, with arcs of ellipses as they are."""
        return self._native.svg()

    @property
    def pdf(self) -> bytes:
        """The figure as PDF, with cubic curves that are within 1e-4 pixels of the arcs."""
        return self._native.pdf()

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the figure.

        Args:
            path: The file, .svg or .pdf.

        Raises:
            OSError: if the file cannot be written.
            ValueError: for another extension.
        """
        self._native.save(fspath(path))

    def __repr__(self) -> str:
        return f"Vector({self.paths} paths)"

    def _repr_svg_(self) -> str:
        return self.svg
