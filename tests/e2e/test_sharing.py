"""What clients share: memory, workers, places and uploads."""

import gzip
import pathlib
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

from harness import (ASYNC, RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, comparison, flat_grid, post_head,
                     read_answer, until)
from keys import bearer, new_key, write_keys
from test_sandbox import Held, workers

MB = 1_000_000


class Memory(ServerCase):
    """Comparisons reserve their memory: what does not fit waits, and what never can is refused."""

    flags = ("--workers", "3", "--max-memory-bytes", str(264 * MB), "--max-heap-bytes", str(16 * MB))  # 4 searches; 200 MB for meshes
    mesh = gzip.compress(flat_grid(400), 1)  # 320,000 triangles: two of them take 113 MB with their trees

    def test_what_never_fits_is_refused_with_the_numbers(self):
        large = gzip.compress(flat_grid(560), 1)
        problem = self.refused(self.server.compare(large, large), 413, "too-large")
        self.assertIn("1254400 triangles", problem["detail"])
        self.assertIn("more than the 175000000 that one may have", problem["detail"])

    def test_what_does_not_fit_now_waits(self):
        with ThreadPoolExecutor(4) as pool:
            answers = list(pool.map(lambda _: self.server.compare(self.mesh, self.mesh, options={"timeout_ms": 100000}), range(4)))
        self.assertEqual([answer.status for answer in answers], [200] * 4)

    def test_one_that_waits_for_too_long_is_told(self):
        until(lambda: len(workers(self.server)) == 4)  # those that other tests used have ended
        held = [Held(self.server), Held(self.server)]  # readers that were stopped, of 50 MB each
        problem = self.refused(self.server.compare(self.mesh, self.mesh, options={"timeout_ms": 2000}), 503, "out-of-time")
        self.assertIn("there was memory for it", problem["detail"])
        self.assertEqual(self.server.compare().status, 200)  # a small one fits beside them
        for one in held:
            one.connection.close()
        self.assertEqual(self.server.compare(self.mesh, self.mesh, options={"timeout_ms": 100000}).status, 200)

    def test_a_reader_gets_more_when_the_usual_is_not_enough(self):
        bomb = gzip.compress(SQUARE + b"#" * 150 * MB, 1)
        self.assertEqual(self.server.compare(bomb, RAISED).status, 413)  # more than the reader can have here
        fits = gzip.compress(SQUARE + b"#" * 40 * MB, 1)
        self.assertEqual(self.server.compare(fits, RAISED).status, 200)


class Keys(unittest.TestCase):
    """One key's hard comparisons and stalled uploads leave a worker, places and room for another key."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name) / "keys.json"
        self.greedy, one = new_key("greedy", max_jobs=1000, requests_per_minute=100000, burst=10000)
        self.modest, other = new_key("modest")
        self.watching, third = new_key("watching", "--scope", "metrics", requests_per_minute=10_000_000, burst=100_000)
        write_keys(path, one, other, third)
        self.server = Server("--keys-file", str(path), "--workers", "2", "--queue", "6", "--max-upload-bytes", str(4 * MB),
                             "--max-queued-jobs", "40", "--grace-ms", "0", "--body-timeout-ms", "3600000")  # what stalls stays
        self.addCleanup(self.server.stop)

    def small(self):
        return self.server.compare(extra=bearer(self.modest), options={"timeout_ms": 60000})

    def hard(self, extra=""):
        return self.server.compare(**SLOW, options=SLOW_OPTIONS, extra=bearer(self.greedy) + extra)

    def level(self, name):
        answer = self.server.get("/metrics", extra=bearer(self.watching))
        self.assertEqual(answer.status, 200, answer.body)
        return float(answer.body.decode().split("\n%s " % name, 1)[1].split("\n", 1)[0])

    def test_hard_comparisons_that_are_stored(self):
        accepted = [self.hard(ASYNC).status for _ in range(60)]  # one alone gets all 40 places
        self.assertEqual(set(accepted), {202, 503})
        self.assertGreater(accepted.count(503), 5)
        for _ in range(5):
            self.assertEqual(self.small().status, 200)
        stored = self.server.compare(extra=bearer(self.modest) + "Prefer: wait=60\r\n")
        self.assertEqual((stored.status, stored.json()["status"]), (200, "converged"))

    def test_hard_comparisons_that_clients_wait_for(self):
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        connections = [self.server.connect() for _ in range(8)]
        for connection in connections:
            self.addCleanup(connection.close)
            connection.sendall(post_head(len(body), bearer(self.greedy)) + body)
        until(lambda: self.level("meshgauge_queue_depth") == 6)  # beside two that run: all eight places
        self.assertEqual(self.hard().status, 503)
        for _ in range(5):
            self.assertEqual(self.small().status, 200)

    def test_uploads_that_stall(self):
        """One after the other: of those that arrive together, the share decides which is refused and frees its bytes."""
        for i in range(6):
            connection = self.server.connect()
            self.addCleanup(connection.close)
            body = comparison(a=b"#" * MB)
            connection.sendall(post_head(len(body), bearer(self.greedy)) + body[:MB])
            if i < 3:  # three quarters of the room are the share of one (server/base/share.h)
                until(lambda: self.level("meshgauge_upload_bytes") > (i + 0.9) * MB)
        for _ in range(5):
            self.assertEqual(self.small().status, 200)
        self.assertEqual(self.server.compare(a=SQUARE + b"#" * 300_000, extra=bearer(self.modest)).status, 200)


class Addresses(ServerCase):
    """Without keys, the same for the comparisons that one address stores."""
    flags = ("--workers", "2", "--max-queued-jobs", "40")

    def stored(self, source, body, extra):
        with self.server.connect(100, source) as connection:
            connection.sendall(post_head(len(body), extra) + body)
            return read_answer(connection.makefile("rb"))

    def test_hard_comparisons_that_are_stored(self):
        hard = comparison(**SLOW, options=SLOW_OPTIONS)
        accepted = [self.stored("127.0.0.2", hard, ASYNC) for _ in range(12)]
        self.assertEqual({answer.status for answer in accepted}, {202})
        for _ in range(5):
            answer = self.stored("127.0.0.1", comparison(), "Prefer: wait=60\r\n")
            self.assertEqual((answer.status, answer.json()["status"]), (200, "converged"))
        for answer in accepted:
            self.server.send("DELETE", answer.headers["location"])


class Stalled(ServerCase):
    flags = ("--workers", "1", "--queue", "0", "--body-timeout-ms", "60000")

    def test_an_upload_that_stalls_gives_its_place_back(self):
        with self.server.connect() as connection:
            connection.sendall(post_head(1000) + b"--XX")
            until(lambda: self.server.get("/readyz").status == 503)  # it has the only place
            answer = read_answer(connection.makefile("rb"))
            self.refused(answer, 408, "request-timeout")
            self.assertIn("no byte of the body arrived", answer.json()["detail"])
        until(lambda: self.server.compare().status == 200)


if __name__ == "__main__":
    unittest.main()
