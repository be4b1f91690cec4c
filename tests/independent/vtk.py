"""Files of VTK that VTK and meshio write, compared with the points, columns and times that halfline-particles reads.

    pip install vtk meshio numpy
    cargo build --release -p halfline-particles --example frames
    python tests/independent/vtk.py target/release/examples/frames
"""

import itertools
import json
import os
import subprocess
import sys
import tempfile

import meshio
import numpy as np
from vtkmodules import vtkIOLegacy, vtkIOXML
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkUnstructuredGrid

frames = os.path.abspath(sys.argv[1])
rng = np.random.default_rng(72)
KINDS = ["f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"]
EXACT = 2**53


def draw(kind, *shape):
    if kind[0] == "f":
        return (rng.standard_normal(shape) * 10.0 ** rng.integers(-3, 4)).astype(kind)
    ends = np.iinfo(kind)
    ends = [max(ends.min, -EXACT), min(ends.max, EXACT)]
    return rng.integers(*ends, shape, endpoint=True, dtype="u8" if kind == "u8" else "i8").astype(kind)


def data(count):
    """Points, and an array of each type, of one to nine numbers."""
    arrays = {f"array {kind}": draw(kind, count, k) for kind, k in zip(KINDS, [1, 2, 3, 4, 6, 9, 1, 1, 3, 1], strict=True)}
    return draw(rng.choice(["f4", "f8"]), count, 3), arrays


def dataset(points, arrays, grid):
    made = vtkUnstructuredGrid() if grid else vtkPolyData()
    kept = vtkPoints()
    kept.SetData(numpy_to_vtk(points, deep=1))
    made.SetPoints(kept)
    cells = vtkCellArray()
    for n in range(len(points)):
        cells.InsertNextCell(1, [n])
    made.SetCells(1, cells) if grid else made.SetVerts(cells)
    for name, values in arrays.items():
        array = numpy_to_vtk(values, deep=1)
        array.SetName(name)
        made.GetPointData().AddArray(array)
    return made


def by_xml(folder):
    """All modes, compressors, headers and byte orders; blocks that are smaller than the arrays."""
    modes = ["SetDataModeToAscii", "SetDataModeToBinary", "SetDataModeToAppended"]
    compressors = ["None", "ZLib", "LZ4", "LZMA"]
    for number, (mode, base64, compressor, header, order, grid) in enumerate(
        itertools.product(modes, [0, 1], compressors, [32, 64], [0, 1], [0, 1])
    ):
        count = int(rng.choice([1, 7, 40, 3000]))
        points, arrays = data(count)
        writer = vtkIOXML.vtkXMLUnstructuredGridWriter() if grid else vtkIOXML.vtkXMLPolyDataWriter()
        writer.SetInputData(dataset(points, arrays, grid))
        getattr(writer, mode)()
        writer.SetEncodeAppendedData(base64)
        getattr(writer, f"SetCompressorTypeTo{compressor}")()
        writer.SetBlockSize(int(rng.choice([1024, 32768])))
        getattr(writer, f"SetHeaderTypeToUInt{header}")()
        writer.SetByteOrder(order)
        path = f"{folder}/{number}.{'vtu' if grid else 'vtp'}"
        writer.SetFileName(path)
        assert writer.Write()
        yield path, points, arrays


def by_legacy(folder):
    for number, (binary, version, grid) in enumerate(itertools.product([0, 1], [42, 51], [0, 1])):
        points, arrays = data(int(rng.choice([1, 7, 40])))
        if not binary:
            # Text has six digits, or eleven.
            points = np.array([f"{x:.3g}" for x in points.flat]).reshape(-1, 3).astype(points.dtype)
            arrays = {name: values for name, values in arrays.items() if values.dtype.kind != "f"}
        writer = vtkIOLegacy.vtkUnstructuredGridWriter() if grid else vtkIOLegacy.vtkPolyDataWriter()
        writer.SetInputData(dataset(points, arrays, grid))
        writer.SetFileVersion(version)
        writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
        path = f"{folder}/legacy{number}.vtk"
        writer.SetFileName(path)
        assert writer.Write()
        yield path, points, arrays


def by_meshio(folder):
    for number, (format, how) in enumerate(
        [("vtu", {"compression": c, "header_type": h}) for c in [None, "zlib", "lzma"] for h in ["UInt32", "UInt64"]]
        + [("vtk42", {"binary": True}), ("vtk51", {"binary": True})]
    ):
        points, arrays = data(int(rng.choice([1, 7, 40, 3000])))
        arrays = {name.replace(" ", "_"): values for name, values in arrays.items() if values.shape[1] in (1, 3)}
        mesh = meshio.Mesh(points, [("vertex", np.arange(len(points))[:, None])], point_data=arrays)
        path = f"{folder}/meshio{number}.{format[:3]}"
        mesh.write(path, file_format=format, **how)
        yield path, points, arrays


def check(path, points, arrays):
    """The number of columns that are equal to the arrays."""
    done = subprocess.run([frames, path], capture_output=True, text=True)
    assert done.returncode == 0, (path, done.stderr)
    found = json.loads(done.stdout)
    assert np.array_equal(found["positions"], points.astype("f8")), path
    compared = 0
    for name, values in arrays.items():
        for k in range(values.shape[1]):
            column = name if values.shape[1] == 1 else f"{name}_{'xyz'[k] if k < 3 else k}"
            assert np.array_equal(found["columns"][column], values[:, k].astype("f8")), (path, column)
            compared += 1
    return compared


with tempfile.TemporaryDirectory() as folder:
    for write in [by_xml, by_legacy, by_meshio]:
        compared = [check(*file) for file in write(folder)]
        print(f"{write.__name__[3:]}: {len(compared)} files, {sum(compared)} columns equal")
