#!/usr/bin/python3
"""A batch of many small pairs against a running service, and single requests beside it: one line of JSON.

Measures the submit time, pairs a second, and the time of single synchronous comparisons meanwhile, with the batch's own key and
with another one. --against URL measures another service in the same way and adds the comparison of the two.
"""
import argparse
import http.client
import json
import math
import random
import sys
import threading
import time
import urllib.parse


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("url", help="of the service, http://127.0.0.1:8080")
    parser.add_argument("--against", metavar="URL", help="measure this one as well, after the first")
    parser.add_argument("--pairs", type=int, default=10_000, help="of the batch; all different")
    parser.add_argument("--squares", type=int, default=4, metavar="N", help="each mesh is a wavy square of N * N squares")
    parser.add_argument("--key", help="bearer key of the batch")
    parser.add_argument("--other-key", help="of the single requests of another owner")
    parser.add_argument("--pause", type=float, default=0.02, metavar="S", help="between two single requests of one client")
    parser.add_argument("--alone", action="store_true", help="no single requests: the throughput of the batch by itself")
    return parser.parse_args()


class Client:
    """One connection, opened again when the service has closed it."""

    def __init__(self, url, key):
        self.address = urllib.parse.urlsplit(url).netloc
        self.headers = {"Authorization": "Bearer " + key} if key else {}
        self.connection = http.client.HTTPConnection(self.address, timeout=120)

    def ask(self, method, path, body=None, media_type=None):
        headers = dict(self.headers, **({"Content-Type": media_type} if media_type else {}))
        for attempt in range(2):
            try:
                self.connection.request(method, path, body, headers)
                answer = self.connection.getresponse()
                return answer.status, answer.read()
            except (http.client.RemoteDisconnected, ConnectionError):
                self.connection.close()
                if attempt:
                    raise
        return None

    def get(self, *args, **more):
        """The document of an answer that must not be a refusal."""
        status, body = self.ask(*args, **more)
        if status >= 300:
            raise SystemExit("batch: %s %s: %d %s" % (*args[:2], status, body[:300].decode()))
        return json.loads(body)


def wavy_square(n, seed):
    dice = random.Random(seed)
    height, turn = dice.uniform(0.01, 0.2), dice.uniform(0, 6)
    lines = ["v %r %r %r" % (x / n, y / n, height * math.sin(5 * x / n + turn) * math.cos(7 * y / n))
             for y in range(n + 1) for x in range(n + 1)]
    corners = [y * (n + 1) + x + 1 for y in range(n) for x in range(n)]
    lines += ["f %d %d %d\nf %d %d %d" % (c, c + 1, c + n + 2, c, c + n + 2, c + n + 1) for c in corners]
    return ("\n".join(lines) + "\n").encode()


def manifest(client, pairs, squares):
    """All pairs of two lists of stored meshes; the random tolerance makes the work new to the service."""
    side = math.ceil(math.sqrt(pairs))
    ids = [client.get("POST", "/v1/meshes", wavy_square(squares, seed))["id"] for seed in range(2 * side)]
    chosen = [(a, b) for a in ids[:side] for b in ids[side:]][:pairs]
    options = {"tolerance": {"relative": 0.01, "absolute": random.random() * 1e-9}, "gate": {"max_distance": 0.15}}
    return json.dumps({"name": "load", "options": options, "comparisons": [{"a": a, "b": b} for a, b in chosen]}).encode()


class Singles(threading.Thread):
    """One client that sends a pair of files, waits for the result, and comes again."""

    def __init__(self, url, key, args):
        super().__init__(daemon=True)
        self.client, self.pause = Client(url, key), args.pause
        parts = b"".join(b'--X\r\nContent-Disposition: form-data; name="%s"; filename="%s.obj"\r\n\r\n%s\r\n'
                         % (name, name, wavy_square(args.squares, seed)) for name, seed in ((b"a", -1), (b"b", -2)))
        self.body = parts + b"--X--\r\n"
        self.seconds, self.refused, self.over = [], 0, threading.Event()

    def run(self):
        while not self.over.wait(self.pause):
            start = time.monotonic()
            status, _ = self.client.ask("POST", "/v1/comparisons", self.body, "multipart/form-data; boundary=X")
            self.refused += status != 200
            self.seconds.append(time.monotonic() - start)

    def figures(self):
        self.over.set()
        self.join()
        ordered = sorted(self.seconds)
        at = [ordered[max(0, math.ceil(q * len(ordered)) - 1)] if ordered else None for q in (0.5, 0.99, 1)]
        return {"requests": len(ordered), "refused": self.refused, **dict(zip(("p50_s", "p99_s", "max_s"), at))}


def measure(url, args):
    client = Client(url, args.key)
    body = manifest(client, args.pairs, args.squares)
    singles = {} if args.alone else {"same": Singles(url, args.key, args), "other": Singles(url, args.other_key, args)}
    for one in singles.values():
        one.start()
    start = time.monotonic()
    batch = client.get("POST", "/v1/batches", body=body, media_type="application/json")
    submitted = time.monotonic() - start
    while not batch["finished"]:
        time.sleep(0.2)
        batch = client.get("GET", "/v1/batches/" + batch["id"])
    seconds = time.monotonic() - start
    figures = {"url": url, "pairs": args.pairs, "submit_s": submitted, "seconds": seconds, "pairs_per_s": args.pairs / seconds,
               "counts": batch["counts"], "singles": {name: one.figures() for name, one in singles.items()}}
    if batch["counts"]["done"] != args.pairs:
        raise SystemExit("batch: not all were done: %s" % json.dumps(figures))
    return figures


def main():
    args = arguments()
    found = measure(args.url, args)
    if args.against:
        found["against"] = measure(args.against, args)
        found["share_of_throughput"] = found["pairs_per_s"] / found["against"]["pairs_per_s"]
    print(json.dumps(found))


if __name__ == "__main__":
    sys.exit(main())
