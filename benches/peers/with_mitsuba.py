"""Mitsuba's part: depth, normal and id of one primary ray per pixel. Arguments: SCENE SIDE THREADS FRAMES."""
import glob, json, os, sys, time

# Dr.Jit looks for libLLVM.so, which only Debian's development package contains.
llvm = sorted(glob.glob("/usr/lib/*/libLLVM-*.so*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM*.so*"))
if llvm:
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", llvm[-1])
import drjit as dr, mitsuba as mi, numpy as np

scene, (side, threads, frames) = sys.argv[1], map(int, sys.argv[2:5])
mi.set_variant("llvm_ad_rgb")
dr.set_thread_count(threads)
raw = np.fromfile(scene, np.float32)
eye, at, up, vfov = raw[0:3], raw[3:6], raw[6:9], raw[9]
spheres = raw[16:].reshape(-1, 4)


def now():
    dr.sync_thread()
    return 1e3 * time.perf_counter()


w = (eye - at) / np.linalg.norm(eye - at)
u = np.cross(up, w)
u /= np.linalg.norm(u)
v = np.cross(w, u)
u, v, w, eye = (mi.Vector3f(*map(float, a)) for a in [u, v, w, eye])
step = 2 * np.tan(np.radians(vfov / 2)) / side


def load(spheres):
    """An ellipsoid extends to `extent` scales; its quaternion is x y z w."""
    start = now()
    turns = np.tile(np.array([0, 0, 0, 1], np.float32), (len(spheres), 1))
    arrays = {"centers": spheres[:, :3].copy(), "scales": np.repeat(spheres[:, 3:], 3, axis=1), "quaternions": turns}
    shape = {"type": "ellipsoids", "extent": 1.0, **{key: mi.TensorXf(array) for key, array in arrays.items()}}
    scene = mi.load_dict({"type": "scene", "spheres": shape})
    return now() - start, scene


load(spheres[:1])  # Mitsuba compiles once per process, which is not part of this scene's build
build, scene = load(spheres)


def trace():
    start = now()
    i = dr.arange(mi.UInt32, side * side)
    x = (mi.Float(i % side) + 0.5 - 0.5 * side) * step
    y = (0.5 * side - mi.Float(i // side) - 0.5) * step
    hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(eye), dr.normalize(x * u + y * v - w)), mi.RayFlags.Minimal, True)
    dr.eval(hit.t, hit.n, hit.prim_index)
    return now() - start, hit


times = [trace() for _ in range(frames)]
hits = int(np.count_nonzero(np.isfinite(np.array(times[-1][1].t))))
print(json.dumps({"version": mi.__version__, "build": build, "frames": [t for t, _ in times], "hits": hits}))
