"""Many gates as one batch: what is sent and reported, which answers are not trusted, which failures are retried."""

import itertools
import json
import signal
import tempfile
import unittest
import xml.etree.ElementTree as ET
from pathlib import Path

from gates import MEGABYTE, Relay, Run, free_port, gate, measure, requests, server_at, url_of, without_batches, without_chance
from harness import RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, until, until_computing
from workplace import Workplace, square

SHORT = {"retry_ms": 700, "first_contact_ms": 300}
PATH = "/v1/batches"


def posts(server):
    """How many batches, and how many comparisons, were asked for."""
    return len(requests(server, "POST", PATH)), len(requests(server, "POST", "/v1/comparisons"))


class Command(Workplace):
    def test_sixty_gates(self):
        server = Server()
        self.addCleanup(server.stop, signal.SIGKILL)
        gates = []
        for i in range(60):
            self.file("part%d.obj" % i, square(0.01 * i))
            gates.append(("gate%d" % i, "part%d.obj" % i, "flat.obj", 0.505))
        self.file("part7.obj", "v 0 0 0\nv 1 0 0\nv 2,5 0 0\nf 1 2 3\n")
        manifest = self.manifest(gates)
        outs = {}
        for where in ("here", "there"):
            more = ("--server", url_of(server)) if where == "there" else ()
            result = self.check(manifest, "--json=%s.json" % where, "--junit=%s.xml" % where, *more)
            self.assertEqual(result.returncode, 3, result.stderr)
            outs[where] = json.loads((self.folder / ("%s.json" % where)).read_text())
        until(lambda: posts(server) == (1, 0))
        self.assertEqual(outs["here"]["batches"], [])
        for link in self.pages(server, outs["there"]):
            self.assertIn("Seen in a browser at " + link, result.stderr)
        self.assertEqual(outs["there"]["counts"], {"pass": 50, "fail": 9, "undecided": 0, "error": 1})
        for here, there in zip(outs["here"]["gates"], outs["there"]["gates"]):
            for member in ("name", "verdict", "limit", "distance", "witness", "error"):
                self.assertEqual(there[member], here[member], here["name"])
            if here["comparison"]:
                self.assertEqual(without_chance(there["comparison"]), without_chance(here["comparison"]))
        suites = [ET.parse(self.folder / ("%s.xml" % where)).getroot() for where in outs]
        self.assertEqual(*[[(case.get("name"), [child.tag for child in case]) for case in suite.iter("testcase")]
                           for suite in suites])

    def pages(self, server, report):
        """What the report links to is the page of a batch that is there; a service without pages has none."""
        if not server.get("/", extra="Accept: text/html\r\n").headers["content-type"].startswith("text/html"):
            self.assertEqual(report["batches"], [])
            return []
        link, = report["batches"]
        before, _, id = link.rpartition("/b/")
        self.assertEqual(before, url_of(server))
        self.assertEqual(server.get("/b/" + id).status, 200)
        self.assertEqual(server.get(PATH + "/" + id).json()["counts"]["total"], 60)
        return [link]

    def test_one_gate_is_a_batch(self):
        server = Server()
        self.addCleanup(server.stop, signal.SIGKILL)
        self.exits(1, "raised.obj", "flat.obj", "--max-distance", "0.5", "--server", url_of(server))
        until(lambda: posts(server) == (1, 0))


