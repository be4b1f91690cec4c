"""The renderer: a device, or the CPU path, kept for many frames."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from typing import Any, Literal, TypedDict, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _halfline
from ._arrays import array, native_scene, number, whole, word, words
from ._arrays import size as checked_size
from ._progress import Callback, reporter
from .camera import Camera, native_camera
from .frame import Frame
from .options import Options
from .parts import Part
from .scene import Scene


class Cuts(TypedDict, total=False):
    """Keywords of `Renderer.trace` and `Renderer.scan` for planes that cut spheres, as in
    `Renderer.render`.
    """

    cut: ArrayLike
    cut_slab: ArrayLike
    cut_at: str | Iterable[str]
    cut_only: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """The nearest hits of given rays, in the shape of the rays."""

    id: NDArray[np.int32]
    """Index of the sphere, int32; -1 on a miss."""
    t: NDArray[np.float64]
    """The hit is at origin + t direction, float64, in units of the direction; +inf on a miss."""
    distance: NDArray[np.float64]
    """t times the length of the direction, float64, scene units; +inf on a miss."""
    normal: NDArray[np.float32]
    """Unit normal against the ray, float32, shape (..., 3); 0, 0, 0 on a miss."""
    certainty: NDArray[np.uint8]
    """0 proved, 1 settled in exact arithmetic, 255 not certified; for misses too."""
    position: NDArray[np.float64]
    """origin + t direction, float64, shape (..., 3), scene units; NaN on a miss."""

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Whether a sphere is hit."""
        return self.id >= 0

    def __repr__(self) -> str:
        return _summary(self, self.hit)


@dataclass(frozen=True, slots=True, eq=False)
class Occlusion:
    """Whether given rays hit anything, in the shape of the rays."""

    hit: NDArray[np.bool_]
    """Whether some sphere is hit at 0 < t < tmax."""
    certainty: NDArray[np.uint8]
    """As in `Hits`."""

    def __repr__(self) -> str:
        return _summary(self, self.hit)


@dataclass(frozen=True, slots=True, eq=False)
class Echoes:
    """What a scanner measures of its beams, a row for each echo, beam by beam from the nearest."""

    beam: NDArray[np.uint32]
    """Ring and column of the beam, from 0, shape (n, 2); the highest ring is the first."""
    returns: NDArray[np.uint8]
    """The number of the echo among all echoes of its beam, from 1, and how many the beam has,
    shape (n, 2).
    """
    id: NDArray[np.int32]
    """Index of the sphere, int32."""
    distance: NDArray[np.float64]
    """The mean of the distances of the beam's hits on the sphere, with noise, scene units."""
    position: NDArray[np.float64]
    """The point at this distance on the beam's axis, shape (n, 3), scene units."""
    intensity: NDArray[np.float32]
    """The light that comes back, 0 to 1: cosines between ray and normal, times the luminance of
    the sphere's colour, over the rays of the beam.
    """
    certainty: NDArray[np.uint8]
    """The largest of the hits' as in `Hits`; 255 with noise."""

    def __repr__(self) -> str:
        return f"Echoes({len(self.id)} of spheres)"


def _summary(answers: Hits | Occlusion, hit: NDArray[np.bool_]) -> str:
    """Counts, and the arrays by name, type and shape."""
    found = int(np.count_nonzero(hit))
    arrays = ((field.name, getattr(answers, field.name)) for field in fields(answers))
    listed = ", ".join(f"{name} {values.dtype} {values.shape}" for name, values in arrays)
    rays = f"{hit.size} ray{'' if hit.size == 1 else 's'}"
    return f"{type(answers).__name__}({found} of {rays} hit\n  {listed})"


