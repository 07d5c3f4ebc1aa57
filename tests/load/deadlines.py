#!/usr/bin/python3
"""Measures how late comparisons end: after timeout_ms, DELETE, SIGTERM, and when their client goes.

The meshes are those on which a search, a query or the building of a tree takes longest between two looks at the clock.
The service has one worker, and its thread for other clients. Prints a row for each pair and strategy: the largest lateness of all runs, in ms.
"""
import argparse
import http.client
import json
import math
import os
import pathlib
import random
import select
import signal
import struct
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/load"), str(ROOT / "tests/chaos")]

from loadtest.service import Service  # noqa: E402
from seeds import seed  # noqa: E402

STRATEGIES = (("auto", None), ("four_point", None), ("n_point", 4), ("n_point", 1585), ("triangle_set", None))
ALLOWED = (200, 409, 413, 422, 503)  # what a comparison that is cut short may be answered with
TRIANGLE = struct.Struct("<12fH")
COLUMNS = ("uploaded", "stored", "queued", "deleted", "left", "terminated")


def sheets(n, dice):
    """One large triangle, again and again, a little above each other: every one is near every point."""
    return [(0, 0, i * 1e-7, 1, 0, i * 1e-7, 0, 1, i * 1e-7) for i in range(n)]


def needles(n, dice):
    """Long and thin in all directions: their boxes overlap."""
    made = []
    for _ in range(n):
        x, y, z = (dice.uniform(-1, 1) for _ in range(3))
        made.append((x, y, z, -x, -y, -z, x + 1e-6, y, z))
    return made


def direction(dice):
    """A random vector of length 1."""
    x, y, z = (dice.gauss(0, 1) for _ in range(3))
    size = math.hypot(x, y, z)
    return x / size, y / size, z / size


def star(n, dice):
    """All share a corner."""
    made = []
    for _ in range(n):
        x, y, z = direction(dice)
        made.append((0, 0, 0, x, y, z, x + 0.01, y - 0.01, z))
    return made


def degenerate(n, dice):
    """Points and segments alone."""
    made = []
    for i in range(n):
        p = tuple(dice.uniform(0, 1) for _ in range(3))
        q = tuple(dice.uniform(0, 1) for _ in range(3)) if i % 2 else p
        made.append((*p, *q, *p))
    return made


def equidistant(n, dice):
    """A sphere around the other mesh, which is as near to one of them as to any other."""
    made = []
    for _ in range(n):
        x, y, z = (100 * each for each in direction(dice))
        made.append((x, y, z, x + 0.1, y, z, x, y + 0.1, z))
    return made


def grid(cells):
    """A square of 2 * cells * cells triangles."""
    made = []
    for i in range(cells):
        for j in range(cells):
            x, y, X, Y = i / cells, j / cells, (i + 1) / cells, (j + 1) / cells
            made += [(x, y, 0.5, X, y, 0.5, X, Y, 0.5), (x, y, 0.5, X, Y, 0.5, x, Y, 0.5)]
    return made


SHAPES = (sheets, needles, star, degenerate, equidistant)


def stl(triangles):
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(TRIANGLE.pack(0, 0, 0, *t, 0) for t in triangles)


def form(a, b, options):
    parts = [("a", a), ("b", b), ("options", json.dumps(options).encode())]
    return b"".join(b'--X\r\nContent-Disposition: form-data; name="%s"; filename="%s.stl"\r\n\r\n%s\r\n' % (
        name.encode(), name.encode(), data) for name, data in parts) + b"--X--\r\n"


