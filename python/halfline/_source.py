"""Where a scene was read from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any


@dataclass(frozen=True, slots=True)
class Source:
    """A file, and how it was read."""

    path: str | PathLike[str]
    frame: int
    options: Mapping[str, Any]
    """The keywords of `read` that are not the default ones, without frame and size."""
