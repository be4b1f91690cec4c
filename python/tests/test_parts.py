"""Parts of scenes: the frame of any parts has the bits of the frame of all spheres, whatever the
arrays come from and whichever engine combines them."""

import functools
import operator
import os
import pickle
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, commands, run

import halfline as hl

COUNT = 40_000
CAMERA = hl.Camera((3, 2, 4), at=(0, 0, 0), vfov=40)
VIEW: dict[str, Any] = {"camera": CAMERA, "size": (64, 48)}
FARM = ROOT / "farm"
AOVS = ("color", "distance", "normal", "certainty")


def spheres(count: int = COUNT) -> tuple[Any, Any, Any]:
    random = np.random.default_rng(5)
    centers = random.uniform(-1, 1, (count, 3))
    return centers, random.uniform(0.01, 0.02, count), random.uniform(size=(count, 3)).astype("f4")


def part(first: int, end: int, **more: Any) -> hl.Part:
    centers, radii, colors = spheres()
    rows = slice(first, end)
    return hl.sift(centers[rows], radii[rows], colors[rows], first_id=first, **{**VIEW, **more})


def same(renderer: hl.Renderer, whole: hl.Part, scene: hl.Scene, **options: Any) -> None:
    """Compares the frame of a part with the frame of a scene."""
    found = renderer.render(whole, aovs=AOVS, **options)
    wanted = renderer.render(scene, CAMERA, size=(64, 48), aovs=AOVS, **options)
    for name in (*AOVS, "id"):
        assert np.array_equal(found[name], wanted[name]), name
    assert found.report["spheres"] == wanted.report["spheres"]


@pytest.mark.parametrize("samples", [1, 16])
def test_any_parts_give_the_frame_of_all(renderer: hl.Renderer, samples: int) -> None:
    scene = hl.Scene(*spheres())
    cuts = [0, 999, 1000, 25_000, COUNT]
    parts = [part(a, b, samples=samples) for a, b in pairwise(cuts)]
    overlapping = part(500, 2_000, samples=samples)
    for all_of_them in (
        parts,
        [*parts[::-1], parts[1]],
        [overlapping, *parts[1:], parts[0], overlapping],
    ):
        whole = functools.reduce(operator.or_, all_of_them)
        assert whole.id_ranges == [(0, COUNT)]
        same(renderer, whole, scene, samples=samples)
    same(renderer, hl.combine(*parts), scene, samples=samples)


def test_parts_are_cut_as_the_whole(cpu: hl.Renderer) -> None:
    planes = {"cut": [(0.2, 0.1, 1, 0.3), (1, 0, 0, 0.4)], "cut_slab": (0, 1, 0.5, -0.5, 0.25)}
    whole = hl.combine(*(part(a, b, **planes) for a, b in pairwise([0, 999, 1000, COUNT])))
    found = cpu.render(whole, aovs=AOVS)
    wanted = cpu.render(hl.Scene(*spheres()), CAMERA, size=(64, 48), aovs=AOVS, **planes)
    for name in (*AOVS, "id"):
        assert np.array_equal(found[name], wanted[name]), name
    keys = ["cuts", "spheres", "spheres_cut", "spheres_removed"]
    assert [found.report[key] for key in keys] == [wanted.report[key] for key in keys]
    assert wanted.report["spheres_cut"] > 10
    with pytest.raises(ValueError, match="give every part the same planes"):
        cpu.render(whole, cut=(1, 0, 0, 0))
    with pytest.raises(ValueError, match="list of planes"):
        part(0, 10) | part(10, 20, **planes)


