"""A service that is killed again and again, and a client for it that survives that."""

import functools
import http.client
import json
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARY = os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build" / "meshgauge"))
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_")}
START_SECONDS = 60
ANSWER_SECONDS = 60


class Gone(Exception):
    """The service ended before its answer: the request may have taken effect or not."""


class Victim:
    """One process of the service. `log`: its newest lines, which are read while `read_on` is set; `lines`: how many there were."""

    def __init__(self, *flags, command="serve"):
        self.process = subprocess.Popen([BINARY, command, "--port", "0", *flags], stderr=subprocess.PIPE, env=ENVIRONMENT)
        self.log, self.lines = [], 0
        self.read_on = threading.Event()
        self.read_on.set()
        before = b""
        line = self._next()
        while line.get("event") not in ("listening", None):  # of a schema that was migrated, a sandbox that lacks something
            before += json.dumps(line).encode() + b"\n"
            line = self._next()
        if line.get("event") != "listening":
            self.process.kill()
            rest = self.process.communicate()[1]
            raise AssertionError("it does not start: %s" % (before + line["text"] + rest).decode())
        self.port = int(line["detail"].rsplit(":", 1)[1])
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _next(self):
        """The next line of the log; of another text {"text": ...}."""
        text = self.process.stderr.readline()
        return json.loads(text) if text.startswith(b"{") else {"text": text}

    def _read(self):
        for line in self.process.stderr:
            self.log = self.log[-200:] + [line.decode()]
            self.lines += 1
            self.read_on.wait()

    def kill(self):
        """Kills with -9. An earlier end by any other cause is a defect."""
        self.process.kill()
        code = self.process.wait()
        self._close()
        if code != -signal.SIGKILL:
            raise AssertionError("it ended by itself: %d\n%s" % (code, "".join(self.log)))

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(60)
        self._close()
        if code != 0:
            raise AssertionError("exit %d\n%s" % (code, "".join(self.log)))

    def _close(self):
        self.reader.join()
        self.process.stderr.close()


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body)

    @property
    def problem(self):
        return self.json()["type"].rpartition("/")[2] if self.status >= 400 else ""


def ask(port, method, path, body=None, headers=None):
    """One request on a connection of its own."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=ANSWER_SECONDS)
    try:
        connection.request(method, path, body, headers or {})
        response = connection.getresponse()
        return Answer(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
    except (OSError, http.client.HTTPException) as error:
        raise Gone(str(error)) from None
    finally:
        connection.close()


def multipart(a, b, options):
    body = b""
    for name, data in (("a", a), ("b", b), ("options", json.dumps(options).encode())):
        extra = b'; filename="%s.obj"' % name.encode() if name != "options" else b""
        body += b"--xyz\r\nContent-Disposition: form-data; name=\"%s\"%s\r\n\r\n%s\r\n" % (name.encode(), extra, data)
    return body + b"--xyz--\r\n"


FORM = {"Content-Type": "multipart/form-data; boundary=xyz"}
JSON = {"Content-Type": "application/json"}
ASYNC = {"Prefer": "respond-async"}


def square(height, n=1, salt=""):
    """The unit square at this height, in n * n squares. Two of them are exactly as far apart as their heights are."""
    return b"# " + salt.encode() + b"\n" + grid(height, n)


@functools.lru_cache(64, typed=True)  # 0 and 0.0 are written differently
def grid(height, n):
    lines = ["v %r %r %r" % (x / n, y / n, height) for y in range(n + 1) for x in range(n + 1)]
    corners = [y * (n + 1) + x + 1 for y in range(n) for x in range(n)]
    lines += ["f %d %d %d\nf %d %d %d" % (c, c + 1, c + n + 2, c, c + n + 2, c + n + 1) for c in corners]
    return ("\n".join(lines) + "\n").encode()


# Two flat squares in different grids are at distance 0, which bisection approaches for ever.
ENDLESS = {"strategy": "four_point", "tolerance": {"absolute": 0}}


def until(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
