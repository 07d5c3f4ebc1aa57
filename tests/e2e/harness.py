"""Starts the built binary, talks to it over plain sockets, and checks every answer against openapi.yaml."""

import atexit
import json
import math
import os
import re
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import jsonschema
import yaml

ROOT = Path(__file__).resolve().parents[2]
BINARY = os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build" / "meshgauge"))
OPENAPI = yaml.safe_load((ROOT / "openapi.yaml").read_text())
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_")}

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
RAISED = b"v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 2\nf 1 2 3\nf 1 3 4\n"


def flat_grid(n):
    """The unit square in n * n squares. Two of them are at distance 0, which bisection approaches for ever."""
    lines = ["v %r %r 0" % (i / n, j / n) for j in range(n + 1) for i in range(n + 1)]
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i + 1
            lines.append("f %d %d %d\nf %d %d %d" % (a, a + 1, a + n + 2, a, a + n + 2, a + n + 1))
    return ("\n".join(lines) + "\n").encode()


def wavy_grid(n, height):
    """The same square and squares, bent to waves of this height."""
    lines = ["v %r %r %r" % (x / n, y / n, height * math.sin(5 * x / n) * math.cos(7 * y / n))
             for y in range(n + 1) for x in range(n + 1)]
    corners = [y * (n + 1) + x + 1 for y in range(n) for x in range(n)]
    lines += ["f %d %d %d\nf %d %d %d" % (c, c + 1, c + n + 2, c, c + n + 2, c + n + 1) for c in corners]
    return ("\n".join(lines) + "\n").encode()


# Runs for at least ten seconds.
SLOW = dict(a=flat_grid(40), b=flat_grid(43))
SLOW_OPTIONS = {"strategy": "four_point", "tolerance": {"absolute": 0}, "timeout_ms": 100000}


def validate(value, schema_name):
    schema = {"$ref": "#/components/schemas/" + schema_name}
    resolver = jsonschema.RefResolver("", OPENAPI)
    jsonschema.Draft202012Validator(schema, resolver=resolver).validate(value)


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body)


def read_answer(stream, method="POST"):
    """The next final response on a socket's file; None when the server closed instead."""
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
    length = 0 if method == "HEAD" or status == 204 else int(headers["content-length"])
    return Answer(status, headers, stream.read(length))


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
    return ("POST /v1/comparisons HTTP/1.1\r\nHost: test\r\nContent-Length: %d\r\n%s"
            "Content-Type: multipart/form-data; boundary=XXboundaryXX\r\n\r\n" % (length, extra)).encode()


class Server:
    """A service of its own, with a data directory of its own unless `environment` or `flags` name one."""

    def __init__(self, *flags, environment=None, program=(BINARY,), user=None):
        self.data_dir = tempfile.TemporaryDirectory(prefix="meshgauge-data-", ignore_cleanup_errors=True)
        if user is not None:
            os.chown(self.data_dir.name, user, -1)
        kept = {"MESHGAUGE_DATA_DIR": os.path.join(self.data_dir.name, "data")}
        self.process = subprocess.Popen(
            [*program, "serve", "--port", "0", *flags], stderr=subprocess.PIPE,
            env={**ENVIRONMENT, **kept, **(environment or {})}, user=user)
        atexit.register(self.process.kill)  # a test that fails half-way must not leave it behind
        self.log = []
        self.started = json.loads(self.process.stderr.readline())
        assert self.started["event"] == "listening", self.started
        self.port = int(self.started["detail"].rsplit(":", 1)[1])
        self.reader = threading.Thread(target=self._read_log, daemon=True)
        self.reader.start()

    def _read_log(self):
        for line in self.process.stderr:
            self.log.append(line.decode())

    def connect(self, timeout=60, source=""):
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=timeout, source_address=(source, 0))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    def raw(self, data, method="POST", timeout=60):
        """Sends bytes on a new connection and returns the one answer, checked; None when there is none."""
        with self.connect(timeout) as connection:
            try:
                connection.sendall(data)
            except (ConnectionResetError, BrokenPipeError):
                pass  # refused while sending: the answer is there nevertheless
            answer = read_answer(connection.makefile("rb"), method)
        return check(answer)

    def compare(self, a=SQUARE, b=RAISED, options=b"{}"):
        body = comparison(a, b, options)
        return self.raw(post_head(len(body)) + body)

    def get(self, path, method="GET", extra=""):
        return self.raw(("%s %s HTTP/1.1\r\nHost: test\r\n%s\r\n" % (method, path, extra)).encode(), method)

    def stop(self, sign=signal.SIGTERM, timeout=60):
        if self.process.poll() is None:
            self.process.send_signal(sign)
        code = self.process.wait(timeout)
        self.reader.join()
        self.process.stderr.close()
        return code


def check(answer):
    """Every answer is a problem or a result of the shape that openapi.yaml promises."""
    if answer is None:
        return None
    assert re.fullmatch("[0-9a-f]{32}", answer.headers["x-request-id"]), answer.headers
    for name, value in (("x-content-type-options", "nosniff"), ("referrer-policy", "no-referrer")):
        assert answer.headers.get(name) == value, answer.headers
    assert answer.headers["cache-control"], answer.headers
    if answer.status >= 400:
        assert answer.headers["content-type"] == "application/problem+json", answer.headers
        if answer.body:
            problem = answer.json()
            validate(problem, "Problem")
            assert problem["status"] == answer.status
        assert answer.status not in (429, 503) or int(answer.headers["retry-after"]) >= 1
        assert answer.status != 405 or answer.headers["allow"]
    elif "server-timing" in answer.headers:
        assert answer.headers["content-type"] == "application/json"
        validate(answer.json(), "Comparison")
        assert answer.json()["id"] == answer.headers["x-request-id"]
    return answer


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
        self.assertEqual(answer.json()["type"], "urn:meshgauge:problem:" + slug)
        return answer.json()


def until(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
