"""Measures gates, in process or by a service, as a program would; and what stands between a client and a service."""

import http.client
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from harness import BINARY, ENVIRONMENT, ROOT, Server, until

sys.path.append(str(ROOT / "tests/cluster"))
from scratch import free_port  # noqa: E402

MEGABYTE = 1 << 20
MEASURE = os.environ.get("MESHGAUGE_MEASURE_GATES", str(ROOT / "build" / "tests" / "check" / "remote" / "measure_gates"))


def url_of(server, host="127.0.0.1", scheme="http"):
    return "%s://%s:%d" % (scheme, host, server.port)


def server_at(port, data, *flags):
    """A service at a port of free_port(), which is still free when the service is started again there."""
    program = ("/bin/sh", "-c", 'shift 3; exec "%s" serve --port %d "$@"' % (BINARY, port), "sh")
    return Server(*flags, program=program, environment={"MESHGAUGE_DATA_DIR": data})


def gate(name, candidate, baseline, options=None, **asked):
    """`asked` and `options`: members of the request; None: without it. Without narrowing: how far that gets depends on the
    time that it takes."""
    request = {"max_distance": 0.5, "narrow": False, "timeout_ms": 60_000, **asked, **(options or {})}
    return {"name": name, "candidate": str(candidate), "baseline": str(baseline),
            "options": {member: value for member, value in request.items() if value is not None}}


class Run:
    """One run of all gates. `service`: its settings, or None to measure here."""

    def __init__(self, gates, service=None, environment=None):
        self.process = subprocess.Popen([MEASURE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, env={**ENVIRONMENT, **(environment or {})})
        self.process.stdin.write(json.dumps({"service": service, "gates": gates}))
        self.process.stdin.close()
        self.process.stdin = None
        self.progress = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.progress.append(line.split())

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)

    def ended(self):
        """The outcomes; a string when the run was refused. `peak`: the most memory, in bytes."""
        answer = json.loads(self.process.stdout.read())
        code = self.process.wait()
        self.reader.join()
        self.process.stdout.close()
        self.process.stderr.close()
        assert code == (3 if "refused" in answer else 0), "exit %d" % code
        self.peak = answer.get("peak_bytes")
        return answer.get("outcomes", answer.get("refused"))

    def takes_little(self):
        """Whether its memory stayed bounded; a sanitizer's own is more than any bound."""
        return self.peak < 100 * MEGABYTE or bool(os.environ.get("MESHGAUGE_SANITIZED"))


def measure(gates, service=None, environment=None):
    """The outcomes by name, each gate once."""
    outcomes = Run(gates, service, environment).ended()
    assert isinstance(outcomes, list), outcomes
    assert [o["name"] for o in outcomes] == [g["name"] for g in gates]
    return {o["name"]: o for o in outcomes}


def without_chance(document):
    """What two measurements of the same meshes have in common."""
    kept = {k: v for k, v in document.items() if k not in ("id", "timings_ms")}
    kept["engine"] = {k: v for k, v in document["engine"].items() if k != "threads"}
    return kept


def requests(server, method, prefix=""):
    lines = (json.loads(line) for line in list(server.log))
    return [line for line in lines if line.get("event") == "request" and line["method"] == method
            and line["path"].startswith(prefix)]


def count_of(server, method, count):
    """Waits until the log has `count` requests of a method, and returns their number: a line follows its answer."""
    until(lambda: len(requests(server, method)) >= count)
    return len(requests(server, method))