class Case(ServerCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.gates = [self.gate(i) for i in range(6)]

    def gate(self, i, **more):
        for name, data in (("%d.obj" % i, RAISED), ("base%d.obj" % i, SQUARE)):
            (self.folder / name).write_bytes(b"# %s %d\n" % (self.id().encode(), i) + data)
        return gate("gate %d" % i, self.folder / ("%d.obj" % i), self.folder / ("base%d.obj" % i), **more)

    def slow(self, name, **more):
        files = []
        for part, data in SLOW.items():
            files.append(self.folder / ("%s %s.obj" % (name, part)))
            files[-1].write_bytes(b"# %s\n" % name.encode() + data)
        options = {k: v for k, v in SLOW_OPTIONS.items() if k != "timeout_ms"}
        return gate(name, *files, **{"max_distance": 1e-12, "timeout_ms": 100000, "options": options, **more})

    def assert_decided(self, outcomes, *but):
        told = {name: (o["verdict"], o["error"]) for name, o in outcomes.items() if name not in but}
        self.assertEqual(told, {name: ("fail", None) for name in told})
        self.assertEqual(len(told) + len(but), len(outcomes))


class Taken(Case):
    def test_one_gate_waits_for_its_end(self):
        """Its first poll does; later ones would take places that other clients of the service need."""
        with Relay(self.server.port) as relay:
            self.assert_decided(measure(self.gates[:1], {"url": url_of(relay)}))
            waits = [headers.get("Prefer") for method, path, headers in relay.headers if method == "GET" and path.startswith(PATH)]
            self.assertEqual(waits, ["wait=1"] + [None] * (len(waits) - 1))

    def test_a_service_without_batches(self):
        with Relay(self.server.port, without_batches) as relay:
            for outcome in measure(self.gates, {"url": url_of(relay)}).values():
                self.assertEqual(outcome["error"], "the service at %s has no batches, since it is older than this program: "
                                                   "update the service" % url_of(relay))
            self.assertEqual(relay.seen[("POST", PATH)], 1)

    def test_a_refused_gate_is_reported_alone(self):
        server = Server("--max-timeout-ms", "100000", environment={"MESHGAUGE_DEFAULT_TIMEOUT_MS": "100000"})
        self.addCleanup(server.stop, signal.SIGKILL)
        self.gates[3]["options"]["timeout_ms"] = 150_000
        outcomes = measure(self.gates, {"url": url_of(server)})
        self.assert_decided(outcomes, "gate 3")
        self.assertIn("/timeout_ms must be", outcomes["gate 3"]["error"])

    def test_meshes_that_are_forgotten_meanwhile(self):
        def forget(handler, seen):
            if handler.command == "POST" and seen == 0:
                for _, path, _ in list(relay.headers)[::3]:
                    if path.startswith("/v1/meshes/"):
                        self.server.get(path, "DELETE")
            return False
        with Relay(self.server.port, forget) as relay:
            self.assert_decided(measure(self.gates, {"url": url_of(relay)}))
            self.assertEqual(relay.seen[("POST", PATH)], 2)

    def test_results_that_are_gone_are_asked_for_again(self):
        gone = {"state": "gone", "comparison": None, "result": None}
        with Relay(self.server.port) as relay:
            relay.change_results(lambda line: {**line, **gone} if line["position"] == 1 else line)  # in whichever answer it comes
            self.assert_decided(measure(self.gates, {"url": url_of(relay)}))
            self.assertEqual(relay.seen[("POST", PATH)], 2)

    def test_results_come_before_all_have_ended(self):
        run = Run([*self.gates, self.slow("slow", timeout_ms=800)], {"url": url_of(self.server)})
        outcomes = {o["name"]: o for o in run.ended()}
        self.assert_decided(outcomes, "slow")
        self.assertEqual(outcomes["slow"]["document"]["status"], "timeout")
        ended = [line[0] for line in run.progress if line[0] == "gate"][-1:]
        last = max(i for i, line in enumerate(run.progress) if line[0] == "gate") if ended else 0
        self.assertLess(last, max(i for i, line in enumerate(run.progress) if line[0] == "slow"))


class Small(Case):
    flags = ("--max-batch-pairs", "4")

    def test_more_gates_than_the_service_takes(self):
        self.assert_decided(measure(self.gates, {"url": url_of(self.server)}))
        until(lambda: len(requests(self.server, "POST", PATH)) >= 3)
        batches = requests(self.server, "POST", PATH)
        self.assertEqual(sorted(line["status"] for line in batches), [202, 202, 413])


class Suspicion(Case):
    """A service gives wrong answers about a batch: each gate gets the right verdict or an error, and the run ends."""

    def answers(self, meddle, path="/results.jsonl", **service):
        def answer(handler, seen):
            if not handler.path.endswith(path) or handler.command != "GET" or not handler.path.startswith(PATH):
                return False
            status, headers, body = relay.forward(handler)
            handler.answer(200, {"Content-Type": headers["Content-Type"]}, meddle(body))
            return True
        with Relay(self.server.port, answer) as relay:
            run = Run(self.gates, {**SHORT, "url": url_of(relay), **service})
            outcomes = {o["name"]: o for o in run.ended()}
            self.assertTrue(run.takes_little(), run.peak)
            return outcomes

    def never_ended(self, polled=lambda batch: {}, **service):
        """No poll says that anything has ended. `polled`: what its answer has in place of the batch's own."""
        for made in self.gates:
            made["options"]["timeout_ms"] = 100

        def answer(body):
            if not body.startswith(b'{"id"'):
                return b""
            batch = json.loads(body)
            counts = {**dict.fromkeys(batch["counts"], 0), "total": 6, "queued": 6}
            return json.dumps({**batch, "state": "running", "finished": None, "counts": counts, **polled(batch)}).encode()
        self.assert_errors("did not end the batch in its time", self.answers(answer, "", **service))

    def assert_errors(self, text, outcomes):
        for outcome in outcomes.values():
            self.assertEqual(outcome["verdict"], "error", outcome)
            self.assertIn(text, outcome["error"])
            self.assertTrue(outcome["error"].isprintable())

    def test_lines_that_are_none(self):
        deep = b"[" * 100_000 + b"]" * 100_000 + b"\n"
        for body in (b"<html>\n", deep, b'{"position": 6}\n', b"x" * 5 * MEGABYTE):
            with self.subTest(body[:20]):
                self.assert_errors("its answer is not what was asked for", self.answers(lambda _: body))

    def test_lines_without_end(self):
        """Lines before the wrong one count."""
        for outcome in self.answers(lambda body: body * 1000).values():
            self.assertTrue(outcome["verdict"] == "fail" or "is not what was asked for" in outcome["error"], outcome)

    def test_the_results_of_others(self):
        def swap(body):
            lines = [json.loads(line) for line in body.splitlines()]
            for line, other in zip(lines, lines[1:]):
                line["result"] = other["result"]
            return b"".join(json.dumps(line).encode() + b"\n" for line in lines)
        self.assert_decided(self.answers(swap))

    def test_a_verdict_is_computed_here(self):
        def praise(body):
            lines = [json.loads(line) for line in body.splitlines()]
            for line in lines:
                line["verdict"] = line["result"]["verdict"] = "pass"
            return b"".join(json.dumps(line).encode() + b"\n" for line in lines)
        self.assert_decided(self.answers(praise))

    def test_nothing_at_all(self):
        self.assert_errors("has lost the comparison", self.answers(lambda _: b""))

    def test_a_batch_that_never_ends(self):
        self.never_ended()

    def test_a_batch_that_runs_again_and_again(self):
        """With each poll something runs or nothing does, and nothing ends."""
        polls = itertools.count()

        def polled(batch):
            poll = next(polls)
            return {"running": [{"position": 0}] if poll % 2 == 0 else []} if poll < 60 else {**batch, "state": "cancelled"}
        self.never_ended(polled, retry_ms=3000)

    def test_another_batch(self):
        bodies = [lambda b: {**b, "id": "0" * 32}, lambda b: {**b, "counts": {**b["counts"], "total": 7}},
                  lambda b: {**b, "counts": {**b["counts"], "queued": -1}}, lambda b: {**b, "state": "\x1b[31m"}]
        for change in bodies:
            self.assert_errors("does not answer as a meshgauge service",
                               self.answers(lambda body: json.dumps(change(json.loads(body))).encode(), ""))

    def test_a_batch_that_is_lost_again_and_again(self):
        def lose(handler, seen):
            if handler.command == "GET" and handler.path.startswith(PATH):
                handler.answer(404, {}, b"")
                return True
            return False
        with Relay(self.server.port, lose) as relay:
            self.assert_errors("has lost the comparison", measure(self.gates, {**SHORT, "url": url_of(relay)}))
            self.assertEqual(relay.seen[("POST", PATH)], 3)


class Restarts(Case):
    def start(self):
        data = str(self.folder / "data")
        server = server_at(free_port(), data, "--workers", "1")
        gates = [*self.gates, *[self.slow("slow %d" % i, timeout_ms=400) for i in range(2)]]
        return server, data, Run(gates, {"url": url_of(server)})

    def assert_measured(self, run, server):
        outcomes = {o["name"]: o for o in run.ended()}
        server.stop(signal.SIGKILL)
        self.assert_decided(outcomes, "slow 0", "slow 1")
        for name in ("slow 0", "slow 1"):
            self.assertEqual(outcomes[name]["document"]["status"], "timeout")

    def test_killed_in_the_middle(self):
        server, data, run = self.start()
        until(lambda: requests(server, "GET", PATH))
        server.stop(signal.SIGKILL)
        server = server_at(server.port, data)
        self.assert_measured(run, server)
        self.assertEqual(posts(server), (0, 0))

    def test_a_service_without_its_memory(self):
        server, _, run = self.start()
        until(lambda: requests(server, "GET", PATH))
        server.stop(signal.SIGKILL)
        server = server_at(server.port, str(self.folder / "other"))
        self.assert_measured(run, server)
        until(lambda: posts(server)[0] > 0)
        self.assertEqual(posts(server), (1, 0))


class Cancelling(Case):
    flags = ("--workers", "3")  # one is left for what ends, whatever begins first

    def idle(self):
        text = self.server.get("/metrics").body.decode()
        return all(float(line.rsplit(" ", 1)[1]) == 0 for line in text.splitlines()
                   if line.startswith(("meshgauge_jobs_running", "meshgauge_queue_depth")))

    def test_what_has_ended_is_kept_and_what_runs_has_its_interval(self):
        slow = [self.slow("slow %d" % i) for i in range(2)]
        run = Run([*self.gates, *slow], {"url": url_of(self.server), "cancel_ms": 60000})
        until(lambda: any('"done":6' in line for line in self.batches()))
        until(lambda: not self.idle())
        until_computing(self.server.process, 0.5)  # one of them has been read
        run.interrupt()
        outcomes = {o["name"]: o for o in run.ended()}
        self.assert_decided(outcomes, "slow 0", "slow 1")
        both = [outcomes["slow %d" % i] for i in range(2)]
        self.assertEqual([o["verdict"] for o in both], ["undecided"] * 2)
        self.assertEqual([o["error"] for o in both], [None] * 2)
        self.assertIn(sum(o["document"] is not None for o in both), (1, 2))
        until(self.idle)

    def batches(self):
        ids = [line["id"] for line in requests(self.server, "POST", PATH)]
        return [self.server.get(PATH + "/" + one).body.decode() for one in ids]

    def test_in_the_middle_of_asking(self):
        with Relay(self.server.port) as relay:
            run = Run([self.slow("slow %d" % i) for i in range(5)], {"url": url_of(relay)})
            until(lambda: relay.seen.get(("POST", PATH)))
            run.interrupt()
            for outcome in run.ended():
                self.assertEqual((outcome["verdict"], outcome["error"]), ("undecided", None))
        until(self.idle)

    def test_while_the_service_is_gone(self):
        server = Server("--workers", "1")
        run = Run([self.slow("slow %d" % i) for i in range(3)], {"url": url_of(server)})
        until(lambda: requests(server, "GET", PATH))
        server.stop(signal.SIGKILL)
        run.interrupt()
        for outcome in run.ended():
            self.assertEqual((outcome["verdict"], outcome["interrupted"]), ("undecided", True))


if __name__ == "__main__":
    unittest.main()
