"""The load test itself: its client reports what it saw, and its figures follow from the client's rows."""

import contextlib
import copy
import hashlib
import json
import math
import os
import pathlib
import random
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/bench"), str(ROOT / "tests/cluster")]

from loadtest import phases, report, requests, soak  # noqa: E402
from scratch import free_port  # noqa: E402

BUILD = pathlib.Path(os.environ.get("MESHGAUGE_BUILD", ROOT / "build"))
CLIENT = BUILD / "tests/load/load_client"


class Stub:
    """A service that answers what the test wants: `answer(number of the request)` is bytes, None hangs up."""

    def __init__(self, answer):
        self.answer, self.seen, self.lock = answer, 0, threading.Lock()
        self.socket = socket.create_server(("127.0.0.1", 0), backlog=512)
        self.port = self.socket.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                connection, _ = self.socket.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with connection, connection.makefile("rb") as stream, contextlib.suppress(OSError):
            while head := stream.readline():
                while (line := stream.readline()) not in (b"\r\n", b""):
                    head += line
                with self.lock:
                    self.seen += 1
                    number = self.seen
                answer = self.answer(number)
                if answer is None:
                    return
                connection.sendall(answer)


OK = b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nhello"
BUSY = b"HTTP/1.1 503 Busy\r\nContent-Length: 2\r\nConnection: close\r\n\r\nno"