def test_files_have_the_bytes_of_those_of_all(cpu: hl.Renderer, tmp_path: Path) -> None:
    centers, radii, colors = spheres()
    cpu.render(hl.Scene(centers, radii, colors), CAMERA, size=(64, 48)).save(
        tmp_path / "whole.png"
    )
    parts = [part(0, 7_000), part(7_000, COUNT)]
    cpu.render(parts[1] | parts[0]).save(tmp_path / "parts.png")
    assert (tmp_path / "parts.png").read_bytes() == (tmp_path / "whole.png").read_bytes()
    for n, one in enumerate(parts):
        one.save(tmp_path / f"{n}.npz")
        again = pickle.loads(pickle.dumps(hl.Part.load(tmp_path / f"{n}.npz")))
        assert np.array_equal(again.ids, one.ids) and np.array_equal(again.centers, one.centers)
        with np.load(tmp_path / f"{n}.npz") as arrays:
            assert set(arrays) == {"about", "centers", "radii", "id", "colors"}
            assert np.array_equal(arrays["id"], one.ids) and len(arrays["radii"]) == len(one)
    for command in commands():
        names = [tmp_path / "1.npz", tmp_path / "0.npz"]
        run(command, "render", "--visible", *names, "--backend", "cpu", "-o", tmp_path / "c.png")
        assert (tmp_path / "c.png").read_bytes() == (tmp_path / "whole.png").read_bytes()


def test_a_command_and_python_make_the_same_part(tmp_path: Path) -> None:
    centers, radii, _ = spheres()
    np.save(tmp_path / "a.npy", np.column_stack([centers, radii]))
    made = hl.sift(centers, radii, first_id=2**31, **VIEW)
    made.save(tmp_path / "python.npz")
    seen = ["--eye", "3,2,4", "--at", "0,0,0", "--vfov", "40", "--size", "64x48"]
    for command in commands():
        run(
            command,
            "sift",
            tmp_path / "a.npy",
            "--first-id",
            2**31,
            *seen,
            "-o",
            tmp_path / "c.npz",
        )
        assert (tmp_path / "c.npz").read_bytes() == (tmp_path / "python.npz").read_bytes()


def test_cameras_are_pickled(cpu: hl.Renderer) -> None:
    scene = hl.Scene(*spheres(500))
    intrinsics = hl.Camera.from_intrinsics(80.25, 81.5, 20.125, 30.5, 64, 48)
    lens = hl.Camera((3, 2, 4), view=(-3, -2, -4), vfov=33, aperture=0.1, focus=5)
    for camera in (CAMERA, intrinsics, lens, hl.Camera((0.1, 0.2, 1e9 / 3), viewport=(0.1, 0.3))):
        again = pickle.loads(pickle.dumps(camera))
        assert repr(again) == repr(camera)
        wanted, found = (cpu.render(scene, c, size=(64, 48), aovs=AOVS) for c in (camera, again))
        assert all(np.array_equal(found[name], wanted[name]) for name in (*AOVS, "id"))


def test_wide_ids_and_gaps(cpu: hl.Renderer) -> None:
    centers, radii, _ = spheres(500)
    frame = cpu.render(hl.sift(centers, radii, first_id=2**40, **VIEW))
    assert frame["id"].dtype == np.int64 and frame["id"].max() >= 2**40
    assert frame.report["warnings"] == [
        f"no part has the {2**40} spheres with ids 0 to {2**40 - 1}"
    ]


def test_what_does_not_belong_together_is_refused(cpu: hl.Renderer) -> None:
    one = part(0, 100)
    cases: list[tuple[Callable[[], object], str]] = [
        (lambda: one | part(100, 200, size=(64, 49)), "the size is 64x48, and 64x49"),
        (lambda: one | part(100, 200, camera=hl.Camera((3, 2, 5), at=(0, 0, 0))), "the camera is"),
        (lambda: one | part(100, 200, samples=4), "the number of samples is 1, and 4"),
        (lambda: one | hl.sift(spheres()[0][100:200], 0.1, **VIEW), "have different spheres"),
        (lambda: one | hl.sift(spheres()[0][100:200], 0.1, first_id=100, **VIEW), "has colours"),
        (lambda: cpu.render(one, CAMERA), "remove camera"),
        (lambda: cpu.render(one, size=(9, 9)), "the parts are of a frame of"),
        (lambda: cpu.render(one, samples=4), "its number of samples is 1, and not 4"),
        (lambda: cpu.render(one, occlusion=True), "need all spheres in memory"),
        (lambda: hl.sift([[0, 0, 0]], -1.0, **VIEW), "radi"),
        (lambda: hl.sift([[0, 0, np.nan]], 1.0, **VIEW), "center"),
        (lambda: hl.sift([[0, 0, 0]], [1.0, 2.0], **VIEW), "radii has 2 rows, and centers has 1"),
        (
            lambda: hl.Sieve(
                hl.Camera.from_intrinsics(50, 50, 32, 24, 64, 48, np.eye(4)), (32, 24)
            ),
            "the camera's intrinsics belong to (64, 48)",
        ),
        (lambda: hl.sift([[0, 0]], 1.0, **VIEW), "shape"),
        (lambda: hl.sift(3.0, 1.0, **VIEW), "rows"),
        (
            lambda: pickle.loads(pickle.dumps(one)[:-200] + bytes(150) + pickle.dumps(one)[-50:]),
            "",
        ),
        (lambda: hl.Part.load(ROOT / "README.md"), "README.md"),
        (lambda: one.save("part.png"), "ends in .npz"),
    ]
    for n, (work, words) in enumerate(cases):
        with pytest.raises(ValueError) as raised:
            work()
        assert words in str(raised.value), (n, str(raised.value))
    sieve = hl.Sieve(**VIEW)
    sieve.part()
    with pytest.raises(ValueError, match="has given its part"):
        sieve.add([[0, 0, 0]], 1.0)
    with pytest.raises(MemoryError, match="ids below"):
        hl.sift([[0, 0, 0]], 1.0, first_id=2**55, **VIEW)


