"""What is on this machine, and what is in a file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike
from typing import Any

from . import _halfline
from ._arrays import whole, word


def adapters() -> list[dict[str, Any]]:
    """Every adapter (GPU or software Vulkan): name, driver, limits, and what its arithmetic was
    measured to be.

    As ``halfline adapters --json``; an empty list means that frames are rendered on the CPU path.
    """
    found: list[dict[str, Any]] = json.loads(_halfline.adapters())
    return found


def info(
    path: str | PathLike[str],
    *,
    format: str | None = None,
    columns: str | Mapping[str, str | int] | None = None,
    atom_style: str | None = None,
    skip_invalid: bool = False,
    model: int | None = None,
) -> dict[str, Any]:
    """What a file contains: format, frames, spheres, columns, elements, chains, cell, extent,
    warnings.

    As ``halfline info --json``; the keywords mean the same as in `read`.
    """
    if isinstance(columns, Mapping):
        columns = ",".join(f"{meaning}={column}" for meaning, column in columns.items())
    number = None if model is None else whole("model", model, -(2**63), 2**63 - 1)
    kind = None if format is None else word("format", format)
    style = None if atom_style is None else word("atom_style", atom_style)
    found: dict[str, Any] = json.loads(
        _halfline.info(path, kind, columns, style, bool(skip_invalid), number)
    )
    return found
