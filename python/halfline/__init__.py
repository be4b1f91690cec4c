"""halfline renders spheres, from atoms to planets: headless, on any GPU, on software Vulkan or on
the CPU.

It says how far from exact every answer can be.

>>> import halfline as hl
>>> scene = hl.Scene([[0, 0, 0], [1.5, 0, 0]], [1.0, 0.7], [[0.9, 0.4, 0.2], [0.2, 0.4, 0.9]])
>>> renderer = hl.Renderer("cpu")
>>> frame = renderer.render(scene, size=(64, 48), aovs=["color", "depth"])
>>> frame["depth"].shape, frame["depth"].dtype
((48, 64), dtype('float64'))
>>> frame.report["hits"] == (frame["id"] >= 0).sum()
np.True_

Scenes: `Scene`, `Columns`, `read`, `read_frames`, `from_ase`, `from_mdanalysis`. Cameras:
`Camera`, `read_cameras`. Rendering: `Renderer`, `Frame`, `Hits`. Scenes in parts, on many
machines: `sift`, `Sieve`, `Part`, `combine`. This machine and files: `adapters`, `info`.
Errors: `AccuracyError`, `AdapterError`, and ValueError, OSError, MemoryError, KeyboardInterrupt.
"""

import os as _os

from ._halfline import AccuracyError, AdapterError, __version__
from .atoms import from_ase, from_mdanalysis
from .camera import Camera, read_cameras
from .columns import Columns
from .frame import Frame
from .options import Aov, Options, PartOptions, ReadOptions, SaveOptions, VectorOptions
from .parts import Part, Sieve, combine, sift
from .renderer import Echoes, Hits, Occlusion, Renderer, measure, plan, render, trace
from .reports import adapters, info
from .scene import Scene, read, read_frames
from .vector import Vector

__all__ = [
    "AccuracyError",
    "AdapterError",
    "Aov",
    "Camera",
    "Columns",
    "Echoes",
    "Frame",
    "Hits",
    "Occlusion",
    "Options",
    "Part",
    "PartOptions",
    "ReadOptions",
    "Renderer",
    "SaveOptions",
    "Scene",
    "Sieve",
    "Vector",
    "VectorOptions",
    "__version__",
    "adapters",
    "combine",
    "from_ase",
    "from_mdanalysis",
    "info",
    "measure",
    "plan",
    "read",
    "read_cameras",
    "read_frames",
    "render",
    "sift",
    "trace",
]


def __dir__() -> list[str]:
    return __all__


# A layer of Mesa chooses the device of the desktop, and without one writes an error into every notebook.
if not _os.environ.keys() & {"XDG_RUNTIME_DIR", "DISPLAY", "MESA_VK_DEVICE_SELECT"}:
    _os.environ.setdefault("NODEVICE_SELECT", "1")
