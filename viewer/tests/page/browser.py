"""Chromium without a display, driven over the pipe of its DevTools protocol (JSON, separated by NUL). Standard library only."""

import base64
import fcntl
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time

LAUNCH = "import os, sys; r, w = int(sys.argv[1]), int(sys.argv[2]); os.dup2(r, 3); os.dup2(w, 4); os.execvp(sys.argv[3], sys.argv[3:])"
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


def find():
    named = os.environ.get("CHROMIUM")
    return named or next((path for path in map(shutil.which, NAMES) if path), None)


class Failed(Exception):
    pass


class Browser:
    def __init__(self, program, limit=30, gpu=("--disable-gpu",)):
        self.limit, self.last, self.answers, self.events = limit, 0, {}, []
        self.changed = threading.Condition()
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        # Above 9, so that 3 and 4 are free in the child.
        pairs = [[fcntl.fcntl(fd, fcntl.F_DUPFD, 10) for fd in os.pipe()] for _ in range(2)]
        (child_in, self.out), (self.into, child_out) = pairs
        flags = [
            "--headless", "--no-sandbox", *gpu, "--remote-debugging-pipe", f"--user-data-dir={self.folder.name}",
            "--no-first-run", "--hide-scrollbars", "--disable-dev-shm-usage", "about:blank",
        ]
        self.process = subprocess.Popen(
            [sys.executable, "-c", LAUNCH, str(child_in), str(child_out), program, *flags],
            pass_fds=(child_in, child_out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        os.close(child_in)
        os.close(child_out)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        rest = b""
        while data := os.read(self.into, 1 << 16):
            *messages, rest = (rest + data).split(b"\0")
            with self.changed:
                for message in map(json.loads, messages):
                    if "id" in message:
                        self.answers[message["id"]] = message
                    else:
                        self.events.append(message)
                self.changed.notify_all()

    def send(self, method, session=None, **params):
        self.last += 1
        message = {"id": self.last, "method": method, "params": params}
        if session:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.out, data) :]
        return self.last

    def call(self, method, session=None, **params):
        number = self.send(method, session, **params)
        with self.changed:
            if not self.changed.wait_for(lambda: number in self.answers, self.limit):
                raise Failed(f"{method}: no answer within {self.limit} s")
            answer = self.answers.pop(number)
        if "error" in answer:
            raise Failed(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def open(self, url, size=(1000, 700), touch=False):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        tab = Tab(self, target, session)
        for domain in ("Page", "Runtime", "Log"):
            tab.call(f"{domain}.enable")
        tab.resize(*size, touch=touch)
        tab.call("Page.navigate", url=url)
        return tab

    def close(self):
        try:
            self.call("Browser.close")
            self.process.wait(10)
        except (Failed, OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        self.folder.cleanup()


class Tab:
    def __init__(self, browser, target, session):
        self.browser, self.target, self.session, self.held = browser, target, session, 0

    def call(self, method, **params):
        return self.browser.call(method, self.session, **params)

    def js(self, expression):
        """The value of an expression; a promise is awaited."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True, userGesture=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise Failed(details.get("exception", {}).get("description", details["text"]))
        return result["result"].get("value")

    def until(self, expression, limit=20):
        end = time.monotonic() + limit
        while not (value := self.js(expression)):
            if time.monotonic() > end:
                raise Failed(f"not true within {limit} s: {expression}")
            time.sleep(0.03)
        return value

    def resize(self, width, height, touch=False, scale=1):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=touch)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch, maxTouchPoints=2 if touch else 1)

    def media(self, **features):
        pairs = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.call("Emulation.setEmulatedMedia", features=pairs)

    # Modifiers are bits: 1 alt, 2 ctrl, 4 meta, 8 shift.
    def mouse(self, kind, x, y, button="none", clicks=0, modifiers=0, **more):
        bits = {"left": 1, "right": 2, "middle": 4}
        if kind == "mousePressed":
            self.held = bits[button]
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=self.held, clickCount=clicks, modifiers=modifiers, **more)
        if kind == "mouseReleased":
            self.held = 0

    def drag(self, a, b, button="left", modifiers=0, steps=8, pause=0.0):
        self.mouse("mouseMoved", *a, modifiers=modifiers)
        self.mouse("mousePressed", *a, button, 1, modifiers)
        for i in range(1, steps + 1):
            t = i / steps
            self.mouse("mouseMoved", a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, button, 0, modifiers)
            time.sleep(pause)
        self.mouse("mouseReleased", *b, button, 1, modifiers)

    def click(self, x, y, modifiers=0, clicks=1):
        self.mouse("mouseMoved", x, y, modifiers=modifiers)
        for i in range(1, clicks + 1):
            self.mouse("mousePressed", x, y, "left", i, modifiers)
            self.mouse("mouseReleased", x, y, "left", i, modifiers)

    def wheel(self, x, y, delta, modifiers=0):
        self.mouse("mouseWheel", x, y, deltaX=0, deltaY=delta, modifiers=modifiers)

    def touch(self, kind, *points):
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)])

    def key(self, key, modifiers=0):
        codes = {" ": "Space", "/": "Slash", "?": "Slash"}
        code = codes.get(key, f"Key{key.upper()}" if len(key) == 1 else key)
        number = {"Enter": 13, "Escape": 27, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "/": 191, "?": 191}.get(key, ord(key[0].upper()))
        text = "\r" if key == "Enter" else key if len(key) == 1 else ""
        common = dict(key=key, code=code, windowsVirtualKeyCode=number, modifiers=modifiers)
        self.call("Input.dispatchKeyEvent", type="keyDown" if text else "rawKeyDown", **common, **({"text": text} if text else {}))
        self.call("Input.dispatchKeyEvent", type="keyUp", **common)

    def write(self, text):
        for letter in text:
            self.key(letter)

    def screenshot(self, path):
        pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
        pathlib.Path(path).write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def complaints(self):
        """Exceptions, and what breaks the policy of the page."""
        found = []
        with self.browser.changed:
            events = [e for e in self.browser.events if e.get("sessionId") == self.session]
        for event in events:
            if event["method"] == "Runtime.exceptionThrown":
                details = event["params"]["exceptionDetails"]
                found.append(details.get("exception", {}).get("description", details["text"]))
            elif event["method"] == "Log.entryAdded":
                entry = event["params"]["entry"]
                if entry["level"] == "error" and entry["source"] != "network":
                    found.append(entry["text"])
        return found

    def close(self):
        self.browser.call("Target.closeTarget", targetId=self.target)
