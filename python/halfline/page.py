"""Pages that show a scene without a server and without Python: `Page`, which `Scene.page` makes."""

from __future__ import annotations

import html
import warnings
from collections.abc import Iterable
from os import PathLike, fspath

from . import _halfline
from ._shown import Shown

# The bars above and below the picture, pixels.
_BARS = 72


class Page:
    """A page in one file, for readers without halfline: `Scene.page` makes it. It renders in the
    reader's browser, with WebGPU where there is one; ``?`` lists its hands and keys.

    In a notebook the page is shown in the cell, and saved with it.
    """

    html: str
    """The file."""

    def __init__(
        self, given: Shown, columns: Iterable[str], title: str | None, caption: str | None
    ) -> None:
        names = [columns] if isinstance(columns, str) else list(columns)
        self.html, notes = _halfline.page(given, names, title, caption)
        self._name, self._size = given.name, given.size
        for note in notes:
            warnings.warn(note, stacklevel=3)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the file.

        Args:
            path: Its name, such as ``figure.html``.
        """
        _halfline.save_page(fspath(path), self.html)

    def __repr__(self) -> str:
        return f"Page({self._name}, {len(self.html) / 1e6:.1f} MB)"

    def _repr_html_(self) -> str:
        """The page in a frame of its own, which cannot reach the notebook."""
        width, height = self._size
        size = f'width="{width}" height="{height + _BARS}"'
        rules = 'sandbox="allow-scripts allow-downloads" allow="clipboard-write"'
        text = html.escape(self.html)
        return (
            f'<iframe {size} {rules} style="border: 0; max-width: 100%" srcdoc="{text}"></iframe>'
        )
