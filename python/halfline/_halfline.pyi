"""The native module, without arithmetic. Its documented interface is the package."""

from collections.abc import Callable, Iterator
from collections.abc import Sequence as Seq
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__version__: str

Vector = tuple[float, float, float]
Size = tuple[int, int]
Lens = tuple[str, list[float]]
Report = Callable[[str, int, int, str], object]

class AccuracyError(ValueError): ...
class AdapterError(RuntimeError): ...

@final
class Camera:
    def __new__(
        cls,
        eye: Vector,
        at: Vector | None,
        view: Vector | None,
        up: Vector,
        lens: Lens,
        size: Size | None,
        aperture: float | None,
        focus: float | None,
    ) -> Camera: ...
    @property
    def size(self) -> Size | None: ...
    def state(self) -> str: ...
    @staticmethod
    def of_state(state: str) -> Camera: ...
    def record(self, size: Size) -> str: ...

@final
class Scene:
    def __new__(
        cls,
        centers: NDArray[np.float64],
        radii: NDArray[np.float64],
        colors: NDArray[np.float32] | None,
        opacities: NDArray[np.float32] | None,
        background: Vector,
    ) -> Scene: ...
    def with_facts(
        self,
        warnings: list[str],
        number: int,
        time: float | None,
        step: int | None,
        cell: tuple[Vector, tuple[Vector, Vector, Vector]] | None,
    ) -> Scene: ...
    def __len__(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def time(self) -> float | None: ...
    @property
    def step(self) -> int | None: ...
    @property
    def cell(self) -> tuple[Vector, tuple[Vector, Vector, Vector]] | None: ...
    @property
    def centers(self) -> NDArray[np.float64]: ...
    @property
    def radii(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.float32] | None: ...
    @property
    def opacities(self) -> NDArray[np.float32] | None: ...
    @property
    def size(self) -> Size: ...
    @property
    def background(self) -> Vector: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def column_names(self) -> list[str]: ...
    def select(self, expression: str) -> tuple[NDArray[np.uint8], list[str]]: ...
    def column(self, word: str) -> tuple[NDArray[Any], list[str] | None]: ...
    def camera(self, size: Size | None) -> Camera: ...
    def fingerprint(self) -> str: ...
    def with_colors(self, colors: NDArray[np.float32]) -> Scene: ...
    def painted(self, rules: list[tuple[str, Vector]]) -> tuple[Scene, list[str]]: ...

@final
class Sequence:
    def __new__(
        cls, path: str | PathLike[str], options: dict[str, Any], size: Size | None, holds: bool
    ) -> Sequence: ...
    def __iter__(self) -> Iterator[Scene]: ...
    def __next__(self) -> Scene: ...

@final
class Sieve:
    def __new__(
        cls,
        camera: Camera,
        size: Size,
        samples: int,
        seed: int,
        crop: list[int] | None,
        tolerance: float | None,
        outline_width: float | None,
        first_id: int,
    ) -> Sieve: ...
    def add(
        self,
        centers: NDArray[np.float64],
        radii: NDArray[np.float64],
        colors: NDArray[np.float32] | None,
        opacities: NDArray[np.float32] | None,
    ) -> None: ...
    def part(self) -> Part: ...

@final
class Part:
    @staticmethod
    def of_bytes(bytes: bytes, name: str) -> Part: ...
    @staticmethod
    def load(path: str | bytes) -> Part: ...
    def save(self, path: str | bytes) -> None: ...
    def bytes(self) -> bytes: ...
    def combine(self, others: list[Part]) -> Part: ...
    def __len__(self) -> int: ...
    @property
    def words(self) -> str: ...
    @property
    def count(self) -> int: ...
    @property
    def all_ids(self) -> list[tuple[int, int]]: ...
    @property
    def size(self) -> Size: ...
    @property
    def samples(self) -> int: ...
    @property
    def ids(self) -> NDArray[np.int64]: ...
    @property
    def centers(self) -> NDArray[np.float64]: ...
    @property
    def radii(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.float32] | None: ...

@final
class Renderer:
    def __new__(cls, backend: str, adapter: str | None) -> Renderer: ...
    @property
    def adapter(self) -> str: ...
    @property
    def driver(self) -> str: ...
    @property
    def is_gpu(self) -> bool: ...
    @property
    def warnings(self) -> list[str]: ...
    def render(
        self,
        scene: Scene,
        camera: Camera | None,
        picture: dict[str, Any],
        accurate: dict[str, Any],
        progress: Report | None,
    ) -> Frame: ...
    def render_part(
        self,
        part: Part,
        picture: dict[str, Any],
        accurate: dict[str, Any],
        progress: Report | None,
    ) -> Frame: ...
    def render_many(
        self,
        scene: Scene,
        cameras: list[Camera],
        picture: dict[str, Any],
        accurate: dict[str, Any],
    ) -> Frames: ...
    def plan(
        self,
        scene: Scene,
        camera: Camera | None,
        picture: dict[str, Any],
        accurate: dict[str, Any],
    ) -> str: ...

@final
class Frame:
    @property
    def size(self) -> Size: ...
    @property
    def names(self) -> list[str]: ...
    def array(self, name: str) -> NDArray[Any]: ...
    def image(self) -> NDArray[np.uint8]: ...
    def report(self) -> str: ...
    def encode(self, aovs: list[str] | None, bits: int, unit: float, no_return: str) -> bytes: ...
    def save(
        self,
        path: str | PathLike[str],
        aovs: list[str] | None,
        bits: int,
        unit: float,
        no_return: str,
    ) -> None: ...

@final
class Frames:
    @property
    def count(self) -> int: ...
    def __iter__(self) -> Iterator[Frame]: ...
    def __next__(self) -> Frame: ...
    def close(self) -> None: ...

@final
class Desk:
    def __new__(
        cls,
        scene: Scene,
        renderer: Renderer,
        camera: Camera,
        size: Size,
        picture: dict[str, Any],
        accurate: dict[str, Any],
        lines: dict[str, Any],
    ) -> Desk: ...
    def pose_of(self, camera: Camera) -> str: ...
    def ask(self, route: str, body: str) -> Question: ...
    def select(self, expression: str) -> None: ...
    def still(self) -> bytes: ...
    def close(self) -> None: ...

@final
class Question:
    def wait(self) -> tuple[int, str, bytes | None] | None: ...

def adapters() -> str: ...
def check_pose(columns: list[Vector]) -> None: ...
def color(text: str) -> Vector: ...
def command(arguments: Seq[str]) -> int: ...
def elements(symbols: list[str], radii: str) -> tuple[list[float], list[Vector]]: ...
def png(pixels: NDArray[np.uint8]) -> bytes: ...
def fit_camera(
    scene: Scene,
    view: Vector | None,
    named: str | None,
    up: Vector | None,
    lens: Lens,
    size: Size,
    margin: float,
    focus: list[bool] | None,
) -> Camera: ...
def infer(
    names: list[str],
    symbols: list[str],
    residues: list[str],
    residue_numbers: list[int],
    masses: list[float],
) -> tuple[list[str], list[bool], list[str]]: ...
def info(
    path: str | PathLike[str],
    format: str | None,
    columns: str | None,
    skip_invalid: bool,
    model: int | None,
) -> str: ...
def measure(
    scene: Scene,
    camera: Camera | None,
    size: Size | None,
    methods: list[str] | None,
    backend: str,
    adapter: str | None,
    repeat: int | None,
    tolerance: float | None,
    patience: float,
) -> str: ...
def page(
    scene: Scene,
    renderer: Renderer,
    camera: Camera,
    size: Size,
    picture: dict[str, Any],
    accurate: dict[str, Any],
    lines: dict[str, Any],
    columns: list[str],
) -> tuple[str, list[str]]: ...
def pose(camera: str) -> str: ...
def read_cameras(
    path: str | PathLike[str],
    intrinsics: tuple[float, float, float, float] | None,
    vfov: float | None,
    size: Size | None,
) -> list[Camera]: ...
def save_page(path: str | PathLike[str], html: str) -> None: ...
def trace(
    renderer: Renderer,
    scene: Scene,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    limits: NDArray[np.float64] | None,
    any: bool,
    accurate: dict[str, Any],
    progress: Report | None,
) -> tuple[NDArray[Any], ...]: ...
def widget_module() -> str: ...
def widget_style() -> str: ...