class Renderer:
    """A GPU, a software adapter, or the CPU path, kept for many frames.

    Any number of threads may use one renderer, one at a time; several renderers work at the same
    time. The interpreter's lock is free while they work. Ctrl-C ends a frame within a second, and
    the renderer stays usable.

    Args:
        backend: ``"gpu"``, ``"cpu"``, or ``"auto"``: a GPU if there is one, else the CPU path.
        adapter: The adapter, by index or part of its name; see `adapters`.

    Raises:
        AdapterError: if no adapter fits.

    >>> import halfline as hl
    >>> renderer = hl.Renderer("cpu")
    >>> scene = hl.Scene([[0, 0, -3]], 1.0)
    >>> frame = renderer.render(scene, hl.Camera((0, 0, 0), vfov=60), size=(5, 3), aovs="depth")
    >>> frame["id"]
    array([[-1, -1, -1, -1, -1],
           [-1, -1,  0, -1, -1],
           [-1, -1, -1, -1, -1]], dtype=int32)
    >>> float(frame["depth"][1, 2])
    2.0
    """

    __slots__ = ("_native",)

    def __init__(
        self, backend: Literal["auto", "gpu", "cpu"] = "auto", *, adapter: str | int | None = None
    ) -> None:
        name = None if adapter is None else str(adapter)
        if word("backend", backend) == "cpu" and name is not None:
            raise ValueError(
                "backend 'cpu' does not use an adapter; remove adapter or use backend='gpu'"
            )
        self._native = _halfline.Renderer(backend, name)

    @property
    def adapter(self) -> str:
        """The adapter's name; ``cpu`` for the CPU path."""
        return self._native.adapter

    @property
    def driver(self) -> str:
        """Driver and its version; threads for the CPU path."""
        return self._native.driver

    @property
    def is_gpu(self) -> bool:
        """Whether an adapter (a GPU, or software Vulkan) computes the frames."""
        return self._native.is_gpu

    @property
    def warnings(self) -> list[str]:
        """Why adapters that were found are not used although ``backend="auto"`` allows them."""
        return self._native.warnings

    def __repr__(self) -> str:
        return f"Renderer({self.adapter!r}, {self.driver!r})"

    def render(
        self,
        scene: Scene | Part,
        camera: Camera | None = None,
        *,
        progress: bool | Callback = False,
        **options: Unpack[Options],
    ) -> Frame:
        """Renders one frame.

        Args:
            scene: The scene, or a `Part`, which has its camera, size, window and samples.
            camera: The camera; by default the camera of the scene's file, else one that shows
                all spheres.
            progress: ``True`` for a bar in a terminal or a notebook (by tqdm, if it is
                installed), which is gone at the end, or a function that is called with ``step,
                done, total, unit`` some 20 times a second from the calling thread; an exception
                that it raises ends the frame.
            **options: See `Options`.

        Returns:
            The frame: its buffers as arrays, a report, files.

        Raises:
            ValueError: for a scene or options that cannot be rendered, with the mend.
            AccuracyError: where the accuracy cannot be reached on this adapter.
            MemoryError: where the frame does not fit.
            AdapterError: if the device was lost, with ``backend="gpu"``.
            KeyboardInterrupt: ctrl-C.
        """
        given = dict(options)
        with reporter(progress) as report:
            if isinstance(scene, Part):
                if camera is not None:
                    raise ValueError("a part has the camera that it was made for; remove camera")
                return Frame._of(self._native.render_part(scene._native, given, report))
            native = self._native.render(native_scene(scene), _camera(camera), given, report)
        return Frame._of(native)

    def render_many(
        self,
        scene: Scene,
        cameras: Iterable[Camera],
        *,
        progress: bool | Callback = False,
        **options: Unpack[Options],
    ) -> Iterator[Frame]:
        """Renders a frame for each camera.

        Other threads render the next frames while Python handles the current one: two on a device,
        and as many as there are threads on the CPU path, if all of them have at most four million
        pixels and spheres. What the cameras share is kept between frames. The work ends when the
        iterator is closed or forgotten.

        Args:
            scene: The scene.
            cameras: The cameras.
            progress: As for `render`, in one bar for all cameras, which counts frames.
            **options: See `Options`.

        Yields:
            Frames, in the order of the cameras, equal to the frames of `render`.

        >>> import halfline as hl
        >>> scene = hl.Scene([[0, 0, 0]], 1.0)
        >>> cameras = [hl.Camera((0, 0, z), vfov=60) for z in (2, 3)]
        >>> frames = hl.Renderer("cpu").render_many(scene, cameras, size=(3, 3), aovs="depth")
        >>> [float(frame["depth"][1, 1]) for frame in frames]
        [1.0, 2.0]
        """
        natives = [native_camera(camera) for camera in cameras]
        frames = self._native.render_many(native_scene(scene), natives, dict(options))
        return _frames(frames, progress)

    @overload
    def trace(
        self,
        scene: Scene,
        origins: ArrayLike,
        directions: ArrayLike,
        tmax: ArrayLike | None = None,
        *,
        any: Literal[False] = False,
        accuracy: Literal["auto", "fast", "certified", "exact"] = "auto",
        method: str | None = None,
        search: Literal["auto", "all", "tree"] = "auto",
        tolerance: float | None = None,
        progress: bool | Callback = False,
        **cuts: Unpack[Cuts],
    ) -> Hits: ...

    @overload
    def trace(
        self,
        scene: Scene,
        origins: ArrayLike,
        directions: ArrayLike,
        tmax: ArrayLike | None = None,
        *,
        any: Literal[True],
        accuracy: Literal["auto", "fast", "certified", "exact"] = "auto",
        method: str | None = None,
        search: Literal["auto", "all", "tree"] = "auto",
        tolerance: float | None = None,
        progress: bool | Callback = False,
        **cuts: Unpack[Cuts],
    ) -> Occlusion: ...

    def trace(
        self,
        scene: Scene,
        origins: ArrayLike,
        directions: ArrayLike,
        tmax: ArrayLike | None = None,
        *,
        any: bool = False,
        accuracy: Literal["auto", "fast", "certified", "exact"] = "auto",
        method: str | None = None,
        search: Literal["auto", "all", "tree"] = "auto",
        tolerance: float | None = None,
        progress: bool | Callback = False,
        **cuts: Unpack[Cuts],
    ) -> Hits | Occlusion:
        """Traces given rays origin + t direction with 0 < t < tmax.

        Beside the arrays of the rays and of the answers it takes a few megabytes, however many
        rays there are.

        Args:
            scene: The scene.
            origins: Origins, shape (..., 3) as the directions, or (3,) for one that all rays have;
                scene units.
            directions: Directions of any length but zero, shape (..., 3). Contiguous float64 is
                not copied.
            tmax: Limits in units of the direction, shape (...), or one number for all; by default
                none.
            any: Whether to find out only if a ray hits anything, which is faster.
            accuracy: The accuracy of the answers; ``"auto"`` certifies them.
            method: One intersection method, uncertified.
            search: How candidates are found; the answers do not depend on it.
            tolerance: The allowed relative error of t.
            progress: As for `render`.
            **cuts: Planes that cut spheres, as for `render`; ``cut_at`` says where the removed side
                is, as in ``"all:0,0,1"``.

        Returns:
            `Hits`, or with ``any`` an `Occlusion`.

        >>> import halfline as hl
        >>> scene = hl.Scene([[0, 0, -3]], 1.0)
        >>> hits = hl.Renderer("cpu").trace(scene, (0, 0, 0), [[0, 0, -1], [0, 0, 2]])
        >>> hits.id, hits.t
        (array([ 0, -1], dtype=int32), array([ 2., inf]))
        """
        rays = array("directions", directions, np.float64, "(..., 3)")
        shape = rays.shape[:-1]
        starts = array("origins", origins, np.float64, "(..., 3)")
        if starts.shape not in ((3,), (1, 3), rays.shape):
            raise ValueError(
                f"origins has the shape {starts.shape}; give {rays.shape} "
                "as directions, or one of shape (3,)"
            )
        limits = None
        if tmax is not None:
            given = np.asarray(tmax)
            if given.ndim and given.shape != shape:
                raise ValueError(f"tmax has the shape {given.shape}; give {shape}, or one number")
            limits = array("tmax", np.broadcast_to(given, shape).reshape(-1), np.float64, "(n,)")
        if unknown := cuts.keys() - Cuts.__annotations__.keys():
            names = ", ".join(Cuts.__annotations__)
            raise TypeError(
                f"trace takes no {min(unknown)!r}; of the options for spheres it takes {names}"
            )
        accurate = {"accuracy": accuracy, "method": method, "tolerance": tolerance, **cuts}
        with reporter(progress) as report:
            answers = _halfline.trace(
                self._native,
                native_scene(scene),
                starts.reshape(-1, 3),
                rays.reshape(-1, 3),
                limits,
                bool(any),
                accurate,
                word("search", search),
                report,
            )
        if any:
            hit, certainty = (answer.reshape(shape) for answer in answers)
            return Occlusion(hit.view(np.bool_), certainty)
        ids, t, distance, normal, certainty = answers
        ids, t = ids.reshape(shape), t.reshape(shape)
        # In place, because there may be many rays. The infinite t of a miss has no product.
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            position = rays * t[..., np.newaxis]
            position += starts if starts.shape == rays.shape else starts.reshape(3)
        position[ids < 0] = np.nan
        return Hits(
            ids,
            t,
            distance.reshape(shape),
            normal.reshape(*shape, 3),
            certainty.reshape(shape),
            position,
        )

    def scan(
        self,
        scene: Scene,
        pattern: str,
        camera: Camera | None = None,
        *,
        accuracy: Literal["auto", "fast", "certified", "exact"] = "auto",
        progress: bool | Callback = False,
        **cuts: Unpack[Cuts],
    ) -> Hits | Echoes:
        """The sweep of a spinning scanner, as ``halfline trace --pattern``.

        All rays of the sweep are in memory, 100 bytes each; the command traces longer ones in
        blocks.

        Args:
            scene: The scene.
            pattern: Degrees: ``"lidar:rings=N,vfov=LOW..HIGH,step=DEG"``, and optionally
                ``,azimuth=FROM..TO`` and ``,range=LENGTH``. Azimuths are clockwise from the view.
                ``,divergence=DEG[,returns=N]`` and ``,noise=SIGMA[,seed=N]`` measure echoes.
            camera: The pose of the scanner: its eye, view and up; by default the scene's camera.
            accuracy: As for `Renderer.trace`.
            progress: As for `Renderer.render`.
            **cuts: As for `Renderer.trace`.

        Returns:
            `Hits` of the shape (rings, azimuths); or the `Echoes` of a pattern with a divergence or
            with noise.

        Raises:
            ValueError: for a pattern with a mistake.

        >>> import halfline as hl
        >>> scene = hl.Scene([[0, 0, -3]], 1.0)
        >>> scanner = hl.Camera((0, 0, 0), view=(0, 0, -1), up=(0, 1, 0))
        >>> sweep = hl.Renderer("cpu").scan(scene, "lidar:rings=1,step=90", scanner)
        >>> sweep.id
        array([[-1, -1,  0, -1]], dtype=int32)
        """
        native = native_scene(scene)
        pose = native.camera(None) if camera is None else native_camera(camera)
        beams = _halfline.Pattern(word("pattern", pattern))
        rings, azimuths, _ = beams.shape
        eye: list[float] = json.loads(pose.record((1, 1)))["eye"]
        rays = beams.directions(pose)
        hits = self.trace(
            scene, eye, rays, beams.range, accuracy=accuracy, progress=progress, **cuts
        )
        if beams.has_echoes:
            x, y, z = eye
            arrays = (hits.id, hits.distance, hits.normal, hits.certainty)
            return Echoes(*beams.echoes(native, (x, y, z), rays, *arrays))
        shape = (rings, azimuths)
        return Hits(
            *(
                getattr(hits, field.name).reshape(shape + getattr(hits, field.name).shape[1:])
                for field in fields(Hits)
            )
        )

    def plan(
        self, scene: Scene, camera: Camera | None = None, **options: Unpack[Options]
    ) -> dict[str, Any]:
        """What a frame requires and why: accuracy, method, search, buffers, memory; as ``halfline
        plan --json``.
        """
        plan: dict[str, Any] = json.loads(
            self._native.plan(native_scene(scene), _camera(camera), dict(options))
        )
        return plan


