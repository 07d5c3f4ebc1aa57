"""Starts the built binary and talks to it over sockets; every answer that is read is held against openapi.yaml."""

import atexit
import contextlib
import json
import math
import os
import signal
import socket
import ssl
import stat
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import contract
import wire
from contract import ROOT, validate  # noqa: F401  validate: for the tests

sys.path.append(str(ROOT / "tests/cluster"))
from scratch import free_port  # noqa: E402, F401  for the tests

# Services of tests are on this machine: no proxy stands between, unless a test says so.
for variable in [name for name in os.environ if name.lower().endswith("_proxy")]:
    del os.environ[variable]

BINARY = os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build" / "meshgauge"))
# The program would write annotations for the workflow that runs the tests.
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_") and k != "GITHUB_ACTIONS"}
OWN = tempfile.gettempdir()
EVERYBODYS = OWN if os.stat(OWN).st_mode & stat.S_ISVTX else "/tmp"  # TMPDIR may be closed to other users
SCRATCH = tempfile.TemporaryDirectory(prefix="meshgauge-data-", ignore_cleanup_errors=True)
# For a service that a test starts by itself: tests run beside each other, and a data directory is one service's.
OWN_DATA = {**ENVIRONMENT, "MESHGAUGE_DATA_DIR": os.path.join(SCRATCH.name, "data")}

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
RAISED = b"v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 2\nf 1 2 3\nf 1 3 4\n"


def flat_grid(n):
    """The unit square in n * n squares. Two of them are at distance 0, which bisection approaches for ever."""
    places = [repr(i / n) for i in range(n + 1)]
    lines = ["v %s %s 0" % (x, y) for y in places for x in places]
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i + 1
            lines.append("f %d %d %d\nf %d %d %d" % (a, a + 1, a + n + 2, a, a + n + 2, a + n + 1))
    return ("\n".join(lines) + "\n").encode()


def wavy_grid(n, height):
    """The square of flat_grid(), bent to waves of this height."""
    lines = ["v %r %r %r" % (x / n, y / n, height * math.sin(5 * x / n) * math.cos(7 * y / n))
             for y in range(n + 1) for x in range(n + 1)]
    corners = [y * (n + 1) + x + 1 for y in range(n) for x in range(n)]
    lines += ["f %d %d %d\nf %d %d %d" % (c, c + 1, c + n + 2, c, c + n + 2, c + n + 1) for c in corners]
    return ("\n".join(lines) + "\n").encode()


# Runs for at least ten seconds.
SLOW = dict(a=flat_grid(40), b=flat_grid(43))
SLOW_OPTIONS = {"strategy": "four_point", "tolerance": {"absolute": 0}, "timeout_ms": 100000}
ASYNC = "Prefer: respond-async\r\n"
ENDED = ("done", "failed", "cancelled")


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body)


def read_answer(stream):
    """The next final response on a socket's file, which openapi.yaml must allow; None when the server closed instead."""
    while True:
        line = stream.readline()
        if not line:
            return None
        status = int(line.split()[1])
        headers = {}
        while (line := stream.readline()) not in (b"\r\n", b""):
            name, value = line.decode("latin-1").split(":", 1)
            assert name.lower() not in headers, "header twice: " + name
            headers[name.lower()] = value.strip()
        if status != 100:
            break
    request = wire.request_of(stream)
    answer = Answer(status, headers, read_body(stream, status, headers, request and request.method))
    contract.check(request, answer)
    return answer


def read_body(stream, status, headers, method):
    if method == "HEAD" or status in (204, 304):
        return b""
    if "transfer-encoding" not in headers:
        return stream.read(int(headers["content-length"]))
    body = b""
    while size := int(stream.readline(), 16):
        body += stream.read(size)
        stream.readline()
    return body


def multipart(parts, boundary=b"XXboundaryXX"):
    body = b""
    for name, data in parts:
        extra = b'; filename="%s.obj"' % name.encode() if name in ("a", "b") else b""
        body += b"--%s\r\nContent-Disposition: form-data; name=\"%s\"%s\r\n\r\n%s\r\n" % (
            boundary, name.encode(), extra, data)
    return body + b"--%s--\r\n" % boundary


def comparison(a=SQUARE, b=RAISED, options=b"{}"):
    if isinstance(options, (dict, list)):
        options = json.dumps(options).encode()
    return multipart([("a", a), ("b", b), ("options", options)])


def post_head(length, extra=""):
    return ("POST /v1/comparisons HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n%s"
            "Content-Type: multipart/form-data; boundary=XXboundaryXX\r\n\r\n" % (length, extra)).encode()