class Watched:
    """Rows of an array that cannot be had as a whole."""

    def __init__(self, values: Any) -> None:
        self.values, self.shape, self.most = values, values.shape, 0

    def __getitem__(self, rows: slice) -> Any:
        self.most = max(self.most, rows.stop - rows.start)
        return self.values[rows]

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise AssertionError("the whole was copied")


def test_arrays_are_read_in_blocks() -> None:
    centers, radii, colors = spheres(700_000)
    watched = [Watched(values) for values in (centers, radii, colors)]
    found = hl.sift(*watched, **VIEW)
    assert all(values.most == 1 << 18 for values in watched)
    assert np.array_equal(found.ids, hl.sift(centers, radii, colors, **VIEW).ids)


def by_numpy(values: Any, folder: Path) -> Any:
    path = folder / f"{len(list(folder.iterdir()))}.npy"
    np.save(path, values)
    return np.load(path, mmap_mode="r")


def by_h5py(values: Any, folder: Path) -> Any:
    h5py = pytest.importorskip("h5py")
    path = folder / f"{len(list(folder.iterdir()))}.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("a", data=values, chunks=True, compression="gzip")
    return h5py.File(path)["a"]


def by_zarr(values: Any, folder: Path) -> Any:
    zarr = pytest.importorskip("zarr")
    made = zarr.create_array(folder / f"{len(list(folder.iterdir()))}.zarr", data=values)
    return zarr.open_array(made.store_path, mode="r")


def by_dask(values: Any, folder: Path) -> Any:
    dask = pytest.importorskip("dask.array")
    return dask.from_array(values, chunks=7_001)


def by_arrow(values: Any, folder: Path) -> Any:
    arrow = pytest.importorskip("pyarrow")
    chunks = lambda column: arrow.chunked_array([column[:77], column[77:]])  # noqa: E731
    return chunks(values) if values.ndim == 1 else tuple(map(chunks, values.T))


@pytest.mark.parametrize("made", [by_numpy, by_h5py, by_zarr, by_dask, by_arrow])
def test_arrays_of_other_libraries(made: Callable[[Any, Path], Any], tmp_path: Path) -> None:
    centers, radii, _ = spheres()
    found = hl.sift(made(centers, tmp_path), made(radii, tmp_path), **VIEW)
    wanted = hl.sift(centers, radii, **VIEW)
    assert pickle.dumps(found) == pickle.dumps(wanted)
    singles = hl.sift(made(centers.astype("f4"), tmp_path), 0.01, "teal", **VIEW)
    assert singles.count == COUNT and singles.colors is not None


