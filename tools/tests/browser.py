# SPDX-License-Identifier: MIT
"""A headless Chromium that opens pages: spoken to by its own protocol, over a pipe.

Two messages are all that tests need of that protocol; a library for it brings a browser's size.
"""

import base64
import fcntl
import itertools
import json
import os
import select
import shutil
import subprocess
import tempfile
from contextlib import contextmanager

import pytest

PROGRAM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
PATIENCE_S = 120
OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
    "--no-first-run", "--disable-background-networking", "--remote-debugging-pipe",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--hide-scrollbars",
)  # fmt: skip


class Browser:
    """A browser with one page; `asked` are the addresses that the page has asked for."""

    def __init__(self, to, back):
        self._to, self._back, self._read = to, back, bytearray()
        self._numbers, self.events, self.session = itertools.count(1), [], None

    def call(self, method, **parameters):
        """Send a message and return what it gives back."""
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        self._to.write(json.dumps(message).encode() + b"\0")
        self._to.flush()
        while (found := self._next()).get("id") != number:
            self.events.append(found)
        assert "error" not in found, (method, found)
        return found["result"]

    def await_event(self, method):
        """Wait for an event and return it; those before it are kept."""
        while (found := self._next()).get("method") != method:
            self.events.append(found)
        self.events.append(found)
        return found["params"]

    def _next(self):
        while b"\0" not in self._read:
            there, _, _ = select.select([self._back], [], [], PATIENCE_S)
            data = os.read(self._back, 1 << 20) if there else b""
            assert data, "the browser has ended, or says nothing"
            self._read += data
        message, _, self._read = self._read.partition(b"\0")
        return json.loads(message)

    def attach(self):
        """Attach to a new page."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def open(self, path, **more):
        """Open a file and wait until it has been drawn."""
        return self.visit(f"file://{path}{more.pop('fragment', '')}", **more)

    def visit(self, address, width=1280, height=900, scale=1, scheme="light"):
        """Go to an address and wait until its page has been drawn."""
        scheme = {"name": "prefers-color-scheme", "value": scheme}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height,
            deviceScaleFactor=scale, mobile=width < 600,
        )  # fmt: skip
        self.call("Page.navigate", url="about:blank")  # a fragment alone would load nothing
        self.await_event("Page.loadEventFired")
        self.events.clear()
        self.call("Page.navigate", url=address)
        self.await_event("Page.loadEventFired")
        return self.run(
            "new Promise((done) => { const look = () => document.body.dataset.readyMs ? "
            "done(Number(document.body.dataset.readyMs)) : setTimeout(look, 5); look(); })"
        )

    def run(self, script):
        """Return what a script of the page gives."""
        found = self.call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def drag(self, selector, from_share, to_share):
        """Drag the mouse over an element, between two shares of its width."""
        box = self.run(
            f"(() => {{ const one = document.querySelector({selector!r}); "
            "one.scrollIntoView({block: 'center'}); const box = one.getBoundingClientRect(); "
            "return [box.x, box.y, box.width, box.height]; })()"
        )
        left, top, wide, high = box
        for kind, share in (
            ("mousePressed", from_share), ("mouseMoved", to_share), ("mouseReleased", to_share),
        ):  # fmt: skip
            self.call(
                "Input.dispatchMouseEvent", type=kind, x=left + share * wide, y=top + high / 2,
                button="left", buttons=1, clickCount=1,
            )  # fmt: skip

    @property
    def asked(self):
        """The addresses that the page has asked for since it was opened."""
        sent = (one for one in self.events if one.get("method") == "Network.requestWillBeSent")
        return [one["params"]["request"]["url"] for one in sent]

    @property
    def errors(self):
        """What the page complained of."""
        kinds = ("Runtime.exceptionThrown", "Log.entryAdded")
        return [one["params"] for one in self.events if one.get("method") in kinds]

    def picture(self, path):
        """Write a picture of the whole page."""
        found = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)
        path.write_bytes(base64.b64decode(found["data"]))


def _pipe():
    """Return a pipe whose ends are none of the numbers that the browser's own get."""
    ends = os.pipe()
    moved = tuple(fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends)
    for end in ends:
        os.close(end)
    return moved


@contextmanager
def opened():
    """Yield a browser; a system that has none leaves the test out."""
    if PROGRAM is None:
        pytest.skip("no chromium here (tools/setup installs it where the system has it)")
    (to_read, to_write), (back_read, back_write) = _pipe(), _pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = f'exec "$0" "$@" 3<&{to_read} 4>&{back_write}'
        process = subprocess.Popen(
            ["bash", "-c", command, PROGRAM, *OPTIONS, f"--user-data-dir={profile}"],
            pass_fds=(to_read, back_write), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(to_read)
        os.close(back_write)
        try:
            with os.fdopen(to_write, "wb") as to, os.fdopen(back_read, "rb") as back:
                browser = Browser(to, back.fileno())
                browser.attach()
                yield browser
                browser.session = None
                browser.call("Browser.close")
        finally:
            process.terminate()
            process.wait(10)
