"""Buffers as pictures to look at. Files of buffers hold their numbers; see `Frame.save`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Lengths between these percentiles span the shades, so that one far sphere does not flatten them.
_ENDS = (1, 99)

# The darkest shade of a hit; black is a miss.
_DARKEST = 40


def picture(name: str, values: NDArray[Any]) -> NDArray[np.uint8]:
    """A buffer in shades or colours, shape (H, W, 3)."""
    if name == "normal":
        return _bytes((np.clip(values, -1, 1) + 1) * 127.5)
    if name == "id":
        return _of_ids(values)
    if name == "certainty":
        colors = np.array([[0, 110, 60], [230, 160, 0], [190, 30, 30]], np.float64)
        return _bytes(colors[np.clip(values, 0, 2)])
    if name in ("alpha", "occlusion"):
        shades = np.clip(values, 0, 1) * 255
    elif name == "mask":
        shades = values * 255
    elif name == "shadow":
        shades = (1 - np.clip(values.mean(axis=2), 0, 1)) * 255
    else:
        shades = _of_lengths(values if values.ndim == 2 else np.linalg.norm(values, axis=2))
    return np.repeat(_bytes(shades)[..., np.newaxis], 3, axis=2)


def _bytes(levels: NDArray[Any]) -> NDArray[np.uint8]:
    return np.asarray(np.rint(levels), np.uint8)


def _of_lengths(values: NDArray[np.float64]) -> NDArray[np.float64]:
    hits = np.isfinite(values)
    if not hits.any():
        return np.zeros(values.shape)
    near, far = np.percentile(values[hits], _ENDS)
    share = (
        (far - np.where(hits, values, far)) / (far - near) if far > near else np.ones(values.shape)
    )
    return np.where(hits, _DARKEST + np.clip(share, 0, 1) * (255 - _DARKEST), 0)


def _of_ids(ids: NDArray[np.int32]) -> NDArray[np.uint8]:
    """A colour for each id: multiples of the golden ratio as hues, which keeps neighbours
    apart.
    """
    hue = (ids.astype(np.float64) * 0.6180339887498949) % 1
    value = 0.65 + 0.35 * ((ids.astype(np.float64) * 0.7548776662466927) % 1)
    channels = [np.abs(((hue + shift) % 1) * 6 - 3) - 1 for shift in (0, 2 / 3, 1 / 3)]
    colors = np.stack(
        [(0.35 + 0.65 * np.clip(channel, 0, 1)) * value for channel in channels], axis=-1
    )
    return _bytes(np.where(ids[..., np.newaxis] < 0, 0, colors * 255))
