#!/usr/bin/python3
"""Measures new and open connections and health checks of a service that speaks TLS, without and beside floods of a recorded hello.

An attack 2000x1 sends 2,000 hellos a second from one address, 4000x40 sends 4,000 from forty; each keeps 200 connections open
at most and computes nothing. The service has all processors but one, which clients and attacker share, the attacker at a
lower priority. A new connection that is refused counts as one that took for ever. Prints a row for each attack, in ms.
"""
import argparse
import collections
import contextlib
import json
import math
import multiprocessing
import os
import pathlib
import re
import resource
import shlex
import socket
import ssl
import subprocess
import sys
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/load"))

from loadtest.service import Service  # noqa: E402

NEWKEY = {"rsa-2048": ["rsa:2048"], "rsa-4096": ["rsa:4096"], "p-256": ["ec", "-pkeyopt", "ec_paramgen_curve:P-256"]}
HONEST = "127.0.0.1"
MOST_OPEN = 200  # of one attack
IP_BIND_ADDRESS_NO_PORT = 24
GET = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
ANSWER_SECONDS = 30


def context():
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    made.check_hostname = False
    made.verify_mode = ssl.CERT_NONE
    return made


CONTEXT = context()


def recorded_hello():
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    with contextlib.suppress(ssl.SSLWantReadError):
        CONTEXT.wrap_bio(incoming, outgoing).do_handshake()
    return outgoing.read()


def certificate(folder, kind):
    subprocess.run(["openssl", "req", "-x509", "-newkey", *NEWKEY[kind], "-nodes", "-days", "2", "-subj", "/CN=localhost",
                    "-keyout", folder / "k.pem", "-out", folder / "c.pem"], check=True, capture_output=True)
    return ["--tls-certificate", str(folder / "c.pem"), "--tls-key", str(folder / "k.pem")]


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as one:
        return one.getsockname()[1]


def plain(port, source):
    one = socket.create_connection(("127.0.0.1", port), ANSWER_SECONDS, (source, 0))
    one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return one


def secured(port, source=HONEST):
    return CONTEXT.wrap_socket(plain(port, source))


def ask(connection):
    connection.sendall(GET)
    answer = b""
    while b"\r\n\r\n" not in answer:
        piece = connection.recv(65536)
        if not piece:
            raise ConnectionError("closed")
        answer += piece
    head, _, body = answer.partition(b"\r\n\r\n")
    left = int(re.search(rb"(?i)content-length: (\d+)", head)[1]) - len(body)
    while left > 0:
        left -= len(connection.recv(65536))
    if not head.startswith(b"HTTP/1.1 200"):
        raise ConnectionError(head.split(b"\r\n")[0].decode())


class Step:
    """What is measured, again and again, in a process of its own: of a new connection or of an open one."""

    def __init__(self, port, is_new, per_second):
        self.port, self.is_new, self.per_second = port, is_new, per_second
        self.found = multiprocessing.SimpleQueue()

    def start(self, seconds):
        self.process = multiprocessing.Process(target=self.run, args=(seconds,))
        self.process.start()

    def run(self, seconds):
        times, connection = [], None if self.is_new else secured(self.port)
        start = time.monotonic()
        for i in range(int(seconds * self.per_second)):
            time.sleep(max(0.0, start + i / self.per_second - time.monotonic()))
            began = time.monotonic()
            try:
                if self.is_new:
                    with secured(self.port) as one:
                        ask(one)
                else:
                    ask(connection)
                times.append(time.monotonic() - began)
            except OSError:  # also of ssl and of sockets
                times.append(math.inf)
        self.found.put(times)

    def end(self):
        times = sorted(self.found.get())
        self.process.join()
        return times


class Flood:
    """Sends a recorded hello so often from so many addresses, in a process of its own."""

    def __init__(self, port, rate, addresses):
        self.port, self.rate, self.addresses = port, rate, addresses
        self.ended, self.sent = multiprocessing.Event(), multiprocessing.Value("q", 0)
        self.process = multiprocessing.Process(target=self.run)
        self.process.start()

    def run(self):
        os.nice(10)
        hello, kept, start = recorded_hello(), collections.deque(), time.monotonic()
        for i in range(1 << 62):
            if i % 50 == 0:
                if self.ended.is_set():
                    return
                self.sent.value = i
                time.sleep(max(0.0, start + i / self.rate - time.monotonic()))
            with contextlib.suppress(OSError):
                kept.append(self.one("127.0.2.%d" % (1 + i % self.addresses), hello))
            if len(kept) > MOST_OPEN:
                kept.popleft().close()

    def one(self, source, hello):
        made = socket.socket()
        made.setsockopt(socket.IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, 1)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # closing leaves no port that waits
        made.bind((source, 0))
        made.connect(("127.0.0.1", self.port))
        made.send(hello)
        return made

    def end(self):
        self.ended.set()
        self.process.join()
        return self.sent.value