class Server:
    """A service of its own, with a data directory of its own unless `environment` or `flags` name one."""

    def __init__(self, *flags, environment=None, program=(BINARY,), user=None):
        where = None if user is None else EVERYBODYS
        self.data_dir = tempfile.TemporaryDirectory(prefix="meshgauge-data-", dir=where, ignore_cleanup_errors=True)
        reach = {}
        if user is not None:
            os.chown(self.data_dir.name, user, -1)
            reach["TMPDIR"] = EVERYBODYS
        # However full the disk of the tests is, maps are kept; however slow their machine is, comparisons end.
        kept = {"MESHGAUGE_DATA_DIR": os.path.join(self.data_dir.name, "data"), "MESHGAUGE_MAP_CACHE_ROOM_BYTES": "0",
                "MESHGAUGE_DEFAULT_TIMEOUT_MS": "180000"}
        self.process = subprocess.Popen(
            [*program, "serve", "--port", "0", *flags], stderr=subprocess.PIPE,
            env={**ENVIRONMENT, **reach, **kept, **(environment or {})}, user=user)
        atexit.register(self.process.kill)  # a test that fails half-way must not leave it behind
        self.log = []
        self.started = self._read_start()
        self.port = int(self.started["detail"].rsplit(":", 1)[1])
        self.reader = threading.Thread(target=self._read_log, daemon=True)
        self.reader.start()

    def _read_start(self):
        """Reads the log line with the port. A client that knows the port may connect before the line is written."""
        while b'"event":"request"' in (line := self.process.stderr.readline()):
            self.log.append(line.decode())
        if b'"listening"' not in line:
            self.process.kill()
            raise AssertionError(line + self.process.stderr.read())
        return json.loads(line)

    def _read_log(self):
        for line in self.process.stderr:
            self.log.append(line.decode())

    def connect(self, timeout=60, source=""):
        connection = wire.connect(("127.0.0.1", self.port), timeout, (source, 0))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    def raw(self, data, timeout=60):
        """Sends bytes on a new connection and returns the one answer; None when there is none."""
        with self.connect(timeout) as connection:
            try:
                connection.sendall(data)
            except (ConnectionResetError, BrokenPipeError):
                pass  # refused while sending: the answer is there nevertheless
            return read_answer(connection.makefile("rb"))

    def compare(self, a=SQUARE, b=RAISED, options=b"{}", extra=""):
        body = comparison(a, b, options)
        return self.raw(post_head(len(body), extra) + body)

    def get(self, path, method="GET", extra=""):
        return self.raw(("%s %s HTTP/1.1\r\nHost: localhost\r\n%s\r\n" % (method, path, extra)).encode())

    def send(self, method, path, body=b"", extra=""):
        """A request with a body."""
        return self.raw(("%s %s HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n%s\r\n"
                         % (method, path, len(body), extra)).encode() + body)

    def stop(self, sign=signal.SIGTERM, timeout=60):
        if self.process.poll() is None:
            self.process.send_signal(sign)
        code = self.process.wait(timeout)
        self.reader.join()
        self.process.stderr.close()
        return code


class ServerCase(unittest.TestCase):
    flags = ()

    @classmethod
    def setUpClass(cls):
        cls.server = Server(*cls.flags)

    @classmethod
    def tearDownClass(cls):
        code = cls.server.stop()
        assert code == 0, "exit %d\n%s" % (code, "".join(cls.server.log))

    def tearDown(self):
        """Whatever a test did, the next request is served."""
        self.assertEqual(self.server.get("/healthz").status, 200)

    def refused(self, answer, status, slug):
        self.assertIsNotNone(answer)
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.json()["type"], "/problems/" + slug)
        return answer.json()


def holding_the_worker(server):
    """The connection of a slow comparison that has the only place of a service."""
    body = comparison(**SLOW, options=SLOW_OPTIONS)

    def holds():
        """A small comparison is refused. When it came first, it was the slow one: that is sent again."""
        connection = server.connect()
        with contextlib.suppress(ConnectionError, ssl.SSLError):
            connection.sendall(post_head(len(body)) + body)
            if server.compare().status == 503:
                return connection
        connection.close()
        return None
    return until(holds)


def until(condition, seconds=60):
    """Waits until the condition holds; returns its value."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
    return found


def processor_seconds(process):
    return time.clock_gettime(~process.pid << 3 | 2)  # the clock that clock_getcpuclockid() names


def until_computing(process, seconds=0.5):
    """Waits until the process has used so much processor time from now on, however busy the machine is."""
    end = processor_seconds(process) + seconds
    until(lambda: process.poll() is not None or processor_seconds(process) >= end)


def occupy_guests(server, running):
    """A connection from another address, whose comparison has the thread for clients with nothing running; then so many run."""
    body = comparison(**SLOW, options=SLOW_OPTIONS)
    connection = server.connect(source="127.0.0.9")
    connection.sendall(post_head(len(body)) + body)
    until(lambda: b"\nmeshgauge_jobs_running %d\n" % running in server.get("/metrics").body)
    return connection


def begin_slow(server, extra=ASYNC, timeout_ms=100000):
    """The path of a comparison that runs for long, and its document."""
    answer = server.compare(**SLOW, options={**SLOW_OPTIONS, "timeout_ms": timeout_ms}, extra=extra)
    assert answer.status == 202, answer.body
    return answer.headers["location"], answer.json()


def wait_for(server, path, *states):
    job = {}

    def there():
        job.update(server.get(path).json())
        return job["state"] in states
    until(there)
    return job
