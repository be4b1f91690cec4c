#!/usr/bin/env python3
"""A stand-in for the server of `halfline view`: the same messages, with discs in place of spheres. Standard library only.

    mock.py [--port N] [--ms-per-megapixel N]

prints the URL. The fields of `Mock` let `drive.py` slow it down, make it refuse, and read what it was asked."""

import argparse
import json
import math
import pathlib
import secrets
import struct
import threading
import time
import zlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parent.parent / "page"
TYPES = {".html": "text/html; charset=utf-8", ".css": "text/css", ".js": "text/javascript"}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
LEGEND = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="198" height="{height}" font-family="sans-serif" font-size="12">'
    '<text x="24" y="36" font-weight="bold">{title}</text>{rows}</svg>'
)
COLOURS = [(214, 92, 64), (72, 128, 200), (92, 168, 96), (216, 176, 72), (150, 104, 180)]
NAMES = ["O", "N", "C", "S", "P"]
BACKGROUND = (244, 245, 247)
CELL = 10.0
FRAMES = 100
CONTROLS = [
    {"id": "color_by", "label": "Colour by", "help": "A column", "value": "", "values": ["", "element", "charge", "mass"]},
    {"id": "map", "label": "Colour map", "help": "A map", "value": "", "values": ["", "viridis", "turbo"]},
    {"id": "opacity", "label": "Opacity", "help": "A share", "type": "range", "value": "1", "min": 0.05, "max": 1, "step": 0.05, "others": True},
    {"id": "layers", "label": "Layers seen through", "help": "A number", "type": "number", "value": "1", "min": 1, "max": 64},
    {"id": "background", "label": "Background", "help": "A colour", "type": "color", "value": "#f4f5f7"},
    {"id": "look", "label": "Look", "help": "A look", "value": "soft", "values": ["plain", "soft", "figure"]},
    {"id": "samples", "label": "Samples", "help": "A number", "value": "", "values": ["", "1", "4", "16"]},
    {"id": "cut", "label": "Planes", "help": "Planes", "value": "clip", "values": ["clip", "cut"], "renames": "clip"},
    *(
        {"id": "clip", "label": f"{axis} {end}", "help": "A plane", "type": "range", "value": value, "min": 0, "max": 10, "step": 0.1,
         "plane": [sign * (axis == name) for name in "xyz"]}
        for axis in "xyz"
        for end, value, sign in (("from", 0, -1), ("to", 10, 1))
    ),
]


def legend(title, names):
    rows = "".join(
        f'<circle cx="32" cy="{54 + 18 * i}" r="6" fill="rgb{COLOURS[NAMES.index(n)]}"/><text x="46" y="{58 + 18 * i}">{n}</text>'
        for i, n in enumerate(names)
    )
    return LEGEND.format(height=78 + 18 * len(names), title=title, rows=rows)