def render(scene: Scene | Part, camera: Camera | None = None, **options: Unpack[Options]) -> Frame:
    """Renders one frame on a new `Renderer`; for several keep one, since opening a device takes
    time.
    """
    return Renderer().render(scene, camera, **options)


def trace(
    scene: Scene, origins: ArrayLike, directions: ArrayLike, tmax: ArrayLike | None = None
) -> Hits:
    """The nearest hits of given rays on a new `Renderer`; see `Renderer.trace`."""
    return Renderer().trace(scene, origins, directions, tmax)


def plan(scene: Scene, camera: Camera | None = None, **options: Unpack[Options]) -> dict[str, Any]:
    """What a frame requires and why, on a new `Renderer`."""
    return Renderer().plan(scene, camera, **options)


def measure(
    scene: Scene,
    camera: Camera | None = None,
    *,
    size: tuple[int, int] | None = None,
    methods: Iterable[str] | None = None,
    backend: Literal["auto", "gpu", "cpu"] = "auto",
    adapter: str | int | None = None,
    repeat: int | None = None,
    tolerance: float | None = None,
    patience: float = 30.0,
) -> dict[str, Any]:
    """Speed and error of every method in a scene, as ``halfline measure --json``.

    Args:
        scene: The scene.
        camera: A perspective camera; by default the scene's.
        size: Columns and rows; by default the scene's.
        methods: The methods, with ``certified`` and ``exact``; by default all.
        backend: Where to compute.
        adapter: The adapter, by index or part of its name.
        repeat: Frames of each method; by default as many as the times need.
        tolerance: The allowed relative error of distances of certified answers.
        patience: Methods that would take longer for a frame on the CPU path are skipped, seconds.
    """
    image = None if size is None else checked_size("size", size)
    record: dict[str, Any] = json.loads(
        _halfline.measure(
            native_scene(scene),
            _camera(camera),
            image,
            None if methods is None else words("methods", methods),
            word("backend", backend),
            None if adapter is None else str(adapter),
            None if repeat is None else whole("repeat", repeat, 1),
            None if tolerance is None else number("tolerance", tolerance),
            number("patience", patience),
        )
    )
    return record


def _frames(frames: _halfline.Frames, progress: bool | Callback) -> Iterator[Frame]:
    try:
        with reporter(progress) as report:
            for done, frame in enumerate(frames, 1):
                if report is not None:
                    report("render", done, frames.count, "frames")
                yield Frame._of(frame)
    finally:
        frames.close()


def _camera(camera: Camera | None) -> _halfline.Camera | None:
    return None if camera is None else native_camera(camera)
