"""OVITO's part: the first and repeated pictures of its standard renderer. Arguments: SCENE SIDE THREADS FRAMES."""
import json, sys, time

import numpy as np, ovito
from ovito.data import DataCollection, Particles
from ovito.pipeline import Pipeline, StaticSource
from ovito.vis import TachyonRenderer, Viewport

scene, (side, threads, frames) = sys.argv[1], map(int, sys.argv[2:5])
raw = np.fromfile(scene, np.float32).astype(float)
spheres = raw[16:].reshape(-1, 4)
start = time.perf_counter()
data = DataCollection()
particles = data.create_particles(count=len(spheres))
particles.create_property("Position", data=spheres[:, :3])
particles.create_property("Radius", data=spheres[:, 3])
Pipeline(source=StaticSource(data=data)).add_to_scene()
view = Viewport(type=Viewport.Type.Perspective, camera_pos=raw[0:3], camera_dir=raw[3:6] - raw[0:3])
view.camera_up, view.fov = raw[6:9], np.radians(raw[9])
build = 1e3 * (time.perf_counter() - start)


def render(**how):
    start = time.perf_counter()
    view.render_image(size=(side, side), background=(0, 0, 0), **how)
    return 1e3 * (time.perf_counter() - start)


name = "standard renderer"
try:
    times = [render() for _ in range(frames)]
except RuntimeError:
    # Qt found no usable Vulkan.
    name = "its own Tachyon"
    how = TachyonRenderer(ambient_occlusion=False, antialiasing=False, shadows=False)
    times = [render(renderer=how) for _ in range(frames)]
print(json.dumps({"version": f"{ovito.version_string}, {name}", "build": build, "frames": times}))
