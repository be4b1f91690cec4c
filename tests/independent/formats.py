"""Every format read by other programs, and compared with the .npy that halfline wrote of the same buffer.

    pip install numpy OpenEXR 'opencv-python-headless<4.11' imageio pypng mmh3
    python tests/independent/formats.py path/to/halfline
"""
import json, os, subprocess, sys, tempfile

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2, imageio.v3, mmh3, numpy as np, OpenEXR, png

halfline = os.path.abspath(sys.argv[1])
scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scenes/weekend.toml")
buffers = "color distance depth normal position id mask certainty bound alpha".split()


def check(what, a, b):
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), what
    print("equal:", what, a.shape, a.dtype)


def render(*arguments, size="160x90"):
    subprocess.run([halfline, "render", scene, "--size", size, "--backend", "cpu", *arguments], check=True)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    asked = ["-o", "all.exr", "--aov", ",".join(buffers), "--aov", ",".join(buffers) + "=all.npz"]
    for name in buffers:
        asked += ["--aov", f"{name}={name}.npy"]
    for file in ["color.png", "mask.png", "depth.png", "normal.png", "color.pfm", "depth.pfm", "depth.raw"]:
        asked += ["--aov", file.split(".")[0] + "=" + file]
    render(*asked)
    render("-o", "clear.png", "--aov", "color=clear.exr", "--bits", "16", "--transparent")

    npy = {name: np.load(name + ".npy") for name in buffers}
    npz = np.load("all.npz")
    assert json.loads(npz["provenance.json"])["halfline:buffers"] == ",".join(buffers)
    for name in buffers:
        check(f"numpy maps {name}.npy", np.load(name + ".npy", mmap_mode="r"), npy[name])
        check(f"numpy reads {name} of .npz", npz[name], npy[name])

    exr = {name: channel.pixels for name, channel in OpenEXR.File("all.exr", separate_channels=True).channels().items()}
    layers = {"depth": ["Z"], "color": "RGB", "alpha": "A"}
    layers |= {name: [f"{name}.{axis}" for axis in "XYZ"] for name in ["normal", "position"]}
    for name in buffers:
        single = npy[name].view("u4") if name == "id" else npy[name].astype("u4" if name == "certainty" else "f4")
        pixels = [exr[channel] for channel in layers.get(name, [name])]
        check(f"OpenEXR reads {name}", pixels[0] if len(pixels) == 1 else np.stack(pixels, -1), single)
    check("OpenCV reads colour of .exr", cv2.imread("all.exr", cv2.IMREAD_UNCHANGED)[..., 2::-1], npy["color"])

    check("OpenCV reads color.pfm", cv2.imread("color.pfm", cv2.IMREAD_UNCHANGED)[..., ::-1], npy["color"])
    check("OpenCV reads depth.pfm", cv2.imread("depth.pfm", cv2.IMREAD_UNCHANGED), npy["depth"].astype("f4"))
    check("numpy reads depth.raw", np.fromfile("depth.raw", "<f8").reshape(90, 160), npy["depth"])

    # The ids at the finer pixels that hold the samples, counted; the hash pcg4d of Jarzynski and Olano chooses them.
    render("-o", "mattes.exr", "--cryptomatte", "id", "--samples", "4", size="64x36")
    render("--aov", "id=fine.npy", size="2048x1152")
    y, x = np.indices((36, 64), "u4")
    counts = {}
    for sample in range(4):
        v = [n.copy() * np.uint32(1664525) + np.uint32(1013904223) for n in (x, y, 0 * x + np.uint32(sample), 0 * x)]
        for shift in (True, False):
            for k, (i, j) in enumerate([(1, 3), (2, 0), (0, 1), (1, 2)]):
                v[k] = v[k] + v[i] * v[j]
            if shift:
                v = [n ^ n >> np.uint32(16) for n in v]
        column, row = ((at * 2 + stratum) * 16 + (n >> 16 & 15) for at, stratum, n in [(x, sample % 2, v[0]), (y, sample // 2, v[1])])
        for sphere in np.unique(seen := np.load("fine.npy", mmap_mode="r")[row, column]):
            counts[sphere] = counts.get(sphere, 0) + (seen == sphere)
    mattes = OpenEXR.File("mattes.exr", separate_channels=True)
    manifest = json.loads(mattes.header()["cryptomatte/db78969/manifest"])
    channels = {name: channel.pixels for name, channel in mattes.channels().items()}
    ranks = [(channels[f"CryptoId0{k // 2}.{'RB'[k % 2]}"], channels[f"CryptoId0{k // 2}.{'GA'[k % 2]}"]) for k in range(6)]
    assert sorted(map(int, manifest)) == sorted(sphere for sphere in counts if sphere >= 0)
    for name, number in manifest.items():
        hashed = mmh3.hash(name, 0, signed=False)
        assert int(number, 16) == (hashed ^ 1 << 23 if hashed >> 23 & 255 in (0, 255) else hashed), name
        share = sum(np.where(np.ascontiguousarray(ids).view("u4") == int(number, 16), share, 0) for ids, share in ranks)
        check(f"OpenEXR reads the matte of {name}", share, (counts[int(name)] / 4).astype("f4"))

    def srgb(x, levels):
        x = np.clip(x.astype("f8"), 0, 1)
        encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)
        return np.floor(levels * encoded + 0.5)

    check("imageio reads color.png", imageio.v3.imread("color.png"), srgb(npy["color"], 255).astype("u1"))
    check("OpenCV reads mask.png", cv2.imread("mask.png", cv2.IMREAD_UNCHANGED), 255 * npy["mask"])
    steps = np.floor(np.where(np.isinf(npy["depth"]), 0, npy["depth"]) / 0.001 + 0.5).astype("u2")
    check("OpenCV reads depth.png", cv2.imread("depth.png", cv2.IMREAD_UNCHANGED), steps)
    grey = (npy["normal"] + np.float32(1)) / np.float32(2) * 255
    assert np.abs(cv2.imread("normal.png")[..., ::-1] - grey).max() <= 0.501
    clear = OpenEXR.File("clear.exr", separate_channels=True).channels()
    rgb, alpha = np.stack([clear[c].pixels for c in "RGB"], -1), clear["A"].pixels[..., None]
    straight = np.where(alpha > 0, rgb / np.maximum(alpha, 1e-9), 0).astype("f4")
    width, height, rows, about = png.Reader("clear.png").read()
    assert about["bitdepth"] == 16 and about["alpha"]
    levels = np.concatenate([srgb(straight, 65535), np.floor(65535 * alpha + 0.5)], -1).astype("u2")
    check("pypng reads clear.png", np.array([list(row) for row in rows], "u2").reshape(height, width, 4), levels)
