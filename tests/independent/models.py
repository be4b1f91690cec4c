"""A .glb of halfline read by pygltflib, trimesh and, where it is installed, Blender, and compared with gemmi's atoms.

    pip install numpy pygltflib trimesh gemmi [bpy]
    python tests/independent/models.py path/to/halfline FILE.pdb
"""
import os, subprocess, sys, tempfile

import gemmi, numpy as np, pygltflib, trimesh

halfline, file = map(os.path.abspath, sys.argv[1:3])


def check(what, a, b):
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape and np.array_equal(a, b), what
    print("equal:", what, a.shape, a.dtype)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    about = ["--altloc", "all", "--color", "red", "--radius", "0.75", "--size", "64x48", "--vfov", "30"]
    subprocess.run([halfline, "render", file, "-o", "a.glb", *about], check=True)
    model = gemmi.read_structure(file)[0]
    atoms = np.array([atom.pos.tolist() for chain in model for residue in chain for atom in residue])

    gltf = pygltflib.GLTF2().load("a.glb")
    blob, (primitive,) = gltf.binary_blob(), gltf.meshes[0].primitives

    def numbers(accessor):
        accessor = gltf.accessors[accessor]
        view = gltf.bufferViews[accessor.bufferView]
        array = np.frombuffer(blob, "<f4", view.byteLength // 4, view.byteOffset)
        assert accessor.componentType == pygltflib.FLOAT
        return array.reshape(accessor.count, -1)

    node = next(node for node in gltf.nodes if node.mesh is not None)
    assert primitive.mode == pygltflib.POINTS
    near = (atoms - np.array(node.translation)).astype("f4")
    check("pygltflib reads the positions", numbers(primitive.attributes.POSITION), near)
    check("their ends", [gltf.accessors[0].min, gltf.accessors[0].max], [near.min(0).astype("f8"), near.max(0).astype("f8")])
    check("the radii", numbers(primitive.attributes._RADIUS)[:, 0], np.full(len(atoms), 0.75, "f4"))
    check("the colours", numbers(primitive.attributes.COLOR_0), np.tile(np.float32([1, 0, 0]), (len(atoms), 1)))
    assert abs(np.degrees(gltf.cameras[0].perspective.yfov) - 30) < 1e-12

    scene = trimesh.load("a.glb")
    (cloud,) = scene.geometry.values()
    check("trimesh reads the points", np.asarray(cloud.vertices, "f4"), near)

    try:
        import bpy
    except ImportError:
        sys.exit("bpy is not installed: Blender was not asked")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath="a.glb")
    (points,) = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    mesh, count = points.data, len(atoms)
    found, radii = np.empty(3 * count, "f4"), np.empty(count, "f4")
    mesh.vertices.foreach_get("co", found)
    mesh.attributes["_RADIUS"].data.foreach_get("value", radii)
    # Blender's up is z: x, -z, y.
    check("Blender reads the positions", found.reshape(-1, 3), near[:, [0, 2, 1]] * np.float32([1, -1, 1]))
    check("Blender reads the radii", radii, np.full(count, 0.75, "f4"))
    colors = [attribute.name for attribute in mesh.color_attributes]
    (camera,) = [thing for thing in bpy.data.objects if thing.type == "CAMERA"]
    print("Blender has the colours", colors, "and a camera of", round(np.degrees(camera.data.angle_y), 4), "degrees")