def png(width, height, levels):
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    stride = 3 * width
    rows = b"".join(b"\0" + bytes(levels[stride * y : stride * (y + 1)]) for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    n = math.sqrt(dot(a, a))
    return [x / n for x in a]


class View:
    """The camera in the renderer's sense, written apart from camera.js."""

    def __init__(self, camera, size):
        self.eye, self.size = camera["eye"], size
        self.w = unit(minus(camera["at"], camera["eye"]))
        self.u = unit(cross(self.w, camera["up"]))
        self.v = cross(self.u, self.w)
        self.distance = math.sqrt(dot(minus(camera["at"], camera["eye"]), minus(camera["at"], camera["eye"])))
        if ("height" in camera) == ("vfov" in camera):
            raise Refusal("settings", "a camera has vfov or height")
        self.flat = camera.get("height")
        self.tan = None if self.flat else math.tan(math.radians(camera["vfov"]) / 2)

    def unit_at(self, depth):
        return (self.flat if self.flat else 2 * depth * self.tan) / self.size[1]

    def project(self, p):
        d = minus(p, self.eye)
        depth = dot(d, self.w)
        if depth <= 0:
            return None
        k = self.unit_at(depth)
        return self.size[0] / 2 + dot(d, self.u) / k, self.size[1] / 2 - dot(d, self.v) / k, depth, k


class Refusal(Exception):
    def __init__(self, kind, message, exit=2):
        super().__init__(message)
        self.error = {"error": {"kind": kind, "message": message, "exit": exit}}


# The number of a request for a picture that is saved.
SAVED = 2**53 - 1


class Mock:
    def __init__(self, ms_per_megapixel=0):
        self.token = secrets.token_hex(16)
        self.ms_per_megapixel = ms_per_megapixel
        self.still_ms = 0  # added to a still, which may be given up meanwhile
        self.loading = 0  # so many answers of /progress say "loading"
        self.refuse_frames = None  # the message of a 400
        self.drop = False  # closes every connection: the server has ended
        self.skip_stills = 0  # so many stills are answered 204 without a newer one
        self.film = True  # False: a single picture; None: the number of frames is not known
        self.counted = False  # whether it is known meanwhile
        self.first = 1
        self.flat = False  # pictures without discs, which cost nothing
        self.lock, self.turn = threading.Lock(), threading.Lock()
        self.blank = {}
        self.newest, self.now, self.most, self.log, self.superseded = 0, 0, 0, [], 0
        self.spheres = [
            ([x * 2.0 + 1, y * 2.0 + 1, z * 2.0 + 1], 0.35 + 0.09 * ((x + 2 * y + 3 * z) % 5), (x + y + z) % 5)
            for x in range(5)
            for y in range(5)
            for z in range(5)
        ]

    def sphere(self, i, frame):
        c, r, kind = self.spheres[i]
        a = 2 * math.pi * ((frame or 1) - 1) / FRAMES
        return [c[0] + 0.6 * math.sin(a + i), c[1], c[2] + 0.6 * (math.cos(a + i) - math.cos(i))], r, kind

    def is_cut(self, center, options):
        planes = (list(map(float, text.split(","))) for text in [*options.get("clip", []), *options.get("cut", [])])
        return any(dot(plane[:3], center) > plane[3] for plane in planes)

    def chosen(self, expr):
        """Selections of the mock: `NAME`, or `id<N`."""
        if not expr:
            return None
        if expr in NAMES:
            return {i for i, s in enumerate(self.spheres) if NAMES[s[2]] == expr}
        if expr.startswith("id<") and expr[3:].isdigit():
            return set(range(min(int(expr[3:]), len(self.spheres))))
        raise Refusal("settings", f"--select {expr}: column 1: '{expr.split()[0]}' is not a column of the file")

    def scene(self, _):
        names = NAMES
        return {
            "schema": 1, "version": "0.0.0", "file": "lattice.xyz", "format": "xyz", "count": len(self.spheres),
            "frames": None if self.film is None else FRAMES if self.film else 1, "frame": self.first, "first": 1,
            "cell": [[CELL, 0, 0], [0, CELL, 0], [0, 0, CELL]], "extent": [[0, 0, 0], [CELL] * 3],
            "center": [5.0, 5.0, 5.0], "radius": 8.2, "columns": {"element": {"type": "name"}, "charge": {"type": "number"}},
            "camera": {"eye": [20.5, -14.25, 13.0], "at": [5, 5, 5], "up": [0, 0, 1], "vfov": 40},
            "look": "soft", "controls": CONTROLS, "samples": 4, "size": [800, 600], "background": "#f4f5f7",
            "selects": True, "legend": legend("element", names), "warnings": ["3 spheres have no radius in the file: 1.5 is used"],
        }

    def visible(self, body):
        view = View(body["camera"], body["size"])
        found = []
        for i in range(len(self.spheres)):
            c, r, kind = self.sphere(i, body.get("frame"))
            p = view.project(c)
            if p and not self.is_cut(c, body.get("options", {})):
                found.append((p[2], i, p[0], p[1], r / p[3], kind, c, r))
        return view, sorted(found, reverse=True)

    def frame(self, body):
        """None for 204, else the picture and its information."""
        still = body["mode"] == "still"
        with self.lock:
            # A picture that is saved supersedes none but those before it.
            if body["seq"] < SAVED:
                self.newest = max(self.newest, body["seq"])
            self.now += 1
            self.most = max(self.most, self.now)
            self.log.append(body)
        try:
            with self.turn:
                return self.render(body, still)
        finally:
            with self.lock:
                self.now -= 1

    def render(self, body, still):
        begun = time.perf_counter()
        if self.refuse_frames:
            raise Refusal("accuracy", self.refuse_frames, 7)
        if (body.get("frame") or 1) > FRAMES:
            raise Refusal("settings", f"frame {body['frame']}: the file has {FRAMES} frames")
        if still and self.skip_stills:
            self.skip_stills -= 1
            return None
        if self.newest > body["seq"]:
            self.superseded += 1
            return None
        width, height = body["size"]
        picked = self.chosen(body.get("select"))
        self.check(body.get("options", {}))
        view, order = self.visible(body)
        background = bytes.fromhex(body.get("options", {}).get("background", ["#" + bytes(BACKGROUND).hex()])[0][1:])
        levels = bytearray(background * (width * height))
        for _, i, x, y, r, kind, _, _ in [] if self.flat else order:
            colour = COLOURS[kind] if picked is None or i in picked else (188, 188, 190)
            for scale, light in ((1.0, 0.55), (0.93, 0.9), (0.5, 1.0), (0.25, 1.12)):
                row = bytes(min(255, int(v * light)) for v in colour)
                cx, cy, q = x - (1 - scale) * 0.35 * r, y - (1 - scale) * 0.35 * r, r * scale
                for line in range(max(0, math.ceil(cy - q - 0.5)), min(height, math.floor(cy + q + 0.5))):
                    half = q * q - (line + 0.5 - cy) ** 2
                    if half <= 0:
                        continue
                    half = math.sqrt(half)
                    a, b = max(0, round(cx - half)), min(width, round(cx + half))
                    if b > a:
                        at = 3 * (line * width + a)
                        levels[at : at + 3 * (b - a)] = row * (b - a)
        wait = self.ms_per_megapixel * width * height / 1e6 + (self.still_ms if still else 0)
        until = begun + wait / 1000
        while time.perf_counter() < until:
            if still and self.newest > body["seq"]:
                self.superseded += 1
                return None
            time.sleep(0.005)
        picture = self.blank.get((width, height)) if self.flat else None
        if not picture:
            picture = png(width, height, levels)
        if self.flat:
            self.blank[width, height] = picture
        info = {
            "frames": FRAMES if self.film is None and self.counted else None, "seq": body["seq"], "ms": (time.perf_counter() - begun) * 1000, "accuracy": "certified", "certified": 1.0 if still else 0.99987, "settled": 1204,
            "unit": view.unit_at(view.distance), "adapter": "llvmpipe", "look": body.get("options", {}).get("look", ["soft"])[0],
            "samples": 4, "warnings": [],
        }
        return picture, info

    def check(self, options):
        if options.get("color_by") == ["mass"]:
            raise Refusal("settings", "the file has no column mass to colour by; the file has element, charge")

    def fit(self, body):
        """The camera of the scene's whole ball, in the same direction."""
        camera = dict(body["camera"])
        back = unit(minus(camera["eye"], camera["at"]))
        aspect = min(1, body["size"][0] / body["size"][1])
        half = aspect * math.tan(math.radians(camera.get("vfov", 40)) / 2)
        distance = 8.61 / math.sin(math.atan(half))
        camera["at"] = [5.0, 5.0, 5.0]
        camera["eye"] = [5.0 + distance * x for x in back]
        if "height" in camera:
            camera["height"] = 17.22 / aspect
        return {"camera": camera}

    def pick(self, body):
        view, order = self.visible(body)
        x, y = body["x"] + 0.5, body["y"] + 0.5
        for depth, i, cx, cy, r, kind, c, radius in reversed(order):
            if (x - cx) ** 2 + (y - cy) ** 2 >= r * r:
                continue
            distance = depth - radius
            hit = [e + distance * w for e, w in zip(view.eye, unit(minus(c, view.eye)))]
            answer = {
                "id": i, "row": i, "center": c, "radius": radius, "position": hit, "distance": distance, "certainty": "certified",
                "columns": {"element": NAMES[kind], "charge": round(0.37 * i - 9, 3)}, "from": None,
            }
            if body.get("from") is not None:
                d = minus(c, self.sphere(body["from"], body.get("frame"))[0])
                wrapped = [v - CELL * round(v / CELL) for v in d]
                answer["from"] = {"id": body["from"], "distance": math.sqrt(dot(d, d)), "minimum_image": math.sqrt(dot(wrapped, wrapped))}
            return answer
        return None

    def select(self, body):
        self.check(body["options"])
        found = self.chosen(body["expr"])
        if found is None:
            found = set(range(len(self.spheres)))
        names = [n for i, n in enumerate(NAMES) if any(self.spheres[j][2] == i for j in found)]
        title = body["expr"] or body["options"].get("color_by", ["element"])[0]
        return {"count": len(found), "of": len(self.spheres), "legend": legend(title, names)}

    def command(self, body):
        words = [f"halfline render lattice.xyz --eye {','.join(map(str, body['camera']['eye']))}", f"--size {body['size'][0]}x{body['size'][1]}"]
        if body.get("select"):
            words.append(f"--select '{body['select']}'")
        words += [f"--{name} {value}" for name, values in body["options"].items() for value in values]
        return {"shell": " ".join(words) + " -o x.png", "python": f"import halfline as hl\n# {json.dumps(body['camera'])}\n"}

    def progress(self, _):
        if self.loading:
            self.loading -= 1
            time.sleep(0.15)
            return {"state": "loading", "text": "Reading lattice.xyz, 40 %"}
        return {"state": "ready", "text": ""}

    def joined(self):
        """The page's modules as the widget has them: one module."""
        parts = []
        for name in ("camera.js", "view.js", "widget.js"):
            lines = [s for s in (PAGE / name).read_text().splitlines() if not s.startswith("import ")]
            parts += [s.removeprefix("export ") if name != "widget.js" else s for s in lines]
        return "\n".join(parts) + "\n"


def handler(mock):
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def log_message(self, *_):
            pass

        def answer(self, status, body=b"", kind="application/json", **headers):
            self.send_response(status)
            self.send_header("Content-Length", str(len(body)))
            if body:
                self.send_header("Content-Type", kind)
            self.send_header("Content-Security-Policy", POLICY)
            self.send_header("X-Content-Type-Options", "nosniff")
            self.send_header("Cache-Control", "no-store")
            for key, value in headers.items():
                self.send_header(key.replace("_", "-"), value)
            self.end_headers()
            try:
                self.wfile.write(body)
            except OSError:
                pass

        def do_GET(self):
            name = self.path.split("?")[0].lstrip("/") or "index.html"
            if name == "favicon.ico":
                return self.answer(204)
            if name == "joined.js":
                return self.answer(200, mock.joined().encode(), TYPES[".js"])
            for folder in (PAGE, HERE):
                path = folder / name
                if "/" not in name and path.suffix in TYPES and path.is_file():
                    return self.answer(200, path.read_bytes(), TYPES[path.suffix])
            self.answer(404, json.dumps(Refusal("settings", "no such file").error).encode())

        def do_POST(self):
            body = json.loads(self.rfile.read(int(self.headers.get("Content-Length", 0))) or b"{}")
            if mock.drop:
                self.close_connection = True
                return self.connection.close()
            if self.headers.get("Authorization") != f"Bearer {mock.token}":
                return self.answer(403, json.dumps(Refusal("settings", "the token is wrong: open the printed address").error).encode())
            route = self.path.lstrip("/")
            if route not in ("scene", "frame", "pick", "select", "fit", "command", "progress"):
                return self.answer(404, json.dumps(Refusal("settings", "no such route").error).encode())
            try:
                result = getattr(mock, route)(body)
            except Refusal as refusal:
                return self.answer(400, json.dumps(refusal.error).encode())
            if route != "frame":
                return self.answer(200, json.dumps(result).encode())
            if result is None:
                return self.answer(204)
            self.answer(200, result[0], "image/png", X_Halfline=json.dumps(result[1]))

    return Handler


def serve(mock, port=0):
    server = ThreadingHTTPServer(("127.0.0.1", port), handler(mock))
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_address[1]}/#{mock.token}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--ms-per-megapixel", type=float, default=0)
    settings = parser.parse_args()
    print(serve(Mock(settings.ms_per_megapixel), settings.port), flush=True)
    threading.Event().wait()
