"""Trajectories, crystals, scans and simulations as other programs read them, compared with the spheres of halfline.

    pip install MDAnalysis MDAnalysisTests ase laspy lazrs gsd numpy zstandard biotite gemmi
    cargo build --release --example spheres
    python tests/independent/readers.py target/release/examples/spheres [trajectories poscar las laz gsd packed bcif groups]

`bcif` takes the mmCIF files in the folder HALFLINE_DATA.
"""
import itertools, json, os, subprocess, sys, tempfile, warnings

import numpy as np

warnings.simplefilter("ignore")
spheres = os.path.abspath(sys.argv[1])
parts = sys.argv[2:] or ["trajectories", "poscar", "las", "laz", "gsd", "packed", "bcif", "groups"]


def read(path, *arguments):
    """The frames of a file: dictionaries with centers, radii, cell, range and warnings."""
    done = subprocess.run([spheres, path, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, (path, done.stderr)
    return [json.loads(line) for line in done.stdout.splitlines()]


def error_of(found, expected):
    """The greatest difference, relative to the greatest number of the other program."""
    found, expected = np.asarray(found, "f8"), np.asarray(expected, "f8")
    assert found.shape == expected.shape, (found.shape, expected.shape)
    return np.abs(found - expected).max(initial=0) / max(np.abs(expected).max(initial=0), 1)


def trajectories():
    import MDAnalysis
    from MDAnalysis.lib.mdamath import triclinic_vectors
    import MDAnalysisTests

    data = os.path.join(os.path.dirname(MDAnalysisTests.__file__), "data")
    # MDAnalysis rounds to float32 after the division by the precision (XTC) and after the conversion to ångström: three
    # roundings. Lengths and angles of cells are float32 too, and the cosine of an angle in degrees near 90 has an error of
    # 90 pi / 180 units.
    position, cell = 3 * 2**-24, 8 * 2**-24
    files = {
        "adk_oplsaa.xtc": "adk_oplsaa.gro", "adk_oplsaa.trr": "adk_oplsaa.gro", "cobrotoxin.trr": "cobrotoxin.pdb",
        "cobrotoxin.xtc": "cobrotoxin.pdb", "adk_dims.dcd": "adk_open.pdb", "adk_dims2.dcd": "adk_open.pdb",
        "adk_gbis_tmd-fast1_NAMD.dcd": None, "SiN_tric_namd.dcd": None, "tip125_tric_C36.dcd": None, "watdyn.dcd": None,
        "aux_edr.xtc": None, "xyz_random_walk.xtc": None, "xtc_test_only_10_frame_10_atoms.xtc": None,
        "trr_test_only_10_frame_10_atoms.trr": None, "surface.trr": None, "analysis/YiiP_lipids.xtc": "analysis/YiiP_lipids.gro.gz",
        "coordinates/test.xtc": None, "coordinates/test.trr": None, "coordinates/test.dcd": None,
        "lammps/ifabp_apo_100mM.dcd": None,
    }  # fmt: skip
    for name, topology in files.items():
        path = os.path.join(data, name)
        reader = MDAnalysis.coordinates.core.reader(path)
        options = ["--topology", os.path.join(data, topology)] if topology else []
        found = read(path, *options)
        moves = bool(reader.ts.has_velocities)
        ranges = [frame["range"] for frame in read(path, *options, "--color-by", "vy")] if moves else []
        stays = slice(None)
        if topology and len(found[0]["centers"]) != reader.n_atoms:
            # Virtual sites are left out: MW of TIP4P, and the dummies around zinc.
            names = MDAnalysis.Universe(os.path.join(data, topology)).atoms.names
            stays = np.array([name != "MW" and not name.startswith("DM") for name in names])
        assert len(found) == reader.n_frames, (name, len(found), reader.n_frames)
        errors, cells, speeds, times = [], [], [], []
        for n, (frame, step) in enumerate(zip(found, reader)):
            errors.append(error_of(frame["centers"], step.positions[stays]))
            if name.startswith("lammps/"):
                # The unit of LAMMPS is not in the file, and MDAnalysis takes it as AKMA.
                assert frame["time"] is None, name
            else:
                times.append(abs(frame["time"] - step.time) / max(abs(step.time), 1e-300))
            # MDAnalysis gives the position in a DCD file as the step.
            assert name.endswith("dcd") or frame["step"] == step.data["step"], name
            if step.dimensions is None or not step.dimensions.any():
                assert frame["cell"] is None, name
            else:
                edges = np.array(frame["cell"]["edges"])
                # A cell of newer CHARMM is three vectors of any direction; lengths and angles are the same.
                gram = triclinic_vectors(step.dimensions).astype("f8")
                cells.append(error_of(edges @ edges.T, gram @ gram.T))
            if moves:
                # MDAnalysis converts nm/ps to ångström/ps.
                vy = step.velocities[stays, 1].astype("f8") / 10
                speeds.append(error_of(ranges[n], [vy.min(), vy.max()]))
        # Times are numbers of the file, or a product of three, which MDAnalysis multiplies and rounds in another order.
        assert max(times + [0]) <= 4 * 2**-53, (name, max(times))
        assert max(errors) <= position and max(cells + [0]) <= cell and max(speeds + [0]) <= position, name
        one = read(path, "--frames", str(len(found)), *options)
        assert [frame["centers"] for frame in one] == [found[-1]["centers"]], name
        print(
            f"{name}: {len(found)} frames of {len(found[0]['centers'])}, positions {max(errors):.1e}, "
            f"cells {max(cells + [0]):.1e} of {len(cells)}, velocities {max(speeds + [0]):.1e} of {len(speeds)}, "
            f"times {max(times + [0]):.1e} of {len(times)}"
        )


def poscar():
    import ase.build, ase.io
    from ase.io.vasp import write_vasp

    atoms = ase.build.bulk("NaCl", "rocksalt", a=5.64).repeat((3, 2, 4))
    atoms.rattle(0.2, seed=1)
    atoms.set_cell(atoms.cell @ np.array([[1, 0.1, 0], [0, 1.2, -0.3], [0.05, 0, 0.9]]), scale_atoms=True)
    atoms = atoms[np.argsort(atoms.numbers, kind="stable")]
    texts = {}
    for direct in [False, True]:
        for version in [4, 5]:
            with tempfile.NamedTemporaryFile("w+", suffix=".vasp") as file:
                write_vasp(file.name, atoms, direct=direct, vasp5=version == 5)
                texts[f"VASP {version}, {'direct' if direct else 'Cartesian'}"] = open(file.name).read()
    lines = texts["VASP 5, direct"].splitlines(keepends=True)
    volume = abs(float(np.linalg.det(atoms.cell)))
    texts["negative scale"] = "".join([lines[0], f"{-2 * volume!r}\n", *lines[2:]])
    texts["selective dynamics"] = "".join([*lines[:7], "Selective dynamics\n", *lines[7:8], *[line[:-1] + " T F T\n" for line in lines[8:]]])
    for name, text in texts.items():
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "POSCAR")
            open(path, "w").write(text)
            (found,) = read(path)
            other = ase.io.read(path, format="vasp")
        # A few roundings of products and sums of three; the cube root of a volume.
        errors = [error_of(found["centers"], other.positions), error_of(found["cell"]["edges"], other.cell[:])]
        assert max(errors) < 1e-14, (name, errors)
        # Van der Waals radii of Na and Cl, which Bondi and Alvarez give.
        radii = [{11: 2.27, 17: 1.75}[number] for number in other.numbers]
        assert found["radii"] == radii, name
        print(f"POSCAR, {name}: {len(radii)} atoms, positions {errors[0]:.1e}, cell {errors[1]:.1e}")


def las():
    import laspy

    rng = np.random.default_rng(1)
    for fmt in range(11):
        if fmt in (4, 5, 9, 10):
            continue  # laspy writes no wave packets
        header = laspy.LasHeader(point_format=fmt, version="1.4" if fmt > 5 else "1.2")
        header.scales, header.offsets = [0.001, 0.01, 1 / 3], [4e5, -5e6, 0.1]
        cloud = laspy.LasData(header)
        cloud.x, cloud.y, cloud.z = [rng.uniform(-100, 100, 1000) + offset for offset in header.offsets]
        cloud.intensity, cloud.classification = rng.integers(0, 65536, 1000), rng.integers(0, 32, 1000)
        cloud.return_number, cloud.number_of_returns = rng.integers(0, 8, 1000), rng.integers(0, 8, 1000)
        cloud.user_data, cloud.point_source_id = rng.integers(0, 256, 1000), rng.integers(0, 65536, 1000)
        names = {"return_number": "return_number", "number_of_returns": "number_of_returns", "user_data": "user_data"}
        names |= {"intensity": "intensity", "classification": "classification", "point_source": "point_source_id"}
        dimensions = list(cloud.point_format.dimension_names)
        if "gps_time" in dimensions:
            cloud.gps_time, names["gps_time"] = rng.uniform(0, 1e9, 1000), "gps_time"
        if "nir" in dimensions:
            cloud.nir, names["nir"] = rng.integers(0, 65536, 1000), "nir"
        if "red" in dimensions:
            cloud.red, cloud.green, cloud.blue = rng.integers(0, 65536, (3, 1000))
        with tempfile.NamedTemporaryFile(suffix=".las") as file:
            cloud.write(file.name)
            (found,) = read(file.name)
            ranges = {name: read(file.name, "--color-by", name)[0]["range"] for name in names}
            other = laspy.read(file.name)
        with tempfile.NamedTemporaryFile(suffix=".laz") as file:
            # laspy compresses by lazrs.
            cloud.write(file.name)
            (packed,) = read(file.name)
            assert all(packed[key] == found[key] for key in ["centers", "radii", "colors"]), fmt
            assert ranges == {name: read(file.name, "--color-by", name)[0]["range"] for name in names}, fmt
        assert found["centers"] == other.xyz.tolist(), fmt
        for name, theirs in names.items():
            column = np.asarray(other[theirs], "f8")
            assert ranges[name] == [column.min(), column.max()], (fmt, name)
        if "red" in dimensions:
            x = np.stack([other.red, other.green, other.blue], -1) / 65535.0
            # IEC 61966-2-1; stored as float32.
            linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
            assert error_of(found["colors"], linear) < 2**-23, fmt
        print(f"LAS and LAZ, format {fmt}: 1000 points with equal positions, ranges of {', '.join(names)}")


def laz():
    """Scans of more points than a chunk of LAZ has: 50,000."""
    import laspy

    for fmt, count in itertools.product([0, 1, 2, 3, 6, 7, 8], [50000, 120001]):
        rng = np.random.default_rng(fmt)
        header = laspy.LasHeader(point_format=fmt, version="1.4" if fmt > 5 else "1.2")
        header.scales, header.offsets = [0.001] * 3, [4e5, 5e6, 0]
        if fmt in (1, 7):
            header.add_extra_dim(laspy.ExtraBytesParams(name="more", type=np.float32))
        cloud, n = laspy.LasData(header), np.arange(count)
        angle = n % 500 / 250 - 1
        cloud.x, cloud.y = 4e5 + 100 * angle + rng.normal(0, 0.01, count), 5e6 + n / 500 * 0.3
        cloud.z = 20 * np.sin(cloud.x / 30) + rng.normal(0, 0.05, count)
        cloud.intensity = 2000 + 800 * np.cos(n / 90) + rng.integers(0, 60, count)
        cloud.number_of_returns = rng.integers(1, 5, count)
        cloud.return_number = 1 + rng.integers(0, 5, count) % cloud.number_of_returns
        cloud.classification, cloud.point_source_id = rng.choice([1, 2, 5, 6], count), 7 + n // 30000
        cloud.user_data, names = n // 1000 % 9, {"intensity": "intensity", "point_source": "point_source_id"}
        dimensions = list(cloud.point_format.dimension_names)
        if fmt > 5:
            cloud.scan_angle, cloud.scanner_channel = 5000 * angle, rng.integers(0, 3, count) * (n % 40000 > 30000)
        if "gps_time" in dimensions:
            cloud.gps_time, names["gps_time"] = 2e8 + n // 2 * 5e-6 + n // 500 * 0.01 + (n // 7000 % 3) * 1e6, "gps_time"
        if "nir" in dimensions:
            cloud.nir, names["nir"] = rng.integers(900, 1000, count), "nir"
        if "red" in dimensions:
            cloud.red, cloud.green, cloud.blue = [256 * (100 + rng.integers(0, 20, count) + k * n // 9000) for k in range(3)]
        if "more" in dimensions:
            cloud.more = np.sqrt(n)
        found = {}
        for suffix in [".las", ".laz"]:
            with tempfile.NamedTemporaryFile(suffix=suffix) as file:
                cloud.write(file.name)
                (frame,) = read(file.name)
                ranges = {name: read(file.name, "--color-by", name)[0]["range"] for name in names}
                found[suffix] = [frame[key] for key in ["centers", "radii", "colors"]], ranges
                size = os.path.getsize(file.name)
        assert found[".las"] == found[".laz"] and len(found[".laz"][0][0]) == count, fmt
        assert found[".laz"][0][0] == cloud.xyz.tolist(), fmt
        for name, theirs in names.items():
            column = np.asarray(cloud[theirs], "f8")
            assert found[".laz"][1][name] == [column.min(), column.max()], (fmt, name)
        print(f"LAZ, format {fmt}: {count} points in {size} bytes, equal to LAS")


def gsd():
    import gsd.hoomd
    import MDAnalysisTests

    data = os.path.join(os.path.dirname(MDAnalysisTests.__file__), "data")
    for name in ["example.gsd", "example_bonds.gsd", "example_longer.gsd"]:
        path = os.path.join(data, name)
        found = read(path)
        columns = {name: [frame["range"] for frame in read(path, "--color-by", name)] for name in ["vx", "mass"]}
        with gsd.hoomd.open(path) as frames:
            assert len(found) == len(frames), name
            for n, (ours, theirs) in enumerate(zip(found, frames)):
                assert ours["centers"] == theirs.particles.position.astype("f8").tolist(), name
                assert ours["radii"] == (theirs.particles.diameter.astype("f8") / 2).tolist(), name
                x, y, z, xy, xz, yz = theirs.configuration.box.astype("f8")
                assert ours["cell"]["edges"] == [[x, 0, 0], [xy * y, y, 0], [xz * z, yz * z, z]], name
                for column, values in {"vx": theirs.particles.velocity[:, 0], "mass": theirs.particles.mass}.items():
                    ends = [values.min(), values.max()]
                    # Equal values have a range of their own.
                    assert ends[0] == ends[1] or columns[column][n] == [float(x) for x in ends], (name, column)
        print(f"{name}: {len(found)} frames of {len(found[0]['centers'])} equal positions, diameters, boxes and velocities")


def packed():
    """Tables in data of liblzma and libzstd, in one or several parts, against the same tables as they are."""
    import lzma
    import zstandard

    rng = np.random.default_rng(54)
    table = b"x,y,z,t\n" + "".join(f"{x!r},{y:.3f},{k},{k % 7}\n" for k, (x, y) in enumerate(rng.normal(size=(60000, 2)).tolist())).encode()
    with tempfile.TemporaryDirectory() as folder:

        def spheres_of(name, data):
            path = os.path.join(folder, name)
            with open(path, "wb") as file:
                file.write(data)
            return read(path, "--color-by", "t")

        plain = spheres_of("a.csv", table)
        checks = [lzma.CHECK_NONE, lzma.CHECK_CRC32, lzma.CHECK_CRC64, lzma.CHECK_SHA256]
        made = {f"xz, preset {preset}, check {check}": lzma.compress(table, check=check, preset=preset) for preset in (0, 3, 6, 9) for check in checks}
        chains = {"delta": [{"id": lzma.FILTER_DELTA, "dist": 4}], "x86": [{"id": lzma.FILTER_X86}], "ARM": [{"id": lzma.FILTER_ARM}]}
        for name, chain in chains.items():
            made[f"xz, {name}"] = lzma.compress(table, filters=[*chain, {"id": lzma.FILTER_LZMA2, "preset": 6}])
        half = len(table) // 2
        made["xz, two streams"] = lzma.compress(table[:half]) + bytes(4) + lzma.compress(table[half:])
        for level in (-5, 1, 3, 9, 19, 22):
            for checksum in (False, True):
                coder = zstandard.ZstdCompressor(level=level, write_checksum=checksum)
                made[f"zst, level {level}, checksum {checksum}"] = coder.compress(table)
        coder = zstandard.ZstdCompressor(threads=2).compressobj()
        made["zst, a stream of two threads"] = coder.compress(table) + coder.flush()
        one = zstandard.ZstdCompressor().compress
        made["zst, three frames and one to skip"] = one(table[:half]) + one(b"") + b"\x50\x2a\x4d\x18\x03\0\0\0abc" + one(table[half:])
        for name, data in made.items():
            assert spheres_of("a.csv." + name.split(",")[0], data) == plain, name
        print(f"{len(made)} compressed tables of {len(plain[0]['centers'])} points: equal spheres and ranges")


def bcif():
    """BinaryCIF of biotite, as arrays and with the encodings that it finds best, against the mmCIF files it was made of."""
    import glob

    import biotite.structure.io.pdbx as pdbx

    def column_of(column, is_number):
        mask = None if column.mask is None else column.mask.array
        data = column.as_array(str)
        numbers = None
        for kind in (np.int32, np.float64) if is_number else ():
            try:
                numbers = np.where(np.zeros(len(data), bool) if mask is None else mask != 0, "0", data).astype(kind)
                break
            except (ValueError, OverflowError):
                pass
        return pdbx.BinaryCIFColumn(data if numbers is None else numbers, mask)

    columns = "name resname residue chain segid serial bfactor occupancy altloc icode record entity asym model".split()
    for path in sorted(glob.glob(os.path.join(os.environ["HALFLINE_DATA"], "*.cif"))):
        with tempfile.TemporaryDirectory() as folder:
            binary = pdbx.BinaryCIFFile()
            for name, block in pdbx.CIFFile.read(path).items():
                categories = {}
                for category, content in block.items():
                    is_number = category in ("atom_site", "cell", "pdbx_struct_oper_list")
                    own = {key: column_of(column, is_number) for key, column in content.items()}
                    categories[category] = pdbx.BinaryCIFCategory(own)
                binary[name] = pdbx.BinaryCIFBlock(categories)
            for name, file in {"arrays": binary, "encodings": pdbx.compress(binary, float_tolerance=1e-12)}.items():
                made = os.path.join(folder, f"{name}.bcif")
                file.write(made)
                for options in [[], *([["--color-by", column] for column in columns])]:
                    assert read(made, *options) == read(path, *options), (path, name, options)
                print(f"{os.path.basename(path)} as {name}: {os.path.getsize(made)} bytes, {len(columns)} equal columns")


def groups():
    """A general position in all settings of space groups, by the Hall symbol and by the Hermann-Mauguin symbol, against gemmi."""
    import gemmi

    # No two images are as near as one atom.
    place = np.array([0.1373, 0.3141, 0.0611])
    edges = {"a": (200, 300, 400, 100, 90, 90), "b": (200, 300, 400, 90, 100, 90), "c": (200, 300, 400, 90, 90, 100)}
    kinds = {
        "triclinic": (200, 300, 400, 80, 95, 105), "orthorhombic": (200, 300, 400, 90, 90, 90), "tetragonal": (300, 300, 400, 90, 90, 90),
        "trigonal": (300, 300, 400, 90, 90, 120), "hexagonal": (300, 300, 400, 90, 90, 120), "cubic": (400, 400, 400, 90, 90, 90),
    }  # fmt: skip
    count = 0
    for group in gemmi.spacegroup_table_itb():
        kind = group.crystal_system_str()
        cell = edges[group.qualifier.strip("-")[0]] if kind == "monoclinic" else kinds[kind]
        cell = (300, 300, 300, 75, 75, 75) if group.ext == "R" else cell
        orth = np.array(gemmi.UnitCell(*cell).orth.mat.tolist())
        theirs = np.array([op.apply_to_xyz(place.tolist()) for op in group.operations()]) % 1
        names = "length_a length_b length_c angle_alpha angle_beta angle_gamma".split()
        lines = ["data_a", *(f"_cell_{name} {value}" for name, value in zip(names, cell))]
        atoms = ["loop_", "_atom_site_label", *(f"_atom_site_fract_{axis}" for axis in "xyz"), "C1 " + " ".join(map(str, place))]
        for tag, name in [("Hall", group.hall), ("H-M_alt", group.xhm())]:
            # Symbols of Hall have both kinds of quotes.
            text = [f"_space_group_name_{tag}", ";" + name, ";"]
            with tempfile.NamedTemporaryFile("w", suffix=".cif") as file:
                file.write("\n".join([*lines, *text, *atoms]) + "\n")
                file.flush()
                (frame,) = read(file.name)
            ours = np.linalg.solve(orth, np.array(frame["centers"]).T).T
            away = (ours[:, None] - theirs[None] + 0.5) % 1 - 0.5
            # Fractions are of some operations in f64, and the inverse of the cell of some more.
            nearest = np.abs(away).max(-1).min(-1)
            assert len(ours) == len(theirs) and nearest.max() < 1e-12, (name, len(ours), len(theirs), nearest.max())
            assert len(set(np.abs(away).max(-1).argmin(-1).tolist())) == len(theirs), name
            count += 1
    print(f"{count} names of settings: the points of the general position equal the points of gemmi {gemmi.__version__}")


for part in parts:
    globals()[part]()
