"""Debian's Chromium by its DevTools protocol, over two pipes: pages at a width, movements of the mouse, pictures, and what
the console was given."""

import base64
import io
import json
import subprocess
import time
from contextlib import contextmanager

import numpy as np
from PIL import Image
from tests.report_samples import CHROMIUM

#: WebGL by software; the protocol goes over the descriptors 3 and 4, which a shell makes of its input and output.
FLAGS = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SHELL = 'exec "$0" "$@" 3<&0 4>&1 0</dev/null 1>/dev/null'
#: Seconds after which what is waited for is missed.
PATIENCE = 200.0


class Page:
    """One tab of the browser. console: every message, fault and warning since it was opened."""

    def __init__(self, to, back):
        self.to, self.back, self.count, self.console, self.tab = to, back, 0, [], {}
        target = next(one for one in self("Target.getTargets")["targetInfos"] if one["type"] == "page")
        session = self("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        self.tab = {"sessionId": session}
        for domain in ("Page", "Runtime", "Log", "Network"):
            self(f"{domain}.enable")
        self("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)

    def __call__(self, method, **params):
        """Answer of a method of the protocol."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": params} | self.tab
        self.to.write(json.dumps(message).encode() + b"\0")
        self.to.flush()
        while (found := self._next()).get("id") != self.count:
            if found.get("method") in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
                self.console.append(json.dumps(found["params"])[:600])
        assert "error" not in found, found
        return found["result"]

    def _next(self):
        """What the browser says next: an answer or an event."""
        said = b""
        while not said.endswith(b"\0"):
            one = self.back.read(1)
            assert one, "the browser ended"
            said += one
        return json.loads(said[:-1])

    def open(self, path, width, height):
        """Open a file in a window of that size, and wait until it is drawn."""
        phone = width < 500
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self("Page.navigate", url=path.as_uri())
        until = time.monotonic() + PATIENCE
        while not self.run("document.readyState === 'complete'"):
            assert time.monotonic() < until
            time.sleep(0.05)
        self.settle()

    def settle(self):
        """Wait until the browser has drawn what was asked for."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")

    def run(self, expression):
        """Value of an expression of the page, or of its promise."""
        found = self("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def mouse(self, kind, x, y, *, pressed=False):
        """Move, press or release the left button, at a point of the window."""
        button = {"button": "left", "buttons": 1, "clickCount": 1} if pressed or kind != "mouseMoved" else {}
        self("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def drag(self, start, end):
        """Press at a point, move to another, release."""
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start)
        for place in np.linspace(start, end, 9)[1:].tolist():
            self.mouse("mouseMoved", *place, pressed=True)
        self.mouse("mouseReleased", *end)
        self.settle()

    def box(self, selector):
        """Left, top, width and height of an element in the window, which it is scrolled into."""
        found = f"(() => {{ const e = document.querySelector({selector!r}); e.scrollIntoView({{block: 'center'}});"
        return self.run(f"{found} const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()")

    def picture(self, selector):
        """What is seen of an element, as an array (height, width, 3)."""
        left, top, width, height = self.box(selector)
        x, y = self.run("[scrollX, scrollY]")
        clip = {"x": left + x, "y": top + y, "width": width, "height": height, "scale": 1}
        data = self("Page.captureScreenshot", format="png", clip=clip)["data"]
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")).astype(int)


@contextmanager
def browser(folder):
    """A page of a browser of its own, whose profile is in a folder."""
    options = [*FLAGS, "--remote-debugging-pipe", f"--user-data-dir={folder}", "about:blank"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(["sh", "-c", SHELL, CHROMIUM, *options], **pipes) as process:
        try:
            yield Page(process.stdin, process.stdout)
        finally:
            process.terminate()
