"""A headless Chromium, spoken to in its DevTools protocol over a pair of pipes."""

import atexit
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from functools import cache

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
PATIENCE = 60.0  # seconds

_LAUNCH = """
import fcntl, os, sys
listen, speak = (fcntl.fcntl(int(end), fcntl.F_DUPFD, 10) for end in sys.argv[1:3])
os.dup2(listen, 3)
os.dup2(speak, 4)
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Makes the pipes' ends descriptors 3 and 4, where the browser looks for them."""


def find():
    """Return the browser's path, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class _Browser:
    """The browser of this process, which shows all pages; it ends with the pipes."""

    def __init__(self):
        self.sessions, self._count, self._rest = {}, 0, b""
        # Some of the browser's processes write on for a moment after the first has ended.
        self._profile = tempfile.TemporaryDirectory(prefix="browser-", ignore_cleanup_errors=True)
        listen, self._speak = os.pipe()
        self._listen, speak = os.pipe()
        flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
        flags += ["--remote-debugging-pipe", f"--user-data-dir={self._profile.name}"]
        flags += ["--window-size=1400,1000", "--no-first-run"]
        self._process = subprocess.Popen(
            [sys.executable, "-c", _LAUNCH, str(listen), str(speak), find(), *flags],
            pass_fds=(listen, speak),
            stderr=subprocess.DEVNULL,
        )
        os.close(listen)
        os.close(speak)

    def close(self):
        self._process.terminate()
        self._process.wait(PATIENCE)
        os.close(self._speak)
        os.close(self._listen)
        self._profile.cleanup()

    def call(self, method, session=None, **parameters):
        """Return the answer to a message; pages take the events that come before it."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._speak, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE
        while (answer := self._read(end)).get("id") != self._count:
            self._pass_on(answer)
        assert "error" not in answer, answer["error"]
        return answer["result"]

    def wait(self, end):
        """Wait for an event, and let its page take it."""
        self._pass_on(self._read(end))

    def _pass_on(self, event):
        if page := self.sessions.get(event.get("sessionId")):
            page._take(event)

    def _read(self, end):
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._listen], [], [], max(end - time.monotonic(), 0.0))
            assert ready, "the browser says nothing"
            part = os.read(self._listen, 1 << 16)
            assert part, "the browser is gone"
            self._rest += part
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)


@cache
def _started():
    """Return the browser, started when it is first asked for."""
    started = _Browser()
    atexit.register(started.close)
    return started


class Page:
    """One page; collects `errors` of scripts and the `requests` made, until closed."""

    def __init__(self, url):
        self.errors, self.requests, self._loaded = [], [], False
        self._browser, self._session = _started(), None
        # In a window of its own: pages that are behind others are not drawn.
        made = self._call("Target.createTarget", url="about:blank", newWindow=True)
        self._target = made["targetId"]
        attached = self._call("Target.attachToTarget", targetId=self._target, flatten=True)
        self._session = attached["sessionId"]
        self._browser.sessions[self._session] = self
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")
        self._call("Page.navigate", url=url)
        end = time.monotonic() + PATIENCE
        while not self._loaded:
            self._browser.wait(end)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        del self._browser.sessions[self._session]
        self._browser.call("Target.closeTarget", targetId=self._target)

    def run(self, script):
        """Return the value of an expression; that of a promise, once it is kept."""
        how = {"returnByValue": True, "awaitPromise": True}
        answer = self._call("Runtime.evaluate", expression=script, **how)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def click(self, x, y):
        """Press and release the left button at a place of the window."""
        for kind in ("mousePressed", "mouseReleased"):
            self._call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def _call(self, method, **parameters):
        return self._browser.call(method, self._session, **parameters)

    def _take(self, event):
        params = event.get("params", {})
        match event.get("method"):
            case "Runtime.exceptionThrown":
                self.errors.append(params["exceptionDetails"])
            case "Log.entryAdded" if params["entry"]["level"] == "error":
                self.errors.append(params["entry"]["text"])
            case "Network.requestWillBeSent":
                self.requests.append(params["request"]["url"])
            case "Page.loadEventFired":
                self._loaded = True
