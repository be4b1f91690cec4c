#!/usr/bin/env python3
"""Shows `Scene.view` in a real JupyterLab page under Chromium: runs a notebook, drags, picks, selects, and measures. It is no
part of CI: it needs an environment with halfline, anywidget and jupyterlab.

    python3 python/tests/lab.py --python ENVIRONMENT/bin/python [--shots FOLDER] [--scene CODE] [--seconds N]

Prints a line per check and the measurements as JSON; exits 1 if a check fails."""

import argparse
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "viewer/tests/page"))
import browser

ROOT = "document.querySelector('.halfline-view')"
VIEW = f"{ROOT}.halfline"
SCENE = """
random = np.random.default_rng(1)
scene = hl.Scene(random.normal(size=(5000, 3)), random.uniform(0.02, 0.1, 5000), random.uniform(size=(5000, 3)))
"""
CELLS = [
    "import halfline as hl, numpy as np, time\nimport anywidget\nSCENE",
    "view = scene.view(look='soft', silhouette=True)\nview",
    "time.sleep(4)",
    "print(view.to_camera(), len(view.picked), view.selection)",
    "view.camera = hl.Camera((0, 0, 30), at=(0, 0, 0), vfov=20)\nview.selection = 'x > 0'",
]
SHIFT = 8


def notebook(cells):
    made = [
        {
            "cell_type": "code",
            "execution_count": None,
            "metadata": {},
            "outputs": [],
            "source": text,
            "id": f"c{k}",
        }
        for k, text in enumerate(cells)
    ]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


class Lab:
    """A server of JupyterLab in a folder of its own, without a token, for this machine alone."""

    def __init__(self, python, cells):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.path = pathlib.Path(self.folder.name)
        (self.path / "view.ipynb").write_text(json.dumps(notebook(cells)))
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        options = [
            "--no-browser",
            "--allow-root",
            "--ip=127.0.0.1",
            f"--port={self.port}",
            f"--notebook-dir={self.path}",
            "--IdentityProvider.token=",
            "--LabApp.expose_app_in_browser=True",
            "--LabApp.news_url=None",
            "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
        ]
        here = {
            f"JUPYTER_{name}_DIR": str(self.path / f".{name}")
            for name in ("CONFIG", "RUNTIME", "DATA")
        }
        settings = (
            self.path
            / ".CONFIG/lab/user-settings/@jupyterlab/apputils-extension/notification.jupyterlab-settings"
        )
        settings.parent.mkdir(parents=True)
        settings.write_text('{"fetchNews": "false"}')
        self.log = open(self.path / "log", "w")
        self.process = subprocess.Popen(
            [python, "-m", "jupyterlab", *options],
            env={"XDG_RUNTIME_DIR": str(self.path), **os.environ, **here},
            stdout=self.log,
            stderr=self.log,
        )
        self.url = f"http://127.0.0.1:{self.port}"
        end = time.monotonic() + 60
        while True:
            try:
                urllib.request.urlopen(f"{self.url}/api/status", timeout=5).read()
                return
            except OSError:
                if time.monotonic() > end or self.process.poll() is not None:
                    raise SystemExit((self.path / "log").read_text()) from None
                time.sleep(0.2)

    def saved(self):
        return json.loads((self.path / "view.ipynb").read_text())

    def close(self):
        # The server ends its kernels.
        self.process.terminate()
        self.process.wait(20)
        self.log.close()
        self.folder.cleanup()