def open_idle(port, count):
    """So many connections that have shaken hands, of a hundred addresses; their sockets alone are kept."""
    kept = []
    while len(kept) < count:
        with contextlib.suppress(OSError):  # refused: another time
            with secured(port, "127.0.1.%d" % (1 + len(kept) % 100)) as one:
                kept.append(socket.socket(fileno=one.detach()))
    return kept


def numbers(port):
    with urllib.request.urlopen(f"https://127.0.0.1:{port}/metrics", timeout=ANSWER_SECONDS, context=CONTEXT) as answer:
        text = answer.read().decode()
    return {name: float(re.search(rf"^meshgauge_{name} (\S+)$", text, re.M)[1])
            for name in ("tls_handshakes_total", "tls_handshakes_refused_total", "tls_handshakes_abandoned_total", "connections")}


def measured(ports, seconds, rate, addresses):
    """One phase, with an attack unless the rate is 0."""
    port, status = ports
    flood = Flood(port, rate, addresses) if rate else None
    time.sleep(1.0 if rate else 0.0)
    before, began = numbers(port), time.monotonic()
    sent = flood.sent.value if flood else 0
    steps = {"new": Step(port, True, 10), "open": Step(port, False, 50), "health": Step(status, True, 5)}
    for step in steps.values():
        step.start(seconds)
    times = {name: step.end() for name, step in steps.items()}
    after, passed = numbers(port), time.monotonic() - began
    sent = (flood.end() if flood else 0) - sent
    row = {"attack": f"{rate}x{addresses}" if rate else "none", "hellos_per_second": sent / passed, "idle": after["connections"]}
    for name in ("total", "refused_total", "abandoned_total"):
        row[name] = (after[f"tls_handshakes_{name}"] - before[f"tls_handshakes_{name}"]) / passed
    for name, of in times.items():
        row[name] = {"p50": percentile(of, 0.5), "p99": percentile(of, 0.99), "failed": of.count(math.inf), "count": len(of)}
    return row


def percentile(times, share):
    return 1000 * times[min(len(times) - 1, math.ceil(share * len(times)) - 1)]


def say(row):
    print(f"{row['attack']:>9} {row['hellos_per_second']:8.0f} {row['total']:7.0f} {row['refused_total']:8.0f} "
          + " ".join(f"{row[name]['p50']:8.1f} {row[name]['p99']:8.1f} {row[name]['failed']:4d}" for name in ("new", "open", "health")), flush=True)


def attack(text):
    rate, _, addresses = text.partition("x")
    return (0, 1) if text == "none" else (int(rate), int(addresses or 1))


def split():
    """The processors of the service: all but one, which this process keeps; all where there is one."""
    *service, client = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {client})
    return service or [client]


def main():
    parser = argparse.ArgumentParser(prog="./dev load handshakes", description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--certificate", choices=NEWKEY, default="rsa-2048")
    parser.add_argument("--attacks", default="none,2000x1,4000x40", metavar="A,B", help="each none or RATExADDRESSES")
    parser.add_argument("--seconds", type=float, default=20, help="of each attack")
    parser.add_argument("--idle", type=int, default=10_000, help="connections that are open meanwhile, as far as descriptors allow")
    parser.add_argument("--serve", default="", metavar="FLAGS", help="further flags of meshgauge serve")
    parser.add_argument("--binary", default=os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build/meshgauge")))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/load/handshakes", metavar="FOLDER")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    attacks = [attack(text) for text in args.attacks.split(",")]
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    processors, log = split(), args.out / "service.log"
    ports = [0, free_port()]
    flags = [*certificate(args.out, args.certificate), "--status-port", str(ports[1]), "--keep-alive-ms", "3600000", "--log-requests", "none"]
    service = Service(args.binary, [*flags, *shlex.split(args.serve)], log, lambda: os.sched_setaffinity(0, processors))
    try:
        ports[0] = service.port
        idle = open_idle(service.port, min(args.idle, hard * 3 // 4 - 2 * MOST_OPEN, hard - 1000))
        print(f"{args.certificate}, {len(idle)} idle connections, service on processors {processors}; ms")
        print("   attack hellos/s begun/s refused/s  new: p50      p99 failed  open: p50   p99 failed  health: p50   p99 failed")
        rows = []
        for rate, addresses in attacks:
            rows.append(measured(ports, args.seconds, rate, addresses))
            say(rows[-1])
            time.sleep(6 if rate else 0)  # until the buckets of addresses are full again
        (args.out / f"{args.certificate}.json").write_text(json.dumps(rows, indent=1) + "\n")
        for one in idle:
            one.close()
    finally:
        code = service.stop()
    return code


if __name__ == "__main__":
    sys.exit(main())