class Client(unittest.TestCase):
    def run_client(self, answer, *flags, request=b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"):
        stub = Stub(answer)
        self.addCleanup(stub.socket.close)
        with tempfile.TemporaryDirectory() as folder:
            file, out = pathlib.Path(folder, "a.http"), pathlib.Path(folder, "out.csv")
            file.write_bytes(request)
            subprocess.run([CLIENT, "--port", str(stub.port), "--out", out, *map(str, flags), file], check=True)
            return phases.rows_of(out), stub

    def test_a_closed_loop_waits_for_each_answer(self):
        def slow(_):
            time.sleep(0.05)
            return OK

        rows, stub = self.run_client(slow, "--connections", 2, "--seconds", 1)
        self.assertEqual({row["status"] for row in rows}, {"200"})
        self.assertEqual(len(rows), stub.seen)
        self.assertLessEqual(len(rows), 2 * 21)
        self.assertGreater(min(row["latency"] for row in rows), 0.045)

    def test_an_open_loop_does_not_wait_and_counts_from_when_a_request_was_due(self):
        """The service stalls for a second: the latency of requests that were due meanwhile includes the wait."""
        start = time.monotonic()

        def stalls(_):
            time.sleep(max(0, start + 1 - time.monotonic()))
            return OK

        rows, _ = self.run_client(stalls, "--rate", 100, "--seconds", 1)
        self.assertGreater(len(rows), 50)
        self.assertEqual({row["status"] for row in rows}, {"200"})
        waited = [row["latency"] for row in rows]
        self.assertGreater(max(waited), 0.6)
        self.assertGreater(sum(w > 0.3 for w in waited), 20)

    def test_the_times_are_random_at_the_rate_that_was_asked_for(self):
        rows, _ = self.run_client(lambda _: OK, "--rate", 500, "--seconds", 2)
        self.assertTrue(800 < len(rows) < 1200, len(rows))  # six standard deviations
        due = sorted(row["due"] for row in rows)
        gaps = [b - a for a, b in zip(due, due[1:])]
        mean = sum(gaps) / len(gaps)
        self.assertTrue(0.7 < math.sqrt(sum((g - mean) ** 2 for g in gaps) / len(gaps)) / mean < 1.3)

    def test_refusals_and_broken_connections_are_told_apart(self):
        answers = {0: OK, 1: BUSY, 2: None}
        rows, _ = self.run_client(lambda n: answers[n % 3], "--connections", 1, "--seconds", 0.5)
        self.assertLessEqual({"200", "503"}, {row["status"] for row in rows})
        self.assertIn("-2", {row["status"] for row in rows})

    def test_an_answer_in_the_middle_of_a_body_is_read(self):
        request = b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 50000000\r\n\r\n" + bytes(50_000_000)
        rows, _ = self.run_client(lambda _: BUSY, "--connections", 1, "--seconds", 0.3, request=request)
        self.assertIn("503", {row["status"] for row in rows})

    def test_a_body_that_asks_first_is_sent_when_it_is_invited(self):
        head = b"POST / HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: %d\r\n\r\n"
        body = b"POST /body HTTP/1.1\r\n\r\n"  # the stub counts it as a request of its own
        invites = b"HTTP/1.1 100 Continue\r\n\r\n"
        rows, stub = self.run_client(lambda n: OK if n % 2 == 0 else invites, "--connections", 1, "--seconds", 0.3, request=head % len(body) + body)
        self.assertEqual({row["status"] for row in rows}, {"200"})
        self.assertEqual(2 * len(rows), stub.seen)
        rows, stub = self.run_client(lambda _: BUSY, "--connections", 1, "--seconds", 0.3, request=head % len(body) + body)
        self.assertEqual({row["status"] for row in rows}, {"503"})
        self.assertEqual(len(rows), stub.seen)  # no body came

    def test_no_server_there(self):
        port = free_port()
        with tempfile.TemporaryDirectory() as folder:
            file, out = pathlib.Path(folder, "a.http"), pathlib.Path(folder, "out.csv")
            file.write_bytes(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
            subprocess.run([CLIENT, "--port", str(port), "--rate", "50", "--seconds", "0.3", "--out", out, file], check=True)
            self.assertEqual({row["status"] for row in phases.rows_of(out)} - {"-1", "-2"}, set())


class Figures(unittest.TestCase):
    def test_quantiles(self):
        self.assertEqual(phases.quantile(range(1, 101), 0.99), 99)
        self.assertEqual(phases.quantile(range(1, 101), 0.5), 50)
        self.assertEqual(phases.quantile([7], 0.99), 7)
        self.assertIsNone(phases.quantile([], 0.5))

    def test_accepted_and_refused_have_latencies_of_their_own(self):
        rows = [{"due": i / 10, "latency": 1.0, "service": 0.5, "status": "200", "request": 0} for i in range(100)]
        rows += [{"due": i / 10, "latency": 0.03, "service": 0.02, "status": "503", "request": 0} for i in range(100)]
        rows += [{"due": 9, "latency": 5, "service": 5, "status": "-2", "request": 0}]
        got = phases.figures(rows, 2, 10)
        self.assertEqual((got["accepted"], got["refused"], got["others"]), (80, 80, {"connection broke": 1}))
        self.assertEqual((got["throughput"], got["p99"], got["refusal_p99"]), (10, 1.0, 0.02))
        self.assertEqual(sum(second["accepted"] for second in phases.by_second(rows, 10)), 100)

    def test_the_requests_are_whole(self):
        with tempfile.TemporaryDirectory() as folder:
            small = requests.make(pathlib.Path(folder), key="secret")["small"].read_bytes()
        head, _, body = small.partition(b"\r\n\r\n")
        self.assertIn(b"Content-Length: %d" % len(body), head)
        self.assertIn(b"Authorization: Bearer secret", head)

    def test_a_stored_pair_is_asked_for_by_the_names_of_its_meshes(self):
        with tempfile.TemporaryDirectory() as folder:
            _, _, body = requests.make(pathlib.Path(folder))["stored"].read_bytes().partition(b"\r\n\r\n")
        names = [hashlib.sha256(data).hexdigest() for data in requests.binary_stl(requests.SIZES["small"])]
        self.assertEqual(json.loads(body), {"a": names[0], "b": names[1]})


class Growth(unittest.TestCase):
    """A quarter is compared with another: growth is seen, noise is not."""

    def quarters(self, values):
        rows = [{"at": float(second), "memory": value} for second, value in enumerate(values)]
        return soak.quarters(rows, "memory", 100, len(values))

    def test_the_warm_up_is_left_out(self):
        first, last, error = self.quarters([0.0] * 100 + [50.0] * 400)
        self.assertEqual((first, last, error), (50, 50, 0))

    def test_two_percent_are_allowed_and_three_are_not(self):
        self.assertTrue(soak.is_flat(100, 102, 0))
        self.assertFalse(soak.is_flat(100, 103, 0))
        self.assertTrue(soak.is_flat(100, 90, 0))
        self.assertTrue(soak.is_flat(0, 0, 0))
        self.assertFalse(soak.is_flat(0, 1, 0.2))

    def test_noise_around_little_is_no_growth(self):
        """Values that follow each other are worth less: a random walk around a level."""
        dice = random.Random(2)
        grew = 0
        for _ in range(200):
            values, level = [], 0.0
            for _ in range(1300):
                level = 0.9 * level + dice.gauss(0, 1)
                values.append(4 + level)
            grew += not soak.is_flat(*self.quarters(values))
        self.assertLess(grew, 200 * 0.1)

    def test_growth_is_seen_through_noise(self):
        dice = random.Random(3)
        self.assertFalse(soak.is_flat(*self.quarters([100 + 0.01 * t + dice.gauss(0, 1) for t in range(1300)])))

    def test_what_a_soak_found_is_said(self):
        flat, grown = ({"first": 1.0, "last": last, "error": 0.0, "flat": last == 1} for last in (1.0, 2.0))
        run = {"growth": {"memory": flat, "rows": grown}, "violations": ["lost: the job 1"], "others": {"500": 3}}
        self.assertEqual(soak.faults(run), ["rows grew from 1 to 2", "lost: the job 1", "3 requests: 500"])


class Report(unittest.TestCase):
    RUN = {"name": "x", "mix": "small", "connections": None, "rate": 100, "multiple": 1.0, "seconds": 10, "warm_up": 1,
           "requests": 900, "offered": 100, "throughput": 99, "accepted": 890, "refused": 10, "others": {}, "p50": 0.01,
           "p99": 0.1, "max": 0.2, "refusal_p50": 0.001, "refusal_p99": 0.002, "refusal_max": 0.01, "late_p99": 0.001,
           "memory": 1 << 27, "descriptors": 20, "cpu": 1.1, "seconds_by": [], "idle_after": 0.1, "memory_after": 1 << 26,
           "descriptors_after": 10}  # fmt: skip

    def record(self, **top):
        heavy = copy.deepcopy(self.RUN) | {"multiple": 10.0} | top
        facts = {"processor": "p", "cores": 2, "memory": "8 GiB", "kernel": "6", "commit": "c", "session": "s"}
        return {"machine": facts, "flags": [], "workers": 2, "places": 34, "load_before": 0.1, "multiples": [1.0, 10.0],
                "capacity": {"stored": 900.0, "small": 100.0}, "runs": [copy.deepcopy(self.RUN), heavy]}  # fmt: skip

    def test_the_verdicts_follow_the_figures(self):
        self.assertEqual(report.verdicts(self.record()).count("| met |"), 5)
        self.assertEqual(report.verdicts(self.record(refusal_p99=0.021)).count("**missed**"), 2)
        self.assertEqual(report.verdicts(self.record(throughput=89)).count("**missed**"), 2)
        self.assertEqual(report.verdicts(self.record(p99=0.55)).count("**missed**"), 2)  # and the thousand a second
        self.assertEqual(report.verdicts(self.record(others={"connection broke": 1})).count("**missed**"), 2)
        self.assertEqual(report.verdicts(self.record(idle_after=None)).count("**missed**"), 2)

    def test_the_page_has_a_place_for_everything(self):
        page = (ROOT / "docs/benchmarks.md").read_text()
        self.assertEqual({name for _, name, _ in report.MARKED.findall(page)}, set(report.MADE))
        filled = report.fill(page, self.record())
        self.assertIn("open, 10x", filled)
        self.assertEqual(report.fill(filled, self.record()), filled)

    def test_what_was_not_measured_stays_on_the_page(self):
        page = "<!-- load: loads -->\nolder\n<!-- end of load -->\n\n<!-- load: soak -->\nolder\n<!-- end of load -->\n"
        growth = {what: {"first": 1.0, "last": 2.0, "error": 0.1, "flat": what != "rows"} for what in soak.WATCHED}
        record = {"runs": [], "soak": self.RUN | {"minutes": 30, "growth": growth, "company": {"walks": 3}, "promised": {}, "violations": []}}
        loads, filled = report.fill(page, record).split("<!-- load: soak -->")
        self.assertIn("older", loads)
        self.assertNotIn("older", filled)
        self.assertEqual((filled.count("| flat |"), filled.count("**grows**")), (len(soak.WATCHED) - 1, 1))
        self.assertLessEqual(max(len(line) for line in filled.splitlines() if not line.startswith("|")), 100)
        self.assertEqual(report.fill(page, self.record()).count("older"), 1)


if __name__ == "__main__":
    unittest.main()
