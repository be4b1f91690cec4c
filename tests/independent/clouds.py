"""Clouds of hits read by other programs, and compared with the .npz that halfline wrote of the same rays.

    pip install numpy laspy plyfile pypcd4
    python tests/independent/clouds.py path/to/halfline
"""
import os, subprocess, sys, tempfile

import laspy, numpy as np, plyfile, pypcd4

halfline = os.path.abspath(sys.argv[1])
scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scenes/weekend.toml")


def trace(output, *rays):
    subprocess.run([halfline, "trace", scene, "--backend", "cpu", *rays, "-o", output], check=True)


def check(what, a, b):
    assert np.array_equal(a, b), what
    print("equal:", what, a.shape, a.dtype)


def srgb(x, levels):
    x = np.clip(np.asarray(x, "f8"), 0, 1)
    return np.floor(levels * np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055) + 0.5)


def compare(rays, names):
    for output in ["hits.npz", "hits.ply", "hits.pcd", "hits.las"]:
        trace(output, *rays)
    npz = np.load("hits.npz")
    hit = npz["id"] >= 0
    places = dict(zip(names, np.nonzero(hit)))
    position, distance, sphere = npz["position"][hit], npz["distance"][hit], npz["id"][hit]
    assert len(sphere) > 100 and not hit.all() and np.isnan(npz["position"][~hit]).all()

    ply = plyfile.PlyData.read("hits.ply")["vertex"]
    check("plyfile, position", np.stack([ply["x"], ply["y"], ply["z"]], -1), position)
    pcd = pypcd4.PointCloud.from_path("hits.pcd")
    check("pypcd4, position", pcd.numpy(("x", "y", "z")), position.astype("f4"))
    las = laspy.read("hits.las")
    assert str(las.header.version) == "1.4" and las.header.point_format.id == 7
    worst, side = np.abs(las.xyz - position).max(0), np.ptp(position, axis=0)
    assert (worst <= side * 2.0**-31).all(), (worst, side)
    print("laspy, position: within", worst)
    check("laspy, bounds", np.array([las.header.mins, las.header.maxs]), np.array([las.xyz.min(0), las.xyz.max(0)]))
    fields = {"distance": distance, "id": sphere, **places}
    for name, numbers in fields.items():
        check(f"plyfile, {name}", ply[name], numbers)
        check(f"pypcd4, {name}", pcd.numpy((name,))[:, 0], numbers.astype("f4"))
        check(f"laspy, {name}", np.asarray(las[name]), numbers)
    ply_color = np.stack([ply[name] for name in ("red", "green", "blue")], -1)
    las_color = np.stack([las.red, las.green, las.blue], -1)
    check("pypcd4, colour", pypcd4.PointCloud.decode_rgb(pcd.numpy(("rgb",))[:, 0].astype("f4")), ply_color)
    # A sphere has one colour, and the levels of 8 and 16 bits are of the same number.
    assert np.abs(las_color / 65535 - ply_color / 255).max() <= 0.5 / 255 + 0.5 / 65535
    for number in np.unique(sphere):
        assert len(np.unique(las_color[sphere == number], axis=0)) == 1
    return dict(zip(sphere.tolist(), las_color.tolist()))


def compare_echoes(*rays):
    for output in ["echoes.npz", "echoes.ply", "echoes.pcd", "echoes.las"]:
        trace(output, *rays)
    npz = np.load("echoes.npz")
    ply = plyfile.PlyData.read("echoes.ply")["vertex"]
    pcd = pypcd4.PointCloud.from_path("echoes.pcd")
    las = laspy.read("echoes.las")
    for name in ["ring", "column", "return_number", "number_of_returns", "id", "distance", "intensity"]:
        check(f"plyfile, {name} of echoes", ply[name], npz[name])
        check(f"pypcd4, {name} of echoes", pcd.numpy((name,))[:, 0], npz[name].astype("f4"))
        expected = np.floor(npz[name] * np.float64(65535) + 0.5) if name == "intensity" else npz[name]
        check(f"laspy, {name} of echoes", np.asarray(las[name]), expected)
    counts = np.bincount(npz["return_number"], minlength=16)[1:]
    assert counts[1] > 100, counts
    check("laspy, numbers of points by return", las.header.number_of_points_by_return, counts)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    pattern = ["--pattern", "lidar:rings=60,vfov=-40..20,step=0.5"]
    trace("beams.npz", *pattern, "--rays-out", "beams.npy")
    scan = compare(pattern, ["ring", "column"])
    assert scan == compare(["--rays", "beams.npy"], ["ray"]), "other colours"
    compare_echoes("--pattern", "lidar:rings=60,vfov=-40..20,step=0.5,divergence=1,returns=5,noise=0.01,seed=2")