class Run:
    def __init__(self, settings):
        self.settings, self.failed, self.found = settings, 0, {}
        cells = [text.replace("SCENE", settings.scene) for text in CELLS]
        self.lab = Lab(settings.python, cells)
        self.browser = browser.Browser(browser.find())
        self.tab = self.browser.open(f"{self.lab.url}/lab/tree/view.ipynb", size=(1280, 900))

    def check(self, name, ok, detail=""):
        self.failed += not ok
        print(f"{'ok' if ok else 'FAILED'}  {name}{'' if ok else f': {detail}'}", flush=True)

    def shot(self, name):
        self.tab.screenshot(pathlib.Path(self.settings.shots) / f"{name}.png")

    def cell(self, number, waits=True):
        """Runs a cell."""
        panel = "window.jupyterapp.shell.currentWidget.content"
        self.tab.js(f"{panel}.activeCellIndex = {number}; {panel}.deselectAll()")
        run = "window.jupyterapp.commands.execute('notebook:run-cell')"
        self.tab.js(run if waits else f"void {run}")

    def text(self, number):
        return self.tab.js(
            f"document.querySelectorAll('.jp-Notebook-cell')[{number}].querySelector('.jp-OutputArea-output')?.innerText ?? ''"
        )

    def place(self):
        return self.tab.js(
            f"(r => [r.left + r.width / 2, r.top + r.height / 2])({ROOT}.querySelector('canvas').getBoundingClientRect())"
        )

    def stats(self):
        return self.tab.js(
            f"({{frames: {VIEW}.stats.frames, sizes: {VIEW}.stats.sizes, status: {ROOT}.querySelector('.hl-status').textContent}})"
        )

    def still(self):
        self.tab.js(f"{VIEW}.still().then(() => true)")

    def run(self):
        tab = self.tab
        tab.until(
            "(shown => shown?.content?.activeCell && shown.sessionContext.session?.kernel?.status === 'idle')"
            "(window.jupyterapp?.shell.currentWidget)",
            90,
        )
        self.cell(0)
        begin = time.monotonic()
        self.cell(1, waits=False)
        tab.until(f"{ROOT}?.halfline?.stats.frames > 0", 60)
        self.found["first picture, s"] = round(time.monotonic() - begin, 2)
        self.still()
        self.found["first still, s"] = round(time.monotonic() - begin, 2)
        self.shot("1-first")
        self.check(
            "the view shows a still picture", "certified" in self.stats()["status"], self.stats()
        )

        x, y = self.place()
        before, begin = self.stats()["frames"], time.monotonic()
        tab.mouse("mouseMoved", x, y)
        tab.mouse("mousePressed", x, y, "left", 1)
        step = 0
        while time.monotonic() - begin < self.settings.seconds:
            step += 1
            tab.mouse("mouseMoved", x + 2 * (step % 100), y + step % 40, "left")
            time.sleep(0.008)
        took, after = time.monotonic() - begin, self.stats()
        self.shot("2-moving")
        tab.mouse("mouseReleased", x, y, "left", 1)
        self.found["moving, frames per second"] = round((after["frames"] - before) / took, 1)
        self.found["moving, last size"] = after["sizes"][-1]
        self.still()
        self.shot("3-turned")
        self.found["still"] = self.stats()["status"]

        begin = time.monotonic()
        tab.click(x, y)
        tab.until(f"{VIEW}.picked().length === 1", 10)
        self.found["pick, ms"] = round((time.monotonic() - begin) * 1e3)
        # The table is on the right.
        for across, down in ((-60, 60), (-40, 90), (-90, 40), (-20, 120)):
            tab.click(x + across, y + down, modifiers=SHIFT)
            time.sleep(0.5)
            if tab.js(f"{VIEW}.picked().length === 2"):
                break
        self.check(
            "a second pick has a distance",
            "Distance" in tab.js(f"{ROOT}.querySelector('.hl-table').innerText"),
        )
        self.shot("4-picked")
        tab.key("/")
        tab.write("z > 0")
        tab.key("Enter")
        tab.until(f"{VIEW}.selection() === 'z > 0'", 10)
        self.still()
        self.shot("5-selected")
        self.cell(3)
        self.check(
            "the kernel has camera, picks and selection",
            "z > 0" in self.text(3) and "Camera(" in self.text(3),
            self.text(3),
        )
        self.found["kernel"] = self.text(3)

        # While a cell runs.
        tab.js(f"{ROOT}.querySelector('.hl-table button').click()")
        self.cell(2, waits=False)
        time.sleep(0.5)
        before, (x, y) = self.stats()["frames"], self.place()
        tab.drag((x, y), (x + 150, y + 40), steps=30, pause=0.05)
        self.found["frames while a cell runs for 2 s"] = self.stats()["frames"] - before
        time.sleep(4)
        self.still()
        self.cell(4)
        tab.until(f"{VIEW}.selection() === 'x > 0' && {VIEW}.camera().vfov === 20", 10)
        self.still()
        self.check("traits that Python sets move the page", True)
        self.shot("6-from-python")

        # The saved notebook, and the page without a kernel.
        tab.js("window.jupyterapp.commands.execute('docmanager:save')")
        time.sleep(1)
        outputs = [output for cell in self.lab.saved()["cells"] for output in cell["outputs"]]
        pictures = [
            output["data"]["image/png"]
            for output in outputs
            if "image/png" in output.get("data", {})
        ]
        self.check(
            "the saved notebook has the picture",
            len(pictures) == 1,
            [list(o.get("data", {})) for o in outputs],
        )
        self.found["saved picture, KB"] = round(len(pictures[0]) / 1e3) if pictures else None
        self.reopened()
        found = [line for line in tab.complaints() if "halfline" in line]
        self.check("the page has no complaints", not found, found)
        print(json.dumps(self.found, indent=2))

    def reopened(self):
        """What a new page shows of the saved notebook, whose kernel has ended."""
        self.tab.js("window.jupyterapp.serviceManager.sessions.shutdownAll()")
        self.tab.call("Page.navigate", url=f"{self.lab.url}/lab/workspaces/other/tree/view.ipynb")
        self.tab.until(
            f"!{ROOT} && document.querySelectorAll('.jp-Cell-outputWrapper').length > 1", 60
        )
        time.sleep(3)
        self.shot("7-reopened")
        self.found["reopened"] = self.text(1)

    def close(self):
        self.browser.close()
        self.lab.close()


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--python", default=sys.executable, help="an interpreter with halfline and jupyterlab"
    )
    parser.add_argument(
        "--shots",
        default=tempfile.gettempdir() + "/halfline-lab",
        help="folder of the screenshots",
    )
    parser.add_argument("--scene", default=SCENE, help="lines that make scene")
    parser.add_argument("--seconds", type=float, default=4, help="how long a drag takes")
    run = Run(parser.parse_args())
    try:
        run.run()
    except (browser.Failed, OSError) as error:
        run.shot("failed")
        run.check("the run", False, error)
        print(json.dumps(run.found, indent=2))
        print((run.lab.path / "log").read_text()[-3000:])
    finally:
        run.close()
    sys.exit(run.failed > 0)


if __name__ == "__main__":
    main()
