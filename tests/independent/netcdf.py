"""Trajectories and restart files of AMBER that netCDF4 (the C library) and SciPy write, compared with what halfline-particles reads.

    pip install netCDF4 scipy numpy
    cargo build --release -p halfline-particles --example frames
    python tests/independent/netcdf.py target/release/examples/frames
"""

import json
import os
import subprocess
import sys
import tempfile

import netCDF4
import numpy as np
from scipy.io import netcdf_file

frames = os.path.abspath(sys.argv[1])
rng = np.random.default_rng(73)
VERSIONS = ["NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "scipy 1", "scipy 2"]


def write(path, kind, data, is_restart):
    if kind.startswith("scipy"):
        file = netcdf_file(path, "w", version=int(kind[-1]))
        types = {"f4": "f", "f8": "d"}
        make = lambda name, form, sides: file.createVariable(name, types[form], sides)
    else:
        file = netCDF4.Dataset(path, "w", format=kind)
        file.set_fill_off()
        make = file.createVariable
    file.Conventions, file.ConventionVersion = "AMBERRESTART" if is_restart else "AMBER", "1.0"
    count = data["coordinates"].shape[-2]
    for name, length in [("frame", None), ("spatial", 3), ("atom", count), ("cell_spatial", 3), ("cell_angular", 3)]:
        if not (is_restart and name == "frame"):
            file.createDimension(name, length)
    third = {"coordinates": "spatial", "velocities": "spatial", "cell_lengths": "cell_spatial"}
    for name, values in data.items():
        sides = [] if is_restart else ["frame"]
        sides += ["atom"] if name in ("coordinates", "velocities") else []
        sides += [] if name == "time" else [third.get(name, "cell_angular")]
        variable = make(name, "f8" if is_restart or name.startswith("cell") else "f4", tuple(sides))
        if name == "velocities":
            variable.scale_factor = np.float32(20.455)
            if hasattr(variable, "set_auto_scale"):
                variable.set_auto_scale(False)
        if sides:
            variable[:] = values
        elif kind.startswith("scipy"):
            variable.data[()] = values
        else:
            variable.assignValue(values)
    file.close()


files = positions = 0
with tempfile.TemporaryDirectory() as folder:
    for number in range(100):
        kind, is_restart = VERSIONS[number % 5], number % 3 == 0
        count, length = int(rng.choice([1, 2, 7, 1000])), 1 if is_restart else int(rng.choice([1, 2, 30]))
        shape = lambda *sides: sides if is_restart else (length, *sides)
        data = {"time": rng.random(shape()).astype("f4")} if number % 7 else {}
        data["coordinates"] = (rng.standard_normal(shape(count, 3)) * 50).astype("f4")
        if number % 2:
            data["velocities"] = rng.standard_normal(shape(count, 3)).astype("f4")
        if number % 4:
            data["cell_lengths"] = rng.uniform(20, 90, shape(3))
            data["cell_angles"] = np.full(shape(3), 90.0)
        path = f"{folder}/{number}.nc"
        write(path, kind, data, is_restart)
        done = subprocess.run([frames, path], capture_output=True, text=True)
        assert done.returncode == 0, (path, kind, done.stderr)
        found = [json.loads(line) for line in done.stdout.splitlines()]
        assert len(found) == length, (path, kind, len(found))
        for n, frame in enumerate(found):
            of = lambda name: data[name] if is_restart else data[name][n]
            assert np.array_equal(np.array(frame["positions"]), of("coordinates").astype("f8")), (path, kind)
            positions += count
            if "velocities" in data:
                for k, axis in enumerate("xyz"):
                    expected = of("velocities")[:, k].astype("f8") * float(np.float32(20.455))
                    assert np.array_equal(np.array(frame["columns"][f"v{axis}"]), expected), (path, kind)
            assert frame["time"] == (float(of("time")) if "time" in data else None), (path, kind)
            if "cell_lengths" in data:
                assert np.allclose(np.diag(frame["cell"]["edges"]), of("cell_lengths"), rtol=1e-15), (path, kind)
            else:
                assert frame["cell"] is None
        files += 1
print(f"{files} files, {positions} positions equal")
