"""Writes the small compressed files of the unit tests of LAZ, with lazrs (a port of LASzip), in chunks of 16 points.

    pip install laspy lazrs numpy
    python tests/independent/laz.py particles/src/formats/las/laz/samples

Point n has the numbers of `expected` in particles/src/formats/las/laz/tests.rs.
"""
import io, os, sys

import laspy, lazrs, numpy as np

folder = sys.argv[1]
os.makedirs(folder, exist_ok=True)
POINTS = 40

for fmt in [0, 1, 2, 3, 6, 7, 8]:
    header = laspy.LasHeader(point_format=fmt, version="1.4" if fmt > 5 else "1.2")
    header.scales, header.offsets = [0.5, 0.25, 0.125], [100.0, 0.0, -1.0]
    if fmt in (3, 7):
        header.add_extra_dim(laspy.ExtraBytesParams(name="more", type=np.uint16))
    cloud = laspy.LasData(header)
    n = np.arange(POINTS)
    cloud.X, cloud.Y, cloud.Z = n * n * n - 700, 900000 - 37 * n, (n * 7919) % 1000 * (n % 3)
    cloud.intensity = (n * 40503) % 65536 // (1 + n % 2 * 99)
    cloud.number_of_returns, cloud.return_number = 1 + n % 4, 1 + n % (1 + n % 4)
    cloud.classification, cloud.user_data, cloud.point_source_id = n // 5 % 20, n % 7 * 30, 500 + n // 9 * 1000
    cloud.scan_direction_flag, cloud.edge_of_flight_line = n % 2, n // 7 % 2
    if fmt > 5:
        cloud.scan_angle, cloud.scanner_channel = n * 300 - 6000, n // 6 % 3
    else:
        cloud.scan_angle_rank = n - 20
    names = list(cloud.point_format.dimension_names)
    if "gps_time" in names:
        # Equal times, equal steps, another sequence, and a jump.
        cloud.gps_time = 1e8 + n // 3 * 0.25 + np.where(n % 8 == 7, 5e5, 0) + np.where(n > 30, 1e-3 * n * n, 0)
    if "red" in names:
        cloud.red, cloud.green, cloud.blue = n * 1000, n * 1000 + n // 4 * 300, 65535 - n * n
    if "nir" in names:
        cloud.nir = n // 3 * 999
    if "more" in names:
        cloud.more = n * 1234
    out = io.BytesIO()
    cloud.write(out, do_compress=True, laz_backend=laspy.LazBackend.Lazrs)
    file = bytearray(out.getvalue())
    start = int.from_bytes(file[96:100], "little")
    record = file.index(b"laszip encoded\0") - 2 + 54
    file[record + 12 : record + 16] = (16).to_bytes(4, "little")
    length = int.from_bytes(file[record - 34 : record - 32], "little")
    out = io.BytesIO(file[:start])
    out.seek(start)
    compressor = lazrs.LasZipCompressor(out, lazrs.LazVlr(np.frombuffer(bytes(file[record : record + length]), "u1")))
    compressor.compress_many(np.frombuffer(cloud.points.array.tobytes(), "u1"))
    compressor.done()
    again = laspy.read(io.BytesIO(out.getvalue()))
    assert (again.points.array == cloud.points.array).all(), fmt
    name = os.path.join(folder, f"format-{fmt}.laz")
    open(name, "wb").write(out.getvalue())
    print(name, len(out.getvalue()), "bytes")