def test_dask_with_a_killed_worker(cpu: hl.Renderer, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    cuts = np.linspace(0, COUNT, 9).astype(int)
    mark = tmp_path / "killed"

    def made(first: int, end: int) -> hl.Part:
        # One of the processes ends in the middle of the work, once.
        if first > COUNT // 2 and not mark.exists():
            mark.write_text(str(os.getpid()))
            os.kill(os.getpid(), signal.SIGKILL)
        return part(first, end)

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        parts = [client.submit(made, int(a), int(b), pure=False) for a, b in pairwise(cuts)]
        while len(parts) > 1:
            parts = [
                client.submit(hl.combine, *parts[n : n + 2], pure=False)
                for n in range(0, len(parts), 2)
            ]
        whole = parts[0].result(timeout=120)
    assert mark.exists(), "a worker was killed"
    same(cpu, whole, hl.Scene(*spheres()))


def engine(*line: object, folder: Path) -> str:
    """Runs a program, which must end well; what it printed."""
    # Debian's Open MPI asks for these where root runs it, and knows nothing of containers.
    allow = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(
        list(map(str, line)),
        env={**os.environ, **allow},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


MPI = """
import sys
sys.path.insert(0, {folder!r})
from mpi4py import MPI
import halfline as hl
from test_parts import COUNT, part
world = MPI.COMM_WORLD
rank, ranks = world.Get_rank(), world.Get_size()
own = part(COUNT * rank // ranks, COUNT * (rank + 1) // ranks)
whole = world.reduce(own, op=hl.combine, root=0)
if rank == 0:
    whole.save("whole.npz")
"""


def test_mpi(cpu: hl.Renderer, tmp_path: Path) -> None:
    pytest.importorskip("mpi4py")
    mpirun = shutil.which("mpirun")
    if mpirun is None:
        pytest.skip("mpirun is not here (Debian: apt-get install openmpi-bin)")
    ranks = [mpirun, "--oversubscribe", "-n", "4", sys.executable]
    engine(*ranks, "-c", MPI.format(folder=str(Path(__file__).parent)), folder=tmp_path)
    same(cpu, hl.Part.load(tmp_path / "whole.npz"), hl.Scene(*spheres()))
    said = engine(*ranks, FARM / "parts_mpi.py", "-o", "mpi.png", folder=tmp_path)
    assert "(ids 0 to 999999)" in said and (tmp_path / "mpi.png").stat().st_size > 10_000


def test_the_example_with_dask(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    centers, radii, _ = spheres()
    rows = np.column_stack([centers, radii])
    for n, some in enumerate(np.array_split(rows, 3)):
        np.save(tmp_path / f"{n}.npy", some)
    names = ["0.npy", "1.npy", "2.npy"]
    said = engine(
        sys.executable, FARM / "parts_dask.py", *names, "-o", "dask.png", folder=tmp_path
    )
    assert f"of {COUNT} may be hit first" in said
    scene, camera = hl.Scene(centers, radii), hl.Camera((0, 0, 6), at=(0, 0, 0), vfov=40)
    hl.render(scene, camera, size=(640, 480)).save(tmp_path / "whole.png")
    assert (tmp_path / "dask.png").read_bytes() == (tmp_path / "whole.png").read_bytes()


def whole_picture(centers: Any, made: Path) -> None:
    """Compares a picture of parts with the picture of all spheres in memory."""
    camera = hl.Camera((0, 0, 12), at=(0, 0, 0), vfov=40)
    whole = made.with_name("whole.png")
    hl.render(hl.Scene(centers, 0.01), camera, size=(320, 240)).save(whole)
    assert made.read_bytes() == whole.read_bytes()


def test_the_example_with_a_snapshot_in_hdf5(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    said = engine(sys.executable, FARM / "parts_hdf5.py", folder=tmp_path)
    assert "of 300000 may be hit first" in said
    with h5py.File(tmp_path / "snapshot.hdf5") as file:
        whole_picture(file["PartType1/Coordinates"][()], tmp_path / "snapshot.png")


def test_the_example_with_a_series_of_openpmd(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("openpmd_api")
    said = engine(sys.executable, FARM / "parts_openpmd.py", folder=tmp_path)
    assert "of 200000 may be hit first" in said
    # What the example wrote, read by another library.
    with h5py.File(tmp_path / "electrons.h5") as file:
        electrons = file["data/0/particles/electrons"]
        parts = [
            [
                data[()] * (data.attrs["unitSI"] / 1e-6)
                for data in map(electrons[record].get, "xyz")
            ]
            for record in ("position", "positionOffset")
        ]
        assert np.ptp(parts[1]) > 3
        centers = np.stack(np.add(*parts), axis=1)
    whole_picture(centers, tmp_path / "electrons.png")
