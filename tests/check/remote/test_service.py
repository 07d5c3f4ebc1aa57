"""What a service has to do for a run of gates: how often files travel, keys, limits, restarts, cancellation."""

import json
import signal
import tempfile
import unittest
from pathlib import Path

from gates import Relay, Run, count_of, free_port, gate, measure, requests, server_at, url_of
from harness import RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, flat_grid, until
from keys import new_key, write_keys
from test_batches import accepted, slow_pairs, submit


def metric(server, name):
    text = server.get("/metrics").body.decode()
    return sum(float(line.rsplit(" ", 1)[1]) for line in text.splitlines() if line.startswith(name))


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def file(self, name, data):
        (self.folder / name).write_bytes(data)
        return self.folder / name

    def files(self, count, make=lambda i: b"# %d\n" % i + RAISED):
        return [self.file("%d.obj" % i, make(i)) for i in range(count)]

    def start(self, *flags):
        server = Server(*flags)
        self.addCleanup(server.stop, signal.SIGKILL)
        return server

    def assert_decided(self, outcomes, verdict="fail"):
        self.assertEqual({name: (o["verdict"], o["error"]) for name, o in outcomes.items()},
                         {name: (verdict, None) for name in outcomes})


class Uploads(Case):
    def test_each_file_travels_once_and_not_again(self):
        server = self.start()
        baseline = self.file("baseline.obj", SQUARE)
        gates = [gate("gate %d" % i, candidate, baseline) for i, candidate in enumerate(self.files(8))]
        gates += [gate("again %d" % i, candidate, baseline) for i, candidate in enumerate(self.files(8))]
        gates.append(gate("the same bytes", self.file("copy.obj", SQUARE), baseline, max_distance=0))
        self.assertEqual({o["verdict"] for o in measure(gates, {"url": url_of(server)}).values()}, {"fail", "pass"})
        self.assertEqual(count_of(server, "PUT", 9), 9)
        self.assertEqual(count_of(server, "HEAD", 9), 9)
        until(lambda: metric(server, "meshgauge_jobs_total") >= 9)
        self.assertEqual(metric(server, "meshgauge_jobs_total"), 9)
        measure(gates, {"url": url_of(server)})
        self.assertEqual(count_of(server, "HEAD", 18), 18)
        self.assertEqual(count_of(server, "PUT", 9), 9)

    def test_a_new_candidate_travels_alone(self):
        server = self.start()
        baseline = self.file("baseline.obj", SQUARE)
        for i, candidate in enumerate(self.files(3)):
            measure([gate("gate", candidate, baseline)], {"url": url_of(server)})
            self.assertEqual(count_of(server, "PUT", 2 + i), 2 + i)

    def test_a_large_file(self):
        server = self.start()
        large = self.file("large.obj", b"# padding\n" * 2_000_000 + SQUARE)
        outcomes = measure([gate("large", large, self.file("b.obj", RAISED))], {"url": url_of(server)})
        self.assert_decided(outcomes)
        self.assertEqual(outcomes["large"]["document"]["meshes"]["a"]["bytes"], large.stat().st_size)

    def test_connections_are_kept(self):
        server = self.start()
        with Relay(server.port) as relay:
            peers = set()
            relay.meddle = lambda handler, seen: peers.add(handler.client_address) or False
            gates = [gate("gate %d" % i, c, self.file("b.obj", SQUARE)) for i, c in enumerate(self.files(10))]
            self.assert_decided(measure(gates, {"url": url_of(relay), "at_once": 2}))
            self.assertLessEqual(len(peers), 2)

    def test_a_mesh_that_the_service_forgets_is_sent_again(self):
        server = self.start()
        baseline = self.file("baseline.obj", SQUARE)

        def forget(handler, seen):
            if handler.command == "POST" and seen == 0:
                for _, path, _ in list(relay.headers):
                    if path.startswith("/v1/meshes/"):
                        server.get(path, "DELETE")
            return False
        with Relay(server.port, forget) as relay:
            self.assert_decided(measure([gate("gate", self.files(1)[0], baseline)], {"url": url_of(relay)}))
            self.assertEqual(relay.seen[("PUT", "/v1/meshes")], 4)

    def test_a_service_that_always_forgets_is_reported(self):
        server = self.start()

        def forget(handler, seen):
            if handler.command == "POST":
                for _, path, _ in list(relay.headers):
                    if path.startswith("/v1/meshes/"):
                        server.get(path, "DELETE")
            return False
        with Relay(server.port, forget) as relay:
            baseline = self.file("baseline.obj", SQUARE)
            outcome = measure([gate("gate", self.files(1)[0], baseline)], {"url": url_of(relay)})["gate"]
            self.assertIn("is not stored", outcome["error"])
            self.assertIn("0.obj", outcome["error"])


