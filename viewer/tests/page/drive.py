#!/usr/bin/env python3
"""Drives the page of `halfline view` in Chromium by real pointer, wheel, key and touch events, and checks what it does.

    drive.py [--url URL] [--shots FOLDER] [--only WORD]

Without --url it starts mock.py; some checks need that. Prints a line per check; exits 1 if one fails, 77 without Chromium."""

import argparse
import contextlib
import json
import math
import pathlib
import sys
import tempfile
import time

import browser
import mock

HERE = pathlib.Path(__file__).resolve().parent
VIEW = "document.querySelector('.halfline-view').halfline"
STILL = f"{VIEW}.still().then(() => {VIEW}.stats.frames)"
SHIFT = 8
MOCK = dict(ms_per_megapixel=0, still_ms=0, loading=0, refuse_frames=None, drop=False, skip_stills=0, film=True, counted=False, first=1, flat=False)


def text(selector):
    return f"(document.querySelector('.halfline-view {selector}')?.innerText ?? '')"


def is_shown(selector):
    return f"Boolean(document.querySelector('.halfline-view {selector}')?.checkVisibility())"


def length(a):
    return math.sqrt(sum(x * x for x in a))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def short(x):
    """A number as the table of picks shows it: 7 digits."""
    return f"{x:.7g}"


def near(a, b, e=1e-4):
    a, b = (v if isinstance(v, list) else [v] for v in (a, b))
    return all(abs(x - y) <= e * max(1, abs(x), abs(y)) for x, y in zip(a, b))