class Relay:
    """An HTTP server that hands requests on to a service, or does something else first: `meddle(handler, seen)` gets
    the handler and how often this method and path, up to /v1/x, came before; True: it has answered."""

    def __init__(self, upstream, meddle=lambda handler, seen: False):
        relay = self
        self.upstream, self.meddle = upstream, meddle
        self.seen = {}
        self.headers = []
        self.lock = threading.Lock()

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def log_message(self, *arguments):
                pass

            def handle_one_request(self):
                try:
                    super().handle_one_request()
                except (ConnectionError, TimeoutError, http.client.HTTPException):
                    self.close_connection = True

            def serve(self):
                self.body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                self.path = "/" + self.path.split("/", 3)[3] if self.path.startswith("http://") else self.path
                name = (self.command, "/".join(self.path.split("/")[:3]))
                with relay.lock:
                    before = relay.seen.get(name, 0)
                    relay.seen[name] = before + 1
                    relay.headers.append((self.command, self.path, dict(self.headers)))
                if not relay.meddle(self, before):
                    self.answer(*relay.forward(self))

            def answer(self, status, headers, body):
                self.send_response_only(status)
                for key, value in headers.items():
                    self.send_header(key, value)
                if "Content-Length" not in headers:
                    self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(b"" if self.command == "HEAD" else body)

            def drop(self):
                """Resets the connection."""
                self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                self.close_connection = True
                self.connection.close()

            do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = serve

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.port = self.server.server_address[1]
        threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True).start()

    def change_results(self, change):
        """Meddles with the results of batches: `change` gets each line and returns what is sent in its place."""
        def meddle(handler, seen):
            if not handler.path.endswith("/results.jsonl"):
                return False
            status, headers, body = self.forward(handler)
            lines = [json.dumps(change(json.loads(line))).encode() + b"\n" for line in body.splitlines()]
            handler.answer(status, {"Content-Type": headers["Content-Type"]}, b"".join(lines))
            return True
        self.meddle = meddle

    def forward(self, handler):
        connection = http.client.HTTPConnection("127.0.0.1", self.upstream, timeout=60)
        headers = {k: v for k, v in handler.headers.items() if k.lower() not in ("connection", "expect", "proxy-connection")}
        connection.request(handler.command, handler.path, handler.body or None, headers)
        response = connection.getresponse()
        body = response.read()
        connection.close()
        kept = {k: v for k, v in response.getheaders() if k.lower() not in ("connection", "keep-alive", "transfer-encoding")}
        return response.status, kept, body

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.server.shutdown()
        self.server.server_close()


def without_batches(handler, seen):
    """Makes a relay look like a service without batches."""
    if handler.path.startswith("/v1/batches"):
        problem = {"type": "/problems/not-found", "title": "t", "status": 404, "detail": "no such path", "errors": []}
        handler.answer(404, {"Content-Type": "application/problem+json"}, json.dumps(problem).encode())
        return True
    return False


class FlakyProxy:
    """Bytes to and from a service over connections that break or stall at random; every few are left alone, but never the first."""

    def __init__(self, upstream, seed):
        self.upstream = upstream
        self.random = random.Random(seed)
        self.broken = 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        fate, after = "break", 1
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(client, fate, after), daemon=True).start()
            fate, after = self.random.choice(["serve", "refuse", "break", "break", "stall"]), self.random.randrange(1, 3000)

    def _serve(self, client, fate, after):
        if fate == "refuse":
            return self._break(client)
        server = socket.create_connection(("127.0.0.1", self.upstream))
        room = [after if fate != "serve" else 1 << 40]
        threading.Thread(target=self._pump, args=(client, server, room, fate), daemon=True).start()
        self._pump(server, client, room, fate)

    def _pump(self, source, sink, room, fate):
        try:
            while data := source.recv(65536):
                sink.sendall(data[:room[0]])
                room[0] -= len(data)
                if room[0] <= 0:
                    self.broken += 1
                    if fate == "stall":
                        return time.sleep(20)
                    self._break(source)
                    return self._break(sink)
            sink.shutdown(socket.SHUT_WR)
        except OSError:
            pass

    @staticmethod
    def _break(connection):
        try:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        except OSError:
            pass
        connection.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.listener.close()


class Stub:
    """Answers each client that sends something with these bytes, in pieces; then closes the connection."""

    def __init__(self, pieces, pause=0.0):
        self.pieces, self.pause = pieces, pause
        self.connections = 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            self.connections += 1
            threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client):
        try:
            with client:
                client.recv(65536)
                for piece in self.pieces():
                    client.sendall(piece)
                    time.sleep(self.pause)
        except OSError:
            pass

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.listener.close()
