"""Debian's Chromium by its DevTools protocol, over two pipes: pages at a width, movements of the mouse, pictures, and what
the console was given."""

import base64
import io
import json
import os
import subprocess
import time
from contextlib import contextmanager

import numpy as np
from PIL import Image
from tests.report_samples import CHROMIUM

#: WebGL by software.
FLAGS = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
#: Seconds after which an answer, or what is waited for, is missed.
PATIENCE = 200.0


class Page:
    """One tab of the browser. console: every message, fault and warning since it was opened."""

    def __init__(self, to, back):
        self.to, self.back, self.count, self.console, self.buffer = to, back, 0, [], b""
        self.session = None
        (target,) = [one for one in self("Target.getTargets")["targetInfos"] if one["type"] == "page"][:1]
        self.session = self("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self(f"{domain}.enable")
        self("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)

    def __call__(self, method, **params):
        """Answer of a method of the protocol."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": params} | (
            {"sessionId": self.session} if self.session else {}
        )
        os.write(self.to, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            found = self._next()
            if found.get("id") == self.count:
                assert "error" not in found, found
                return found["result"]
            self._noted(found)
        raise TimeoutError(method)

    def _next(self):
        while b"\0" not in self.buffer:
            got = os.read(self.back, 1 << 20)
            assert got, "the browser ended"
            self.buffer += got
        line, _, self.buffer = self.buffer.partition(b"\0")
        return json.loads(line)

    def _noted(self, event):
        method, params = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.console.append(json.dumps(params["exceptionDetails"])[:600])
        if method == "Runtime.consoleAPICalled":
            self.console.append(f"{params['type']}: {[a.get('value', a.get('description')) for a in params['args']]}")
        if method == "Log.entryAdded":
            self.console.append(f"{params['entry']['level']}: {params['entry']['text']}")

    def open(self, path, width, height):
        """Open a file in a window of that size, and wait until it is drawn."""
        phone = width < 500
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self("Page.navigate", url=path.as_uri())
        self.until("document.readyState === 'complete'")
        self.settle()

    def settle(self):
        """Wait until the browser has drawn what was asked for."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")

    def run(self, expression):
        """Value of an expression of the page, or of its promise."""
        found = self("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def until(self, expression):
        until = time.monotonic() + PATIENCE
        while not self.run(expression):
            assert time.monotonic() < until, expression
            time.sleep(0.05)

    def mouse(self, kind, x, y, *, pressed=False):
        """Move, press or release the left button, at a point of the window."""
        button = {"button": "left", "buttons": 1, "clickCount": 1} if pressed or kind != "mouseMoved" else {}
        self("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def drag(self, start, end, steps=8):
        """Press at a point, move to another, release."""
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start)
        for k in range(1, steps + 1):
            self.mouse("mouseMoved", *(a + (b - a) * k / steps for a, b in zip(start, end, strict=True)), pressed=True)
        self.mouse("mouseReleased", *end)
        self.settle()

    def box(self, selector):
        """Left, top, width and height of an element in the window, which it is scrolled into."""
        found = f"(() => {{ const e = document.querySelector({selector!r}); e.scrollIntoView({{block: 'center'}});"
        return self.run(f"{found} const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()")

    def picture(self, selector=None):
        """What is seen, of an element alone, as an array (height, width, 3)."""
        clip = {}
        if selector:
            left, top, width, height = self.box(selector)
            x, y = self.run("[scrollX, scrollY]")
            clip = {"clip": {"x": left + x, "y": top + y, "width": width, "height": height, "scale": 1}}
        data = self("Page.captureScreenshot", format="png", **clip)["data"]
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")).astype(int)


@contextmanager
def browser(folder):
    """A page of a browser of its own, whose profile is in a folder."""
    (child_in, to), (back, child_out) = os.pipe(), os.pipe()

    def pipes():  # those that --remote-debugging-pipe reads and writes
        kept = os.dup(child_in), os.dup(child_out)
        for number, end in enumerate(kept, 3):
            if end != number:
                os.dup2(end, number)
                os.set_inheritable(number, True)

    command = [CHROMIUM, *FLAGS, "--remote-debugging-pipe", f"--user-data-dir={folder}", "about:blank"]
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, preexec_fn=pipes, close_fds=False, **quiet)
    os.close(child_in)
    os.close(child_out)
    try:
        yield Page(to, back)
    finally:
        process.terminate()
        process.wait(20)
        os.close(to)
        os.close(back)
