#!/usr/bin/python3
"""Sends many large meshes in small gzip files at once to a service whose control group has little memory.

Counts the answers, which may be 200, 413 and 503 alone, and asks for /healthz meanwhile. Needs the right to make a
control group; with --no-group the service is told its limit by --max-memory-bytes instead.
"""
import argparse
import collections
import contextlib
import gzip
import http.client
import multiprocessing
import os
import pathlib
import struct
import sys
import time
from concurrent.futures import ThreadPoolExecutor

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/load"))

from loadtest.service import Service  # noqa: E402

VERSION_1, VERSION_2 = pathlib.Path("/sys/fs/cgroup/memory"), pathlib.Path("/sys/fs/cgroup")
ALLOWED = {200, 413, 503}
CELLS = 200  # of a row of the grid


def bomb(triangles):
    """A gzip-compressed binary STL of so many triangles: a grid whose rows come four times each."""
    low, high = struct.pack("<f", 1234.5), struct.pack("<f", 5432.25)
    row = b"".join(struct.pack("<3f", 0, 0, 1) + struct.pack("<f", x) + low + bytes(4) + struct.pack("<f", x + 1) + low + bytes(4)
                   + struct.pack("<f", x + (i % 2)) + high + bytes(6) for i in range(2) for x in range(CELLS))
    rows = triangles // (2 * CELLS)
    head = bytes(80) + struct.pack("<I", rows * 2 * CELLS)
    with_y = (row.replace(low, struct.pack("<f", y // 4)).replace(high, struct.pack("<f", y // 4 + 1)) for y in range(rows))
    return gzip.compress(head + b"".join(with_y), 6)


class Group:
    """A control group with a limit of memory, of version 1 or 2."""

    def __init__(self, limit):
        self.first = VERSION_1.exists()
        self.path = (VERSION_1 if self.first else VERSION_2) / f"meshgauge-bombs-{os.getpid()}"
        self.path.mkdir()
        self.write("memory.limit_in_bytes" if self.first else "memory.max", limit)

    def write(self, name, value):
        (self.path / name).write_text(str(value))

    def read(self, name):
        return (self.path / name).read_text()

    def enter(self):
        self.write("cgroup.procs", os.getpid())

    def peak(self):
        return int(self.read("memory.max_usage_in_bytes" if self.first else "memory.peak"))

    def kills(self):
        text = self.read("memory.oom_control" if self.first else "memory.events")
        return int(dict(line.split() for line in text.splitlines()).get("oom_kill", 0))

    def remove(self):
        self.path.rmdir()


def post(port, body):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=600)
    try:
        with contextlib.suppress(ConnectionError):  # refused while it sends: the answer is there nevertheless
            connection.request("POST", "/v1/comparisons", body, {"Content-Type": "multipart/form-data; boundary=X"})
        return connection.getresponse().status
    except OSError as error:
        return type(error).__name__
    finally:
        connection.close()


class Health:
    """Asks for /healthz ten times a second, in a process of its own: the clients' work must not count."""

    def __init__(self, port):
        self.port, self.times, self.failed, self.ended = port, [], 0, multiprocessing.Event()
        self.found = multiprocessing.SimpleQueue()
        self.process = multiprocessing.Process(target=self.ask)
        self.process.start()

    def ask(self):
        while not self.ended.wait(0.1):
            began = time.monotonic()
            connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
            try:
                connection.request("GET", "/healthz")
                self.failed += connection.getresponse().status != 200
            except OSError:
                self.failed += 1
            connection.close()
            self.times.append(time.monotonic() - began)
        self.found.put((self.times, self.failed))

    def end(self):
        self.ended.set()
        self.times, self.failed = self.found.get()
        self.process.join()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--bombs", type=int, default=100)
    parser.add_argument("--triangles", type=int, default=10_000_000, help="of each mesh of a pair")
    parser.add_argument("--limit", type=int, default=4_000_000_000, metavar="BYTES")
    parser.add_argument("--no-group", action="store_true")
    parser.add_argument("--clients", type=int, default=100, help="at the same time")
    parser.add_argument("--timeout-ms", type=int, default=30_000)
    parser.add_argument("--serve", default="", metavar="FLAGS", help="further flags of meshgauge serve")
    parser.add_argument("--binary", default=os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build/meshgauge")))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/load", metavar="FOLDER")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    mesh = bomb(args.triangles)
    body = b"".join(b'--X\r\nContent-Disposition: form-data; name="%s"; filename="m.stl.gz"\r\n\r\n%s\r\n' % (part, mesh)
                    for part in (b"a", b"b"))
    body += b'--X\r\nContent-Disposition: form-data; name="options"\r\n\r\n{"timeout_ms": %d}\r\n--X--\r\n' % args.timeout_ms
    group = None if args.no_group else Group(args.limit)
    flags = ["--max-memory-bytes", str(args.limit)] if args.no_group else []
    launcher = None if args.no_group else group.enter
    service = Service(args.binary, [*flags, *args.serve.split()], args.out / "bombs.log", launcher)
    print(f"{args.bombs} pairs of 2 x {args.triangles} triangles, {len(body) / 1e6:.1f} MB each; limit {args.limit / 1e9:.1f} GB")
    health = Health(service.port)
    began = time.monotonic()
    with ThreadPoolExecutor(args.clients) as pool:
        answers = collections.Counter(pool.map(lambda _: post(service.port, body), range(args.bombs)))
    took = time.monotonic() - began
    health.end()
    alive = service.process.poll() is None
    print("answers:", dict(answers), f"in {took:.0f} s")
    print(f"health: {len(health.times)} asked, {health.failed} failed, slowest {1000 * max(health.times):.0f} ms")
    if group:
        print(f"memory: peak of the group {group.peak() / 1e9:.2f} GB, with files' pages; processes killed: {group.kills()}")
    service.stop()
    kills = group.kills() if group else 0
    if group:
        group.remove()
    if not alive or kills or health.failed or set(answers) - ALLOWED:
        raise SystemExit("bombs: FAILED")


if __name__ == "__main__":
    main()
