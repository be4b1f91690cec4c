"""Cameras of the page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ._arrays import number, shown, vector
from .camera import Camera


def pose(camera: Any) -> dict[str, Any]:
    """A camera of the page: eye, at, up, and vfov in degrees or height in scene units."""
    if not isinstance(camera, Mapping):
        raise ValueError(f"camera is {shown(camera)}; give eye, at, up, and vfov or height")
    found: dict[str, Any] = {
        name: vector(f"camera[{name!r}]", camera.get(name, ())) for name in ("eye", "at", "up")
    }
    lenses = [name for name in ("vfov", "height") if camera.get(name) is not None]
    if len(lenses) != 1:
        raise ValueError("a camera has either vfov or height; give one of them")
    found[lenses[0]] = number(f"camera[{lenses[0]!r}]", camera[lenses[0]])
    # Refuses what gives no picture.
    Camera(found["eye"], **{name: value for name, value in found.items() if name != "eye"})
    return found


def pose_of(camera: Camera, size: tuple[int, int], center: Any) -> dict[str, Any]:
    """A camera as the page has it. A point to look at that it does not give lies where the view
    passes the middle of the spheres.
    """
    record = camera.record(size if camera.size is None else None)
    eye, at = record["eye"], record.get("at")
    if at is None:
        length = math.hypot(*record["view"])
        view = [x / length for x in record["view"]]
        depth = sum((c - e) * v for c, e, v in zip(center, eye, view, strict=True))
        ahead = depth if 0 < depth < math.inf else 1.0
        at = [e + ahead * v for e, v in zip(eye, view, strict=True)]
    height, distance = record["viewport"][1], record["distance"]
    lens: dict[str, Any] = {"height": height}
    if distance is not None:
        exact = camera._native.vfov
        lens = {"vfov": exact or math.degrees(2 * math.atan(height / distance / 2))}
    return pose({"eye": eye, "at": at, "up": record["up"], **lens})