class Run:
    def __init__(self, settings, started):
        self.settings, self.failed, self.number = settings, 0, 0
        self.mock = None if settings.url else mock.Mock()
        self.url = settings.url or mock.serve(self.mock)
        self.browser = started
        self.tab = None

    def check(self, name, ok, detail=""):
        self.number += 1
        self.failed += not ok
        print(f"{'ok' if ok else 'FAILED'}  {name}{'' if ok else f': {detail}'}", flush=True)

    def group(self, name, steps):
        """Runs a function of checks; what it raises is a failed check."""
        if self.settings.only and self.settings.only not in name:
            return
        begun = time.monotonic()
        try:
            steps()
        except (browser.Failed, AssertionError, KeyError, TypeError) as error:
            self.check(name, False, f"{type(error).__name__}: {error}")
        if self.settings.times:
            print(f"    {time.monotonic() - begun:.1f} s", flush=True)

    def shot(self, name, tab=None):
        (tab or self.tab).screenshot(pathlib.Path(self.settings.shots) / f"{name}.png")

    def fresh(self, size=(1000, 700), touch=False, url=None, wait=True, **state):
        """A new tab of the page, at rest."""
        if self.mock:
            for key, value in {**MOCK, **state}.items():
                setattr(self.mock, key, value)
            self.mock.log, self.mock.most, self.mock.superseded = [], 0, 0
        if self.tab:
            self.complaints()
            self.tab.close()
        self.tab = self.browser.open(url or self.url, size, touch)
        if wait:
            self.tab.until(f"Boolean(document.querySelector('.halfline-view')?.halfline)")
            self.tab.js(STILL)
            self.box = self.tab.js("(({x, y, width, height}) => [x, y, width, height])(document.querySelector('.halfline-view canvas').getBoundingClientRect())")
        return self.tab

    def complaints(self):
        found = self.tab.complaints()
        if found:
            self.check("no exception and no breach of the policy", False, found[:3])

    def camera(self):
        return self.tab.js(f"{VIEW}.camera()")

    def at(self, fx, fy):
        """A place of the canvas by shares of its width and height, in whole pixels."""
        x, y, w, h = self.box
        return round(x + fx * w), round(y + fy * h)

    def project(self, point):
        """The pixel of the page where the module has a point."""
        x, y, w, h = self.box
        p = self.tab.js(f"import('/camera.js').then((m) => m.project({VIEW}.camera(), [{w}, {h}], {json.dumps(point)}))")
        return [p[0] + x, p[1] + y]

    def under(self, pixel):
        """The point of the pivot's plane under a pixel of the page."""
        x, y, w, h = self.box
        return self.tab.js(
            f"""import('/camera.js').then((m) => {{
              const c = {VIEW}.camera(), b = m.basis(c), u = m.unitPerPixel(c, [{w}, {h}]);
              return m.plus(m.plus(c.at, b.right, ({pixel[0]} - {x} - {w} / 2) * u), b.up, -({pixel[1]} - {y} - {h} / 2) * u);
            }})"""
        )

    def post(self, route, body):
        return self.tab.js(
            f"""fetch({json.dumps(route)}, {{ method: "POST", headers: {{ Authorization: "Bearer " + location.hash.slice(1) }},
              body: JSON.stringify({json.dumps(body)}) }}).then((r) => r.text()).then((t) => t ? JSON.parse(t) : null)"""
        )

    def size(self):
        return [round(v) for v in self.box[2:]]

    def spheres(self, wanted=2):
        """Places of the page with different spheres, by asking the server: left of the table of picks, right of the legend."""
        found = {}
        for i in range(108):
            pixel = self.at(0.36 + 0.03 * (i * 7 % 9), 0.1 + 0.07 * (i // 9))
            x, y = round(pixel[0] - self.box[0]), round(pixel[1] - self.box[1])
            hit = self.post("/pick", {"camera": self.camera(), "size": self.size(), "select": None, "x": x, "y": y, "from": None, "frame": self.frame()})
            if hit and hit["id"] not in found:
                found[hit["id"]] = (pixel, hit)
            if len(found) == wanted:
                break
        return list(found.values())

    def frame(self):
        slider = self.tab.js("(() => { const s = document.querySelector('.hl-film input'); return s.checkVisibility() ? +s.value : null })()")
        return slider if slider is not None else None

    # The checks.
    def units(self):
        self.fresh()
        for name, ok, detail in self.tab.js((HERE / "camera_check.js").read_text()):
            self.check(f"camera.js: {name}", ok, detail)

    def beginning(self):
        tab = self.tab
        if self.mock:
            tab = self.fresh(wait=False, loading=6)
            tab.until(f"{text('.hl-message')}.includes('40 %')")
            self.check("the text of /progress is shown while the file is read", True)
            self.shot("loading")
            tab.until(f"Boolean({VIEW})")
        else:
            tab = self.fresh()
        tab.js(STILL)
        self.fresh()
        tab = self.tab
        self.check("nothing covers the picture once it is there", not tab.js(is_shown(".hl-message")))
        size = tab.js("(({width, height}) => [width, height])(document.querySelector('canvas'))")
        self.check("the still has the size of the canvas", size == self.size(), (size, self.size()))
        line = tab.js("document.querySelector('.hl-status').textContent")
        self.check("the status line says what the answer says", "certified" in line and f"{size[0]} x {size[1]}" in line and " ms" in line, line)
        if self.mock:
            self.check("certified and settled", line.startswith("✓ certified") and "settled exactly1,204" in line and line.endswith("llvmpipe"), line)
            modes = [(r["mode"], r["size"] == size) for r in self.mock.log]
            self.check("first a whole moving frame, then the still", modes == [("move", True), ("still", True)], modes)
        signature = tab.js(f"{VIEW}.lastStill().arrayBuffer().then((b) => [...new Uint8Array(b).slice(0, 4)])")
        self.check("the last still is a PNG", signature == [0x89, 0x50, 0x4E, 0x47], signature)
        bar = tab.js("(() => { const r = document.querySelector('.hl-rule').getBoundingClientRect().width; return [r, document.querySelector('.hl-scale span').innerText] })()")
        unit = length(minus(self.camera()["eye"], self.camera()["at"])) * 2 * math.tan(math.radians(self.camera().get("vfov", 0)) / 2) / size[1]
        if unit:
            self.check("the scale bar is as long as it says", near(bar[0] * unit, float(bar[1].replace(",", "")), 0.02) and 50 < bar[0] <= 141, (bar, unit))

    def orbit(self):
        tab, before = self.tab, self.camera()
        frames = tab.js(f"{VIEW}.stats.frames")
        tab.drag(self.at(0.4, 0.4), self.at(0.6, 0.5))
        after = self.camera()
        distance = [length(minus(c["eye"], c["at"])) for c in (before, after)]
        self.check("a drag orbits", not near(before["eye"], after["eye"]))
        self.check("an orbit keeps pivot, distance and up", near(before["at"], after["at"]) and near(*distance) and before["up"] == after["up"], (before, after))
        self.check("new frames are drawn", tab.js(STILL) >= frames + 2)
        self.check("the numbers of a moved camera are short", len(json.dumps(after)) < 160, after)
        tab.key("t")
        tab.drag(self.at(0.5, 0.2), self.at(0.5, 0.95))
        free = self.camera()
        self.check("t turns freely", free["up"] != after["up"] and near(length(minus(free["eye"], free["at"])), distance[0]), free)
        tab.key("t")
        tab.drag(self.at(0.3, 0.5), self.at(0.35, 0.5))
        self.check("t again turns about the up direction that is", self.camera()["up"] == free["up"], (free, self.camera()))

    def pans(self):
        tab = self.tab
        for name, button, modifiers in (("right", "right", 0), ("middle", "middle", 0), ("shift", "left", SHIFT)):
            before, a, b = self.camera(), self.at(0.4, 0.4), self.at(0.5, 0.45)
            point = self.under(a)
            tab.drag(a, b, button, modifiers)
            after = self.camera()
            same = near(minus(before["at"], before["eye"]), minus(after["at"], after["eye"]))
            self.check(f"a {name} drag pans with the pointer", same and near(self.project(point), list(b), 1e-3), self.project(point))

    def zooms(self):
        tab = self.tab
        for lens in ("perspective", "orthographic"):
            for delta in (-240, 180):
                place = self.at(0.7, 0.3)
                before, point = self.camera(), self.under(place)
                tab.wheel(*place, delta)
                tab.until(f"JSON.stringify({VIEW}.camera()) !== {json.dumps(json.dumps(before, separators=(',', ':')))}")
                self.check(f"the wheel zooms toward the pointer, {lens}, {delta}", near(self.project(point), list(place), 1e-3), (self.project(point), place))
            tab.key("o")
        place, before = self.at(0.5, 0.5), self.camera()
        tab.wheel(*place, -30, modifiers=2)
        tab.until(f"{VIEW}.camera().eye[0] !== {before['eye'][0]}")
        ratio = length(minus(self.camera()["eye"], self.camera()["at"])) / length(minus(before["eye"], before["at"]))
        self.check("a pinch of a touch pad (wheel with ctrl) zooms", near(ratio, math.exp(-0.3), 0.02), ratio)
        tab.key("f")
        scene = self.post("/scene", {})
        tab.until(f"Math.hypot(...{VIEW}.camera().at.map((x, i) => x - {json.dumps(scene['center'])}[i])) < {scene['radius']}")
        self.check("f fits the scene", True)

    def picks(self):
        tab = self.tab
        (a, first), (b, second) = self.spheres()
        tab.click(*a)
        tab.until(f"{VIEW}.picked().length === 1")
        self.check("a click picks", tab.js(f"{VIEW}.picked()[0]") == first)
        table = tab.js(text(".hl-table"))
        wanted = [str(first["id"]), *map(str, first["columns"])]
        self.check("the table has the answer with all columns", all(w in table for w in wanted) and "certainty" in table, table)
        ring = tab.js("(({x, y, width, height}) => [x + width / 2, y + height / 2])(document.querySelector('.hl-ring').getBoundingClientRect())")
        self.check("a ring is where the sphere was picked", length(minus(ring, list(a))) < 40, (ring, a))
        self.shot("picked")
        time.sleep(0.5)
        tab.click(*b, modifiers=SHIFT)
        tab.until(f"{VIEW}.picked().length === 2")
        answer = tab.js(f"{VIEW}.picked()[1]")
        d = length(minus(first["center"], second["center"]))
        self.check("a shift click gives the distance", answer["id"] == second["id"] and near(answer["from"]["distance"], d), answer)
        table = tab.js(text(".hl-table"))
        image = answer["from"]["minimum_image"]
        shown = f"Distance {short(answer['from']['distance'])}\n" in table + "\n"
        self.check("raw and minimum image are shown, with 7 digits", shown and (image is None or f"minimum image {short(image)}\n" in table + "\n"), table)
        names = tab.js("[...document.querySelectorAll('.hl-table th')].map((h) => h.innerText)")
        self.check("no two rows have one name", len(set(names)) == len(names), names)
        self.shot("distance")
        tab.key("Escape")
        self.check("Esc clears the picks", tab.js(f"{VIEW}.picked().length") == 0 and not tab.js(is_shown(".hl-table")))
        before = self.camera()
        time.sleep(0.5)
        for _ in range(5):  # a busy machine may be too slow for a double click
            tab.click(*a, clicks=2)
            time.sleep(1)
            if self.camera()["at"] != before["at"]:
                break
        after = self.camera()
        self.check("a double click makes the sphere the pivot", near(after["at"], first["center"]) and near(minus(after["eye"], after["at"]), minus(before["eye"], before["at"])), after)
        corner = self.at(0.004, 0.004)
        hit = self.post("/pick", {"camera": after, "size": self.size(), "x": 3, "y": 3, "from": None, "select": None, "frame": self.frame()})
        if hit is None:
            time.sleep(0.5)
            tab.click(*corner)
            tab.until(f"{VIEW}.picked().length === 0")
            self.check("a click beside the spheres clears the pick", True)

    def axes(self):
        tab = self.tab
        for i, letter in enumerate("xyz"):
            for sign, modifiers in ((1, 0), (-1, SHIFT)):
                tab.key(letter.upper() if modifiers else letter, modifiers)
                c = self.camera()
                d = length(minus(c["at"], c["eye"]))
                forward = [v / d for v in minus(c["at"], c["eye"])]
                self.check(f"{'shift ' if modifiers else ''}{letter} looks along the axis", near(forward, [sign if k == i else 0 for k in range(3)]), forward)
        tab.js(STILL)
        up = self.camera()["up"]
        if self.mock:
            self.check("the view along z has another up", abs(up[2]) < 0.1, up)
        tab.drag(self.at(0.5, 0.5), self.at(0.5, 0.4))
        if self.mock:
            self.check("a drag from there turns about z again", self.camera()["up"] == [0, 0, 1], self.camera())

    def lenses(self):
        tab = self.fresh()
        before, place = self.camera(), self.at(0.2, 0.7)
        point = self.under(place)
        tab.key("o")
        flat = self.camera()
        self.check("o is orthographic, with the size at the pivot kept", "height" in flat and "vfov" not in flat and near(self.project(point), list(place), 1e-3), flat)
        tab.js(STILL)
        tab.key("o")
        after = self.camera()
        self.check("o again comes back", "height" not in after and near(before["eye"], after["eye"]) and before["vfov"] == after["vfov"], after)

    def selects(self):
        tab = self.tab
        expr, wrong = ("S", "Z > 1") if self.mock else (self.settings.select, "no such thing ==")
        tab.key("/")
        self.check("/ goes to the selection", tab.js("document.activeElement === document.querySelector('.hl-select input')"))
        camera = self.camera()
        tab.write(wrong)
        self.check("letters in the input are no keys", self.camera() == camera and tab.js("document.querySelector('.hl-select input').value") == wrong)
        tab.key("Enter")
        tab.until(f"{text('.hl-note.hl-error')} !== ''")
        tab.js(STILL)
        self.check("an error of the selection stays over the picture", tab.js(f"{VIEW}.selection()") == "" and tab.js(is_shown(".hl-note.hl-error")), tab.js(text(".hl-note")))
        self.shot("refused")
        tab.js("document.querySelector('.hl-select input').value = ''")
        tab.write(expr)
        tab.key("Enter")
        tab.until(f"{VIEW}.selection() === {json.dumps(expr)}")
        said = self.post("/select", {"expr": expr, "frame": self.frame(), "options": {}})
        self.check("the count is shown", tab.js(text(".hl-select output")).replace(",", "") == f"{said['count']} of {said['of']}" and not tab.js(is_shown(".hl-error")), tab.js(text(".hl-select output")))
        tab.js(STILL)
        if self.mock:
            self.check("the selection is in the frames", self.mock.log[-1]["select"] == expr and self.mock.log[-1]["mode"] == "still")
        self.shot("selected")
        tab.key("Escape")
        tab.until(f"{VIEW}.selection() === ''")
        self.check("Esc clears the selection", tab.js("document.querySelector('.hl-select input').value") == "")
        tab.js(STILL)

    def copies(self):
        tab = self.tab
        tab.key("x")
        body = {"camera": self.camera(), "size": self.size(), "frame": self.frame(), "select": None, "options": {}, "mode": "still"}
        answer = self.post("/command", body)
        origin = self.url.split("#")[0].rstrip("/")
        permit = lambda setting: [
            self.browser.call("Browser.setPermission", permission={"name": name}, setting=setting, origin=origin) for name in ("clipboard-read", "clipboard-write")
        ]
        permit("granted")
        tab.call("Page.bringToFront")
        for key, kind in (("c", "shell"), ("p", "python")):
            tab.js("navigator.clipboard.writeText('nothing')")
            tab.key(key)
            tab.until("navigator.clipboard.readText().then((t) => t !== 'nothing')")
            copied = tab.js("navigator.clipboard.readText()")
            self.check(f"{key} copies the {kind} of /command", copied == answer[kind], (copied, answer[kind]))
        self.check("a note says so", "copied" in tab.js(text(".hl-note")))
        permit("denied")
        for key, kind in (("c", "shell"), ("p", "python")):
            tab.key(key)
            tab.until(is_shown(".hl-dialog textarea"))
            chosen = tab.js("(() => { const t = document.activeElement; return t.value.slice(t.selectionStart, t.selectionEnd) })()")
            self.check(f"without a clipboard the {kind} is there, selected", chosen == answer[kind], chosen)
            if kind == "shell":
                self.shot("clipboard-refused")
            tab.key("Escape")
            self.check("Esc closes it", not tab.js(is_shown(".hl-dialog")))
        self.browser.call("Browser.resetPermissions")

    def downloaded(self, folder, pattern, limit):
        """The files with these names in a folder, once there are some, and after so many seconds at the latest."""
        end = time.monotonic() + limit
        while not (files := list(pathlib.Path(folder).glob(pattern))) and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(0.2)
        return files

    def saves(self):
        tab = self.tab
        with tempfile.TemporaryDirectory() as folder:
            self.browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=folder)
            tab.js(STILL)
            still = bytes(tab.js(f"{VIEW}.lastStill().arrayBuffer().then((b) => [...new Uint8Array(b)])"))
            tab.key("s")
            files = self.downloaded(folder, "*.png", 20)
            self.check("s saves the bytes of the still", bool(files) and files[0].read_bytes() == still, files)
            tab.js("[...document.querySelectorAll('.hl-buttons button')].find((b) => b.innerText === 'Save').click()")
            self.shot("save")
            tab.js("document.querySelectorAll('.hl-choices button')[1].click()")
            files = self.downloaded(folder, "*-2x.png", 60)
            size = [int.from_bytes(files[0].read_bytes()[at : at + 4], "big") for at in (16, 20)] if files else None
            self.check("twice the size is saved", size == [2 * side for side in self.size()], size)
            if self.mock:
                self.check("with the legend", self.mock.log[-1]["options"].get("legend_in") == ["right"], self.mock.log[-1])
            tab.js("[...document.querySelectorAll('.hl-buttons button')].find((b) => b.innerText === 'Save').click()")
            tab.js("[...document.querySelectorAll('.hl-choices button')].find((b) => b.innerText === 'SVG').click()")
            files = self.downloaded(folder, "*.svg", 60)
            if self.mock:
                self.check("a figure is asked for", bool(files) and self.mock.log[-1]["mode"] == "svg", self.mock.log[-1])
            else:
                self.check("a figure is saved", bool(files) and files[0].read_bytes().startswith(b"<svg"), files)
            self.check("nothing remains of it", not tab.js(is_shown(".hl-dialog")) and not tab.js(is_shown(".hl-error")))

    def helps(self):
        tab = self.tab
        tab.key("?", SHIFT)
        tab.until(is_shown(".hl-dialog"))
        keys = tab.js("[...document.querySelectorAll('.hl-dialog kbd')].map((k) => k.innerText)")
        self.check("? shows the keys", len(keys) >= 14, keys)
        self.shot("help")
        tab.key("Escape")
        self.check("Esc closes the help", not tab.js(is_shown(".hl-dialog")))
        names = tab.js("[...document.querySelectorAll('button, input, select')].filter((b) => !b.title && !b.getAttribute('aria-label') && b.checkVisibility() && !b.innerText).length")
        self.check("every control has a name", names == 0, names)

    def field(self, label, value=None):
        """The value of a control, after it was set as a hand sets it."""
        change = "" if value is None else f"f.value = {json.dumps(str(value))}; f.dispatchEvent(new Event('input'));"
        return self.tab.js(
            f"""(() => {{
              const label = [...document.querySelectorAll('.hl-controls label')].find((l) => l.innerText.startsWith({json.dumps(label)}));
              const f = label.querySelector('input, select'); {change} return f.value;
            }})()"""
        )

    def controls(self):
        tab = self.fresh()
        rows = self.post("/scene", {})["controls"]
        tab.key("v")
        tab.until(is_shown(".hl-controls"))
        labels = tab.js("[...document.querySelectorAll('.hl-controls label')].map((l) => l.firstChild.textContent)")
        self.check("v shows a row for each control", labels == [row["label"] for row in rows], labels)
        begun = [self.field(label) for label in labels]
        self.check("rows begin with the values of the scene", all(float(a) == float(row["value"]) if row.get("type") in ("range", "number") else a == row["value"] for a, row in zip(begun, rows)), begun)
        self.shot("controls")
        first, legend = tab.js(f"{VIEW}.stats.frames"), tab.js("document.querySelector('.hl-legend img').src")
        column = "charge" if self.mock else "species" if "species" in self.post("/scene", {})["columns"] else "element"
        high = next(row for row in rows if row["label"] == "x to")
        cut = high["min"] + 0.5 * (high["max"] - high["min"])
        changes = {"Colour by": column, "Colour map": "turbo" if self.mock else "", "Opacity": "0.5", "Layers": "2", "Background": "#204060",
                   "Look": "plain", "Samples": "4", "x from": next(row for row in rows if row["label"] == "x from")["min"] + 1, "x to": cut}
        values = {label: self.field(label, value) for label, value in changes.items()}
        tab.js(STILL)
        plane = float(values["x to"])
        expected = {"color_by": [column], **({"map": ["turbo"]} if self.mock else {}), "opacity": ["0.5"], "layers": ["2"], "background": ["#204060"], "look": ["plain"],
                    "samples": ["4"]}
        body = {"camera": self.camera(), "size": self.size(), "frame": self.frame(), "select": None, "mode": "still",
                "options": {**expected, "clip": [f"-1,0,0,{-float(values['x from']):g}", f"1,0,0,{plane:g}"]}}
        if self.mock:
            self.check("the values are in the requests", self.mock.log[-1]["options"] == body["options"], self.mock.log[-1]["options"])
        still = bytes(tab.js(f"{VIEW}.lastStill().arrayBuffer().then((b) => [...new Uint8Array(b)])"))
        asked = bytes(
            tab.js(
                f"""fetch("/frame", {{ method: "POST", headers: {{ Authorization: "Bearer " + location.hash.slice(1) }},
                  body: JSON.stringify({json.dumps({**body, 'seq': self.mock.log[-1]['seq'] if self.mock else 0})}) }}).then((r) => r.arrayBuffer()).then((b) => [...new Uint8Array(b)])"""
            )
        )
        self.check("the still has these options", still == asked and tab.js(f"{VIEW}.stats.frames") > first, (len(still), len(asked)))
        tab.until(f"document.querySelector('.hl-legend img').src !== {json.dumps(legend)}")
        self.check("the legend shows the column", column in tab.js("decodeURIComponent(document.querySelector('.hl-legend img').src)"))
        copied = self.post("/command", body)["shell"]
        self.check("the copied command has them", all(word in copied for word in ("color", column, "204060", f"{plane:g}")), copied)
        self.shot("controls-set")
        # Spheres that are cut off are picked no more.
        pixel = self.post("/pick", {**body, "x": self.size()[0] // 2, "y": self.size()[1] // 2, "from": None})
        self.check("a pick does not see what is cut off", pixel is None or pixel["center"][0] <= plane, pixel)
        # The same planes cut spheres.
        self.field("Planes", "cut")
        tab.js(STILL)
        planes = body["options"]["clip"]
        cut = {**body, "options": {**expected, "cut": planes}}
        if self.mock:
            self.check("the planes cut in the requests", self.mock.log[-1]["options"] == cut["options"], self.mock.log[-1]["options"])
        else:
            pixel = self.post("/pick", {**cut, "x": self.size()[0] // 2, "y": self.size()[1] // 2, "from": None})
            self.check("a pick sees what planes leave", pixel is None or pixel["position"][0] <= plane + 1e-3, pixel)
            copied = self.post("/command", cut)["shell"]
            self.check("the copied command cuts", f"--cut=1,0,0,{plane:g}" in copied and "--clip" not in copied, copied)
            self.shot("controls-cut")
        self.field("Planes", "clip")
        tab.js(STILL)
        expr = "S" if self.mock else self.settings.select
        tab.js(f"{VIEW}.select({json.dumps(expr)})")
        tab.until(f"{VIEW}.selection() === {json.dumps(expr)}")
        tab.js(STILL)
        if self.mock:
            self.check("with a selection the opacity applies to the others", self.mock.log[-1]["options"]["opacity"] == [f"not ({expr})=0.5"], self.mock.log[-1])
        tab.js(f"{VIEW}.select('')")
        tab.until(f"{VIEW}.selection() === ''")
        tab.js("[...document.querySelectorAll('.hl-controls button')].find((b) => b.innerText === 'Reset').click()")
        tab.js(STILL)
        self.check("Reset brings the values of the beginning", [self.field(label) for label in labels] == begun)
        self.field("Background", "#204060")
        self.field("Background", begun[labels.index("Background")])
        tab.js(STILL)
        if self.mock:
            self.check("and asks for no options", self.mock.log[-1]["options"] == {} and self.mock.log[-1]["mode"] == "still", self.mock.log[-1])
        tab.js(f"[...document.querySelectorAll('.hl-controls button')].at(-2).focus()")
        tab.key("v")
        self.check("v hides them", not tab.js(is_shown(".hl-controls")))
        if self.mock:
            tab.key("v")
            self.field("Colour by", "mass")
            tab.until(f"{text('.hl-note.hl-error')}.includes('mass')")
            self.check("the message of a column that is none is shown", True)
            self.field("Colour by", "element")
            tab.js(STILL)
            self.check("and goes with the next value", not tab.js(is_shown(".hl-error")))

    def turns(self):
        tab = self.fresh(film=False) if self.mock else self.fresh()
        for key, modifiers, axis in (("ArrowUp", 0, 1), ("ArrowDown", 0, 1), ("ArrowLeft", SHIFT, 0), ("ArrowRight", SHIFT, 0)):
            before = self.camera()
            tab.key(key, modifiers)
            after = self.camera()
            a, b = (minus(c["eye"], c["at"]) for c in (before, after))
            up = before["up"]
            height = [sum(x * y for x, y in zip(v, up)) / length(v) / length(up) for v in (a, b)]
            flat = [minus(v, [x * h * length(v) / length(up) for x in up]) for v, h in zip((a, b), height)]
            turned = math.degrees(math.acos(max(-1, min(1, sum(x * y for x, y in zip(*flat)) / length(flat[0]) / length(flat[1])))))
            risen = math.degrees(math.asin(height[1]) - math.asin(height[0]))
            found = abs(risen) if axis else turned
            self.check(f"{key} turns by 15 degrees", near(found, 15, 1e-3) and near(length(a), length(b)) and near(before["at"], after["at"]), (turned, risen))
        if self.mock:
            before = self.camera()
            tab.key("ArrowLeft")
            self.check("without frames the arrows to the sides turn too", self.camera()["eye"] != before["eye"])
            tab = self.fresh()
            before = self.camera()
            tab.key("ArrowRight")
            self.check("with frames they step", self.camera() == before and tab.js(text(".hl-film output")) == "2 / 100")

    def is_above(self, selector):
        """Whether nothing lies over an element at nine of its places, and none of them is beside the window."""
        return self.tab.js(
            f"""(() => {{
              const e = document.querySelector('{selector}'), r = e.getBoundingClientRect(), shares = [0.02, 0.5, 0.98];
              e.style.pointerEvents = 'auto';
              const seen = shares.every((x) => shares.every((y) => e.contains(document.elementFromPoint(r.left + x * r.width, r.top + y * r.height))));
              e.style.pointerEvents = '';
              return seen;
            }})()"""
        )

    def phones(self):
        """A phone: 390 x 844, with fingers."""
        tab = self.fresh(size=(390, 844), touch=True)
        self.check("the pointer is a finger", tab.js("matchMedia('(pointer: coarse)').matches"))
        tab.js("[...document.querySelectorAll('.hl-buttons button')][0].click()")
        tab.js("document.querySelector('.hl-warnings').open = true")
        tab.until(is_shown(".hl-controls"))
        tab.js(STILL)
        self.shot("phone-controls")
        small = tab.js(
            """[...document.querySelectorAll('.halfline-view *')].filter((e) => e.checkVisibility() && [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()))
              .filter((e) => parseFloat(getComputedStyle(e).fontSize) < 12).map((e) => e.className || e.tagName)"""
        )
        self.check("text has 12 px at least", small == [], small)
        sizes = tab.js(
            """[...document.querySelectorAll('.halfline-view :is(button, select, input, summary)')].filter((e) => e.checkVisibility())
              .map((e) => [e.innerText || e.type, e.getBoundingClientRect().width, e.getBoundingClientRect().height]).filter(([, w, h]) => w < 40 || h < 40)"""
        )
        self.check("what a finger touches has 40 px at least", sizes == [], sizes)
        over = tab.js("[...document.querySelectorAll('.hl-bar *, .hl-film *, .hl-foot *, .hl-sides, .hl-legend')].filter((e) => e.checkVisibility()).map((e) => e.getBoundingClientRect()).filter((r) => r.left < 0 || r.right > innerWidth + 1).length")
        beside = tab.js("document.querySelector('.hl-controls').scrollWidth - document.querySelector('.hl-controls').clientWidth")
        self.check("the rows of the controls fit their width", beside == 0, beside)
        self.check("nothing lies beside the screen", over == 0 and tab.js("document.scrollingElement.scrollWidth") <= 390, over)
        share = tab.js("document.querySelector('.hl-sides').getBoundingClientRect().height / document.querySelector('.hl-stage').getBoundingClientRect().height")
        self.check("the controls leave half of the picture", share <= 0.5, share)
        scale = tab.js("(({width, naturalWidth}) => width / naturalWidth)(document.querySelector('.hl-legend img'))")
        self.check("the legend has its own size", near(scale, 1, 0.01), scale)
        tab.js(f"{VIEW}.select('Z > 1')")
        tab.until(is_shown(".hl-error"))
        self.check("an error lies above the controls", self.is_above(".hl-error"))
        self.shot("phone-error")
        tab.js("document.querySelector('.hl-legend summary').click()")
        self.check("the legend closes", not tab.js("document.querySelector('.hl-legend img').checkVisibility()"))
        tab.js("document.querySelector('.hl-controls header button:last-child').click()")
        self.check("the controls close", not tab.js(is_shown(".hl-controls")))
        width = tab.js("document.querySelector('.hl-film input').getBoundingClientRect().width")
        self.check("the film bar is as wide as a finger needs", width >= 120, width)
        self.shot("phone")
        tab = self.fresh(size=(700, 500))
        tab.key("v")
        tab.js(f"{VIEW}.select('Z > 1')")
        tab.until(is_shown(".hl-error"))
        self.check("at 700 px nothing hides an error", self.is_above(".hl-error"))
        self.shot("700-error")

    def films(self):
        tab = self.fresh()
        shown = lambda: tab.js(text(".hl-film output"))
        self.check("the number of the frame is shown", shown() == "1 / 100", shown())
        tab.key("ArrowRight")
        tab.key("ArrowRight")
        tab.key("ArrowLeft")
        self.check("the arrows step", shown() == "2 / 100", shown())
        tab.js(STILL)
        self.check("the frame is in the requests", self.mock.log[-1]["frame"] == 2 and self.mock.log[-1]["mode"] == "still")
        tab.js("(() => { const s = document.querySelector('.hl-film input'); s.value = 40; s.dispatchEvent(new Event('input')); })()")
        self.check("the slider goes to a frame", shown() == "40 / 100", shown())
        tab.js("document.querySelector('canvas').focus()")
        tab.key(" ")
        tab.until("parseInt(document.querySelector('.hl-film output').value) > 50")
        playing = [r for r in self.mock.log if r["frame"] > 41]
        self.check("blank plays, in moving frames", len(playing) >= 8 and all(r["mode"] == "move" for r in playing), len(playing))
        tab.key(" ")
        tab.js(STILL)
        self.check("blank pauses, and the still comes", self.mock.log[-1]["mode"] == "still" and shown() == f"{self.mock.log[-1]['frame']} / 100", shown())
        tab = self.fresh(film=False)
        self.check("a single picture has no frames", not tab.js(is_shown(".hl-film")) and "frame" not in self.mock.log[-1])

        tab = self.fresh(film=None, first=98)
        self.check("without a number of frames there is only the frame", shown() == "frame 98" and not tab.js(is_shown(".hl-film input")), shown())
        for _ in range(4):
            tab.key("ArrowRight")
        tab.until(f"{text('.hl-note.hl-error')}.includes('the file has')")
        self.check("a frame beyond the last one is an error", shown() == "frame 102", shown())
        self.mock.counted = True
        for _ in range(3):
            tab.key("ArrowLeft")
        tab.js(STILL)
        self.check("the number of frames comes when they are counted", shown() == "99 / 100" and tab.js(is_shown(".hl-film input")), shown())
        tab.key("ArrowRight")
        tab.key("ArrowRight")
        self.check("then the last frame is the end", shown() == "100 / 100", shown())

    def supersedes(self):
        tab = self.fresh(still_ms=4000)  # a slow machine may need a second for a drag
        for i in range(3):
            tab.drag(self.at(0.4, 0.4), self.at(0.5 + 0.03 * i, 0.5), steps=3)
            end = time.monotonic() + 20
            while self.mock.log[-1]["mode"] != "still" and time.monotonic() < end:
                time.sleep(0.01)
        tab.js(STILL)
        last = self.mock.log[-1]
        self.check("a drag supersedes the still", self.mock.superseded >= 1, self.mock.superseded)
        self.check("the last still has the last camera", last["mode"] == "still" and last["camera"] == self.camera(), last)
        self.check("at most two are in flight", self.mock.most <= 2, self.mock.most)
        tab = self.fresh()
        self.mock.skip_stills = 2
        tab.drag(self.at(0.4, 0.4), self.at(0.5, 0.5), steps=3)
        tab.js(STILL)
        stills = [r for r in self.mock.log if r["mode"] == "still" and r["camera"] == self.camera()]
        self.check("a still that another window supersedes (204) is asked for again", len(stills) == 3, len(stills))

    def fails(self):
        tab = self.fresh()
        self.mock.refuse_frames = "accuracy certified: 17 pixels are not settled"
        tab.drag(self.at(0.4, 0.4), self.at(0.5, 0.5))
        tab.until(f"{text('.hl-note')}.includes('17 pixels')")
        self.check("the message of a 400 is shown", True)
        asked = len(self.mock.log)
        time.sleep(0.5)
        self.check("a refused frame is not asked for again and again", len(self.mock.log) - asked <= 1, len(self.mock.log) - asked)
        self.shot("error")
        self.mock.refuse_frames = None
        tab.drag(self.at(0.4, 0.4), self.at(0.5, 0.5))
        tab.js(STILL)
        self.check("the message goes with the next picture", not tab.js(is_shown(".hl-note")))
        self.mock.drop = True
        camera = self.camera()
        tab.drag(self.at(0.4, 0.4), self.at(0.45, 0.5), steps=2)
        tab.until(f"{text('.hl-message')}.startsWith('The server has ended')")
        self.check("the end of the server is said", True)
        self.shot("ended")
        self.mock.drop = False
        camera = self.camera()
        tab.js("document.querySelector('.hl-message').click()")
        tab.until(f"!{is_shown('.hl-message')}")
        tab.js(STILL)
        self.check("a click tries again, with the same camera", self.camera() == camera and self.mock.log[-1]["camera"] == camera)
        wrong = self.fresh(url=self.url.split("#")[0] + "#wrong", wait=False)
        wrong.until(f"{text('.hl-message')}.includes('token is wrong')")
        self.check("a wrong token is said", True)

    def paces(self):
        tab = self.fresh(size=(1000, 800))
        full = tab.js("document.querySelector('canvas').width")
        self.mock.ms_per_megapixel = 900
        self.mock.log.clear()
        a, b = self.at(0.3, 0.3), self.at(0.7, 0.7)
        tab.mouse("mousePressed", *a, "left", 1)
        width, end, i = full, time.monotonic() + 30, 0
        while width > full / 2 and time.monotonic() < end:
            i += 1
            tab.mouse("mouseMoved", a[0] + i % 200, a[1] + i % 150, "left")
            time.sleep(0.02)
            width = self.mock.log[-1]["size"][0] if self.mock.log else full
        self.check("a slow server gets smaller moving frames", width <= full / 2 + 1, width)
        self.check("at most two are in flight there", self.mock.most <= 2, self.mock.most)
        self.mock.ms_per_megapixel, self.mock.flat = 0, True
        smallest, end = width, time.monotonic() + 30
        while width < full and time.monotonic() < end:
            i += 1
            tab.mouse("mouseMoved", a[0] + i % 200, a[1] + i % 150, "left")
            time.sleep(0.02)
            width = self.mock.log[-1]["size"][0]
        self.check("a quick one gets greater frames again", width > smallest, (width, smallest))
        tab.mouse("mouseReleased", *b, "left", 1)
        sizes = self.mock.log and sorted({r["size"][0] for r in self.mock.log})
        wanted = {round(full / 2**k) for k in range(4)}
        self.check("the sizes are halves", set(sizes) <= wanted, sizes)
        tab.js(STILL)

    def legend_beside(self):
        """A legend as wide as the command's is within its panel, beside the picture."""
        tab = self.fresh(size=(1280, 800))
        image = "document.querySelector('.hl-legend img')"
        wide = "<svg xmlns='http://www.w3.org/2000/svg' width='480' height='84' viewBox='0 0 960 168'><rect width='960' height='168'/></svg>"
        tab.js(f"{image}.src = 'data:image/svg+xml,' + encodeURIComponent({json.dumps(wide)}); {image}.decode()")
        panel, drawn, stage = (
            tab.js(f"(({{left, right, top, bottom}}) => [left, right, top, bottom])({element}.getBoundingClientRect())")
            for element in ("document.querySelector('.hl-legend')", image, "document.querySelector('.hl-stage')")
        )
        self.check("the legend is within its panel", panel[0] <= drawn[0] and drawn[1] <= panel[1] and drawn[3] <= panel[3], [panel, drawn])
        self.check("the legend is above the picture", panel[3] <= stage[2] and stage[3] - stage[2] > 560, [panel, stage])
        self.shot("legend")

    def touches(self):
        tab = self.fresh(size=(390, 760), touch=True)
        tab.js("document.querySelector('.hl-legend summary').click()")
        before = self.camera()
        a, b = self.at(0.3, 0.4), self.at(0.6, 0.5)
        tab.touch("touchStart", a)
        for i in range(1, 7):
            tab.touch("touchMove", (a[0] + (b[0] - a[0]) * i / 6, a[1] + (b[1] - a[1]) * i / 6))
        tab.touch("touchEnd")
        after = self.camera()
        self.check("one finger orbits", near(before["at"], after["at"]) and not near(before["eye"], after["eye"]))
        (x, y), before = self.at(0.5, 0.5), after
        point = self.under((x - 10, y + 20))
        tab.touch("touchStart", (x - 40, y))
        tab.touch("touchStart", (x - 40, y), (x + 40, y))
        for i in range(1, 7):
            tab.touch("touchMove", (x - 40 - 10 * i, y), (x + 40 + 10 * i, y))
        tab.touch("touchEnd")
        after = self.camera()
        ratio = length(minus(after["eye"], after["at"])) / length(minus(before["eye"], before["at"]))
        self.check("a pinch zooms by the ratio of the fingers", near(ratio, 0.4, 0.05), ratio)
        self.check("a pinch zooms toward its middle", near(self.project(point), [x - 25, y + 50], 0.02), (self.project(point), x, y))
        before = after
        tab.touch("touchStart", (x - 40, y))
        tab.touch("touchStart", (x - 40, y), (x + 40, y))
        for i in range(1, 7):
            tab.touch("touchMove", (x - 40 + 5 * i, y + 5 * i), (x + 40 + 5 * i, y + 5 * i))
        tab.touch("touchEnd")
        after = self.camera()
        same = near(minus(before["at"], before["eye"]), minus(after["at"], after["eye"]), 0.01)
        self.check("two fingers pan", same and not near(before["at"], after["at"]), after)
        tab.js("[...document.querySelectorAll('.hl-buttons button')].find((b) => b.innerText === 'Fit').click()")
        tab.js(STILL)
        (a, hit), = self.spheres(1)
        tab.touch("touchStart", a)
        tab.touch("touchEnd")
        tab.until(f"{VIEW}.picked().length === 1")
        self.check("a tap picks", tab.js(f"{VIEW}.picked()[0].id") == hit["id"])
        self.shot("narrow-picked")
        tab.js(f"document.querySelector('.hl-panel header button').click()")
        self.shot("narrow")
        tab.js("document.querySelector('.hl-buttons button:last-child').click()")
        self.shot("narrow-help")
        tab.media(prefers_color_scheme="dark")
        self.shot("narrow-help-dark")

    def schemes(self):
        tab = self.fresh(size=(1280, 800))
        grounds = []
        for scheme in ("light", "dark"):
            tab.media(prefers_color_scheme=scheme)
            (a, _), = self.spheres(1)
            tab.click(*a)
            tab.until(f"{VIEW}.picked().length === 1")
            tab.js("document.querySelector('.hl-warnings').open = true")
            self.shot(scheme)
            grounds.append(tab.js("getComputedStyle(document.querySelector('.halfline-view')).backgroundColor"))
            time.sleep(0.5)
        self.check("light and dark follow the system", grounds[0] != grounds[1], grounds)
        tab.key("?", SHIFT)
        self.shot("help-dark")
        tab.resize(700, 500, scale=2)
        tab.js("new Promise((r) => setTimeout(r, 400))")
        tab.js(STILL)
        stage = tab.js("(({clientWidth, clientHeight}) => [2 * clientWidth, 2 * clientHeight])(document.querySelector('.hl-stage'))")
        self.check("a still has the pixels of the device", tab.js("(({width, height}) => [width, height])(document.querySelector('canvas'))") == stage, stage)

    def notebooks(self):
        tab = self.fresh(size=(700, 560), url=self.url.replace("/#", "/notebook.html#"))
        box = tab.js("(({width, height}) => [width, height])(notebook.root.getBoundingClientRect())")
        self.check("the joined modules live in a root of their own", box == [600, 400], box)
        self.check("the still comes over the comm", tab.js("notebook.model.sent.some((m) => m.body?.mode === 'still')"))
        body = tab.js("getComputedStyle(document.body).margin + getComputedStyle(document.querySelector('p')).fontSize")
        self.check("the notebook keeps its look", body == "8px16px", body)
        self.shot("notebook")
        camera = self.camera()
        tab.key("x")
        self.check("keys without focus are the notebook's", self.camera() == camera)
        tab.drag(self.at(0.4, 0.4), self.at(0.5, 0.6))
        tab.key("o")
        self.check("with focus they are the view's", "height" in self.camera())
        tab.js(STILL)
        tab.until(f"JSON.stringify(notebook.model.traits.camera) === JSON.stringify({VIEW}.camera())")
        self.check("the trait camera follows", True)
        (a, hit), = self.spheres(1)
        tab.click(*a)
        tab.until("notebook.model.traits.picked?.length === 1")
        self.check("the trait picked follows", tab.js("notebook.model.traits.picked[0].id") == hit["id"])
        tab.js("(notebook.model.traits.selection = 'C', notebook.model.emit('change:selection'))")
        tab.until(f"{VIEW}.selection() === 'C' && {text('.hl-select output')} !== ''")
        self.check("a selection of Python is taken", True)
        given = {"eye": [5, -30, 5], "at": [5, 5, 5], "up": [0, 0, 1], "vfov": 25}
        tab.js(f"(notebook.model.traits.camera = {json.dumps(given)}, notebook.model.emit('change:camera'))")
        tab.js(STILL)
        self.check("a camera of Python is taken as it is", self.camera() == given and self.mock.log[-1]["camera"] == given)
        self.shot("notebook-picked")
        self.check("/keep is sent after a still", tab.js("notebook.model.sent.filter((m) => m.route === '/keep').length") > 0)
        tab.js("notebook.close()")
        self.check("it goes without a trace", tab.js("notebook.root.childElementCount") == 0)

    def weight(self):
        # A browser does not get the modules of notebooks and of pages without a server.
        others = ("widget.js", "figure.js", "worker.js")
        files = [path for path in mock.PAGE.iterdir() if path.suffix in mock.TYPES and path.name not in others]
        total = sum(path.stat().st_size for path in files)
        self.check("the page is under 46 KB", total < 46_000, f"{total} bytes")

    def everything(self):
        for name in ("units", "beginning", "orbit", "pans", "zooms", "picks", "axes", "lenses", "copies", "saves", "helps", "controls", "turns"):
            if self.tab is None or name in ("orbit", "picks", "copies"):
                self.fresh()
            self.group(name, getattr(self, name))
        if self.mock or self.settings.select:
            self.fresh()
            self.group("selects", self.selects)
        if self.mock:
            for name in ("films", "supersedes", "fails", "paces", "touches", "phones", "schemes", "legend_beside", "notebooks", "weight"):
                self.group(name, getattr(self, name))
        else:
            self.group("schemes", self.schemes)
        self.complaints()
        # The line that tests/run counts.
        word = "FAILED" if self.failed else "ok"
        print(f"test result: {word}. {self.number - self.failed} passed; {self.failed} failed; 0 ignored")
        return 1 if self.failed else 0


def options(arguments=None):
    """What the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--url", help="of a running server, with its token; else mock.py is started")
    parser.add_argument("--select", help="an expression that the file of --url can be selected by")
    parser.add_argument("--shots", default=str(pathlib.Path(tempfile.gettempdir()) / "halfline-view"), help="the folder of the screenshots")
    parser.add_argument("--only", help="only the groups whose name has this word")
    parser.add_argument("--times", action="store_true", help="prints how long each group took")
    return parser.parse_args(arguments)


def main():
    settings = options()
    program = browser.find()
    if not program:
        print("skipped: there is no Chromium (set CHROMIUM to its path)")
        return 77
    with contextlib.closing(browser.Browser(program)) as started:
        return Run(settings, started).everything()


if __name__ == "__main__":
    sys.exit(main())
