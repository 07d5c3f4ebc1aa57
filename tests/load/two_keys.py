#!/usr/bin/python3
"""Measures small comparisons of one key while another key sends hard ones and stalled uploads.

The greedy key keeps a thousand hard comparisons wanted: it sends another one as soon as it may. Prints the modest key's
times without it and beside it.
"""
import argparse
import contextlib
import http.client
import json
import multiprocessing
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/load"))

from loadtest.service import Service  # noqa: E402

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"
RAISED = b"v 0 0 2\nv 1 0 2\nv 1 1 2\nf 1 2 3\n"
STALLED = 20
HARD = {"strategy": "four_point", "tolerance": {"absolute": 0, "relative": 0}, "timeout_ms": 20000}


def grid(cells):
    lines = ["v %r %r 0" % (i / cells, j / cells) for j in range(cells + 1) for i in range(cells + 1)]
    corners = [j * (cells + 1) + i + 1 for j in range(cells) for i in range(cells)]
    lines += ["f %d %d %d" % (c, c + 1, c + cells + 2) for c in corners]
    return "\n".join(lines).encode()


def form(a, b, options):
    parts = [("a", a), ("b", b), ("options", json.dumps(options).encode())]
    return b"".join(b'--X\r\nContent-Disposition: form-data; name="%s"; filename="%s.obj"\r\n\r\n%s\r\n' % (
        name.encode(), name.encode(), data) for name, data in parts) + b"--X--\r\n"


class Client:
    """One connection of one key."""

    def __init__(self, port, token):
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)
        self.headers = {"Authorization": "Bearer " + token, "Content-Type": "multipart/form-data; boundary=X"}

    def post(self, body, extra=()):
        self.connection.request("POST", "/v1/comparisons", body, {**self.headers, **dict(extra)})
        answer = self.connection.getresponse()
        answer.read()
        return answer.status


class Greedy:
    """Sends hard comparisons and keeps uploads that stall; in a process of its own, so that the other client does not wait for it."""

    def __init__(self, port, token):
        self.port, self.token, self.ended = port, token, multiprocessing.Event()
        self.sent, self.taken = multiprocessing.Value("i", 0), multiprocessing.Value("i", 0)
        self.process = multiprocessing.Process(target=self.send)
        self.process.start()

    def stall(self):
        connection = socket.create_connection(("127.0.0.1", self.port))
        connection.sendall(b"POST /v1/meshes HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer %s\r\nContent-Length: 50000000\r\n\r\n%s" % (
            self.token.encode(), b"#" * 1_000_000))
        return connection

    def send(self):
        stalled = [self.stall() for _ in range(STALLED)]
        client, body = Client(self.port, self.token), form(grid(40), grid(43), HARD)
        while not self.ended.wait(0 if self.sent.value < 1000 else 0.1):
            self.sent.value += 1
            self.taken.value += client.post(body, {"Prefer": "respond-async"}) == 202
        for connection in stalled:
            with contextlib.suppress(OSError):
                connection.close()

    def end(self):
        self.ended.set()
        self.process.join()


def measure(client, count):
    """The times of so many small comparisons, sorted, in ms."""
    times = []
    for _ in range(count):
        began = time.monotonic()
        status = client.post(form(SQUARE, RAISED, {}))
        times.append(1000 * (time.monotonic() - began))
        if status != 200:
            raise SystemExit(f"two_keys: the modest key got {status}")
    return sorted(times)


def show(name, times):
    print(f"{name}: median {times[len(times) // 2]:.1f} ms, p99 {times[len(times) * 99 // 100]:.1f} ms, slowest {times[-1]:.1f} ms", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--requests", type=int, default=500)
    parser.add_argument("--binary", default=os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build/meshgauge")))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/load", metavar="FOLDER")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    tokens, entries = {}, []
    for name in ("greedy", "modest"):
        tokens[name], entry = subprocess.run([args.binary, "keys", "new", name], capture_output=True, text=True, check=True).stdout.splitlines()
        entries.append({**json.loads(entry), "requests_per_minute": 10_000_000, "burst": 100_000, "max_jobs": 1000})
    with tempfile.NamedTemporaryFile("w", suffix=".json") as keys:
        json.dump({"keys": entries}, keys)
        keys.flush()
        service = Service(args.binary, ["--keys-file", keys.name, "--log-requests", "none", "--max-queued-jobs", "1000"], args.out / "two_keys.log")
        modest = Client(service.port, tokens["modest"])
        measure(modest, 50)
        show("alone", measure(modest, args.requests))
        greedy = Greedy(service.port, tokens["greedy"])
        while greedy.sent.value < 1000:
            time.sleep(0.01)
        show("beside the other key", measure(modest, args.requests))
        greedy.end()
        print(f"the other key: {greedy.taken.value} of {greedy.sent.value} hard comparisons were accepted")
        service.stop()


if __name__ == "__main__":
    main()