class Keys(Case):
    def setUp(self):
        super().setUp()
        self.keys = self.folder / "keys.json"
        self.baseline = self.file("baseline.obj", SQUARE)
        self.gates = [gate("gate %d" % i, candidate, self.baseline) for i, candidate in enumerate(self.files(6))]

    def serve(self, *changes, **more):
        tokens, entries = zip(*[new_key("key%d" % i, **{**change, **more}) for i, change in enumerate(changes or [{}])])
        write_keys(self.keys, *entries)
        return self.start("--keys-file", str(self.keys)), tokens

    def service(self, server, token, **more):
        return {"url": url_of(server), "key_file": str(self.file("key", token.encode() + b"\n")), **more}

    def test_a_key_from_a_file_or_a_variable(self):
        server, (token,) = self.serve()
        self.assert_decided(measure(self.gates, self.service(server, token)))
        self.assert_decided(measure(self.gates, {"url": url_of(server)}, {"MESHGAUGE_KEY": token + "\n"}))

    def test_without_a_key(self):
        server, _ = self.serve()
        outcomes = measure(self.gates, {"url": url_of(server)})
        for outcome in outcomes.values():
            self.assertEqual(outcome["verdict"], "error")
            self.assertIn("give a key by --key-file or MESHGAUGE_KEY", outcome["error"])

    def test_a_key_that_does_not_count_is_not_shown(self):
        server, (token,) = self.serve()
        wrong = token[:-4] + "0000"
        run = Run(self.gates, self.service(server, wrong))
        command = Path("/proc/%d/cmdline" % run.process.pid).read_bytes()
        outcomes = run.ended()
        self.assertTrue(all("the key is not accepted" in o["error"] for o in outcomes))
        for shown in (json.dumps(outcomes), repr(run.progress), command.decode(), "".join(server.log)):
            self.assertNotIn(wrong, shown)

    def test_a_key_without_room(self):
        server, (token,) = self.serve({"max_storage_bytes": 10})
        for outcome in measure(self.gates, self.service(server, token)).values():
            self.assertIn(".obj' is not taken: ", outcome["error"])

    def test_a_key_with_few_jobs(self):
        """A batch does not count as jobs of its key."""
        server, (token,) = self.serve({"max_jobs": 1})
        self.assert_decided(measure(self.gates, self.service(server, token)))
        self.assert_decided(measure(self.gates[:1], self.service(server, token)))
        self.assertEqual(count_of(server, "POST", 2), 2)

    def test_a_key_with_a_low_rate(self):
        server, (token,) = self.serve({"requests_per_minute": 600, "burst": 1})
        self.assert_decided(measure(self.gates[:2], self.service(server, token)))
        until(lambda: any(line["status"] == 429 for method in ("POST", "PUT", "HEAD") for line in requests(server, method)))


class Limits(Case):
    def test_a_full_queue(self):
        """Ten comparisons of batches may be queued or running there."""
        server = self.start("--workers", "1", "--max-batch-pairs", "1")
        slow = slow_pairs(server, 10)
        paths = [accepted(submit(server, {**slow, "comparisons": [one]})) for one in slow["comparisons"]]
        run = Run([gate("gate", self.files(1)[0], self.file("b.obj", SQUARE))], {"url": url_of(server)})
        until(lambda: any(line["status"] == 503 for line in requests(server, "POST", "/v1/batches")))
        for path in paths:
            server.send("POST", path + "/cancel")
        self.assert_decided({o["name"]: o for o in run.ended()})

    def test_the_timeout_is_the_services(self):
        server = self.start()
        pair = [self.file(name, data) for name, data in SLOW.items()]
        options = {**SLOW_OPTIONS}
        del options["timeout_ms"]
        outcome = measure([gate("slow", *pair, max_distance=1e-12, timeout_ms=1500, options=options)],
                          {"url": url_of(server)})["slow"]
        self.assertEqual(outcome["verdict"], "undecided")
        self.assertEqual(outcome["document"]["status"], "timeout")

    def test_a_mesh_that_is_too_large_for_the_service(self):
        server = self.start("--max-triangles", "1")
        outcome = measure([gate("gate", self.file("a.obj", SQUARE), self.file("b.obj", RAISED))],
                          {"url": url_of(server)})["gate"]
        self.assertEqual(outcome["verdict"], "error")
        self.assertIn("/a.obj'", outcome["error"])
        self.assertEqual(outcome["part"], "a")

    def test_a_file_that_is_too_large_for_the_service(self):
        server = self.start("--max-part-bytes", "1000000")
        large = self.file("large.obj", b"# padding\n" * 1_000_000 + SQUARE)
        outcome = measure([gate("gate", self.file("a.obj", SQUARE), large)], {"url": url_of(server)})["gate"]
        self.assertEqual(outcome["verdict"], "error")
        self.assertIn("/large.obj' is not taken: ", outcome["error"])
        self.assertIn("1000000 bytes", outcome["error"])
        self.assertEqual(outcome["part"], "b")

    def test_options_that_the_service_refuses(self):
        server = self.start("--max-timeout-ms", "2000", "--default-timeout-ms", "2000")
        outcome = measure([gate("gate", self.file("a.obj", SQUARE), self.file("b.obj", RAISED), timeout_ms=3000)],
                          {"url": url_of(server)})["gate"]
        self.assertEqual(outcome["verdict"], "error")
        self.assertIn("/timeout_ms must be", outcome["error"])