class Client:
    def __init__(self, port):
        self.port = port

    def send(self, method, path, body=b"", headers=()):
        """The connection, and when the request was sent."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=300)
        connection.request(method, path, body, dict(headers))
        return connection, time.monotonic()

    def ask(self, method, path, body=b"", headers=()):
        """Status, document, and seconds since the request was sent."""
        connection, sent = self.send(method, path, body, headers)
        answer = connection.getresponse()
        text = answer.read()
        took = time.monotonic() - sent
        connection.close()
        return answer.status, json.loads(text) if text else None, took

    def store(self, mesh):
        return self.ask("POST", "/v1/meshes", mesh, {"Content-Disposition": 'attachment; filename="m.stl"'})[1]["id"]

    def compare(self, a, b, options, extra=()):
        return "POST", "/v1/comparisons", json.dumps({"a": a, "b": b, "options": options}).encode(), {
            "Content-Type": "application/json", **dict(extra)}


class Trial:
    def __init__(self, args, pair, strategy):
        self.args, self.pair, self.files = args, pair, [stl(mesh) for mesh in pair]
        name, points = strategy
        self.options = {"strategy": name, "tolerance": {"absolute": 0, "relative": 0}, "timeout_ms": args.timeout_ms}
        if points:
            self.options["points"] = points
        self.late = dict.fromkeys(COLUMNS, -math.inf)

    def note(self, column, seconds):
        self.late[column] = max(self.late[column], 1000 * seconds)

    def service(self):
        return Service(self.args.binary, ["--workers", "1", "--grace-ms", "300", "--log-requests", "none", *self.args.serve.split()],
                       self.args.out / "service.log")

    def in_time(self, column, answered):
        status, document, took = answered
        if status not in ALLOWED:
            raise SystemExit(f"deadlines: {column}: {status} {document}")
        self.note(column, took - self.args.timeout_ms / 1000)

    def run(self):
        service = self.service()
        self.client = Client(service.port)
        ids = [self.client.store(file) for file in self.files]
        for _ in range(self.args.runs):
            body = form(*self.files, self.options)
            self.in_time("uploaded", self.client.ask("POST", "/v1/comparisons", body, {"Content-Type": "multipart/form-data; boundary=X"}))
            self.in_time("stored", self.client.ask(*self.client.compare(*ids, self.options)))
            self.hold(ids)
        self.terminate(service, ids)
        return self.late

    def begin(self, ids):
        """A stored comparison that runs, or None when it has ended at once."""
        long = {**self.options, "timeout_ms": 100_000}
        path = "/v1/comparisons/" + self.client.ask(*self.client.compare(*ids, long, {"Prefer": "respond-async"}))[1]["id"]
        while (job := self.client.ask("GET", path)[1])["state"] == "queued":
            time.sleep(0.002)
        return path if job["state"] == "running" else None

    def ended(self, path):
        document = self.client.ask("GET", path)[1]  # a problem when the comparison was deleted
        return document.get("state") not in ("queued", "running")

    def hold(self, ids):
        """A request that waits while others have both threads; then one of those is deleted, and the other's client goes."""
        path = self.begin(ids)
        waits = self.wait_beside(path, ids)
        if path and not self.ended(path):
            self.in_time("queued", self.client.ask(*self.client.compare(*ids, self.options)))
            began = time.monotonic()
            self.client.ask("DELETE", path)
            while not self.ended(path):
                time.sleep(0.002)
            self.note("deleted", time.monotonic() - began)
        waits.close()
        went = time.monotonic()
        while self.samples("jobs_running") > 0:
            time.sleep(0.005)
        self.note("left", time.monotonic() - went)

    def wait_beside(self, path, ids):
        """The connection of a client whose comparison runs or waits, beside the one of the path while that runs, or has ended."""
        waits, _ = self.client.send(*self.client.compare(*ids, {**self.options, "timeout_ms": 100_000}))
        while not select.select([waits.sock], [], [], 0)[0]:
            if self.samples("jobs_running", "queue_depth") >= (2 if path and not self.ended(path) else 1):
                break
            time.sleep(0.005)
        return waits

    def samples(self, *names):
        """Their sum."""
        connection, _ = self.client.send("GET", "/metrics")
        text = connection.getresponse().read().decode()
        connection.close()
        return sum(float(text.split(f"\nmeshgauge_{name} ", 1)[1].split("\n", 1)[0]) for name in names)

    def terminate(self, service, ids):
        waits = self.wait_beside(self.begin(ids), ids)
        began = time.monotonic()
        service.process.send_signal(signal.SIGTERM)
        status = waits.getresponse().status
        if service.process.wait(100) != 0 or status not in ALLOWED:
            raise SystemExit(f"deadlines: after SIGTERM: {status}")
        self.note("terminated", time.monotonic() - began - 0.3)
        service.data.cleanup()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--triangles", type=int, default=1_000_000, help="of the large mesh of a pair")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--timeout-ms", type=int, default=1500)
    parser.add_argument("--shapes", default=",".join(shape.__name__ for shape in SHAPES))
    parser.add_argument("--strategies", default=",".join(sorted({name for name, _ in STRATEGIES})))
    parser.add_argument("--cases", type=int, metavar="N", help="only so many pairs of a shape and a strategy, drawn by the seed")
    parser.add_argument("--seed", type=seed, default=1, help="`today`: the date")
    parser.add_argument("--serve", default="", metavar="FLAGS", help="further flags of meshgauge serve")
    parser.add_argument("--binary", default=os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build/meshgauge")))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/load", metavar="FOLDER")
    return parser.parse_args()


def main():
    args = arguments()
    args.out.mkdir(parents=True, exist_ok=True)
    chosen = [(shape, strategy) for shape in SHAPES if shape.__name__ in args.shapes.split(",")
              for strategy in STRATEGIES if strategy[0] in args.strategies.split(",")]
    if args.cases is not None:
        print(f"seed {args.seed}")
        dice = random.Random(args.seed)
        chosen = [chosen[i] for i in sorted(dice.sample(range(len(chosen)), min(args.cases, len(chosen))))]
    print("| mesh | strategy | " + " | ".join(COLUMNS) + " |\n|---|---|" + "--:|" * len(COLUMNS))
    made, pair = None, None
    for shape, strategy in chosen:
        if shape is not made:
            made, pair = shape, (grid(4), shape(args.triangles, random.Random(1)))
        late = Trial(args, pair, strategy).run()
        name = strategy[0] + (f" {strategy[1]}" if strategy[1] else "")
        cells = ["–" if late[c] == -math.inf else f"{late[c]:.0f}" for c in COLUMNS]
        print(f"| {shape.__name__} | {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