class Restarts(Case):
    def test_killed_in_the_middle(self):
        """All gates are decided, whatever the service was about when it was killed."""
        port, data = free_port(), str(self.folder / "data")
        server = server_at(port, data)
        gates = [gate("gate %d" % i, c, self.file("b.obj", flat_grid(37)), max_distance=1e-12, timeout_ms=180_000,
                      options={"strategy": "four_point", "tolerance": {"absolute": 1e-3}})
                 for i, c in enumerate(self.files(5, lambda i: flat_grid(33 + i)))]
        run = Run(gates, {"url": url_of(server)})
        for _ in range(2):
            until(lambda: requests(server, "GET", "/v1/batches/") or run.process.poll() is not None)
            server.stop(signal.SIGKILL)
            server = server_at(port, data)
        outcomes = {o["name"]: o for o in run.ended()}
        server.stop()
        self.assertEqual(len(outcomes), len(gates))
        self.assertTrue(all(o["document"] for o in outcomes.values()), outcomes)
        self.assertTrue(all(o["document"]["status"] in ("converged", "gate_decided") for o in outcomes.values()))

    def test_a_service_without_its_memory(self):
        """Started again with an empty folder: files and comparison begin anew."""
        port = free_port()
        server = server_at(port, str(self.folder / "data"))
        pair = [self.file(name, data) for name, data in SLOW.items()]
        options = {k: v for k, v in SLOW_OPTIONS.items() if k != "timeout_ms"}
        run = Run([gate("slow", *pair, max_distance=1e-12, timeout_ms=3000, options=options)],
                  {"url": url_of(server), "patience_ms": 300_000})
        until(lambda: requests(server, "GET", "/v1/batches/"))
        server.stop(signal.SIGKILL)
        server = server_at(port, str(self.folder / "other"))
        (outcome,) = run.ended()
        self.assertEqual(count_of(server, "PUT", 2), 2)
        server.stop()
        self.assertIsNone(outcome["error"])
        self.assertIsNotNone(outcome["document"])


class Cancelling(Case):
    def slow(self):
        options = {k: v for k, v in SLOW_OPTIONS.items() if k != "timeout_ms"}
        pair = [self.file(name, data) for name, data in SLOW.items()]
        return gate("slow", *pair, max_distance=1e-12, timeout_ms=100000, options=options)

    def test_the_interval_so_far(self):
        server = self.start()
        run = Run([self.slow()], {"url": url_of(server)})
        until(lambda: any(len(line) == 4 and line[1] in ("traverse", "reduce") for line in run.progress))
        run.interrupt()
        (outcome,) = run.ended()
        self.assertEqual((outcome["verdict"], outcome["document"]["status"]), ("undecided", "cancelled"))
        until(lambda: metric(server, "meshgauge_jobs_running") == 0)

    def test_while_a_file_is_sent(self):
        server = self.start()
        held = []

        def hold(handler, seen):
            if handler.command != "PUT":
                return False
            held.append(handler)
            until(lambda: run.process.poll() is not None)
            handler.drop()
            return True
        with Relay(server.port, hold) as relay:
            run = Run([self.slow()], {"url": url_of(relay)})
            until(lambda: held)
            run.interrupt()
            (outcome,) = run.ended()
        self.assertEqual((outcome["verdict"], outcome["error"]), ("undecided", None))


if __name__ == "__main__":
    unittest.main()
