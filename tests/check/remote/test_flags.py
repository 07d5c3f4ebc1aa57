"""`meshgauge check --server`, as a pipeline calls it."""

import json
import signal
import unittest

from gates import count_of, requests, url_of, without_chance
from harness import SLOW, Server, until
from keys import bearer, new_key, write_keys
from workplace import Workplace, square


class Command(Workplace):
    def setUp(self):
        super().setUp()
        token, entry = new_key("ci")
        self.token = token
        write_keys(self.folder / "keys.json", entry)
        self.server = Server("--keys-file", str(self.folder / "keys.json"))
        self.addCleanup(self.server.stop)
        self.key = self.file("key", token + "\n")
        self.pair = ("flat.obj", "raised.obj", "--max-distance", "1 mm")

    def with_key(self, *more):
        return ("--server", url_of(self.server), "--key-file", self.key, *more)

    def test_verdicts_and_documents_are_those_of_this_process(self):
        self.file("copy.obj", square())
        self.file("hole.obj", square(hole=True))
        self.file("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")
        manifest = self.manifest([("same", "copy.obj", "flat.obj", "0.1 mm"), ("hole", "hole.obj", "flat.obj", "1 %"),
                                  ("raised", "raised.obj", "flat.obj", "3"), ("none", "points.obj", "flat.obj", "1")])
        here = self.report(3, manifest)
        there = self.report(3, manifest, *self.with_key())
        self.assertEqual([g["verdict"] for g in there["gates"]], ["pass", "fail", "pass", "error"])
        for a, b in zip(here["gates"], there["gates"]):
            if a["comparison"]:
                self.assertEqual(without_chance(a["comparison"]), without_chance(b["comparison"]))
            for gate in (a, b):
                for chance in ("comparison", "wall_ms", "link"):
                    gate.pop(chance)
        self.assertEqual(here["gates"], there["gates"])

    def test_expectations_are_those_of_this_process(self):
        self.file("copy.obj", square())
        met, unmet = "expect: {watertight: false, oriented: true, components: 1}", "expect: {watertight: true, volume: {within: 1 %}}"
        manifest = self.manifest([("met", "copy.obj", "flat.obj", "1", met), ("unmet", "copy.obj", "flat.obj", "1", unmet),
                                  ("counts", "copy.obj", "flat.obj", "1", "expect: {triangles: 2, degenerate: 0}")])
        here = self.report(1, manifest)["gates"]
        there = self.report(1, manifest, *self.with_key())["gates"]
        self.assertEqual([gate["verdict"] for gate in there], ["pass", "fail", "pass"])
        self.assertEqual([gate["expectations"] for gate in here], [gate["expectations"] for gate in there])
        self.assertEqual([one["found"] for one in there[1]["expectations"]],
                         ["no: 4 open edges, the first at (0.5, 0, 0)", "none: the candidate is not watertight"])
        self.assertNotIn("topology", there[2]["comparison"]["meshes"]["a"])
        for gate in there:  # as the page shows it
            kept = self.server.get("/v1/comparisons/" + gate["comparison"]["id"], extra=bearer(self.token)).json()["result"]
            self.assertEqual((kept["verdict"], kept["expectations"]), (gate["verdict"], gate["expectations"]))

    def test_a_second_run_sends_nothing(self):
        self.exits(1, *self.pair, *self.with_key())
        self.assertEqual(count_of(self.server, "PUT", 2), 2)
        self.exits(1, *self.pair, *self.with_key())
        self.assertEqual(count_of(self.server, "PUT", 2), 2)

    def test_the_key_of_the_variable(self):
        self.exits(1, *self.pair, "--server", url_of(self.server), environment={"MESHGAUGE_KEY": self.token})

    def test_refusals(self):
        self.fails(*self.pair, "--key-file", self.key, saying="--server")
        self.fails(*self.pair, "--server", "localhost:8080", saying="http://")
        self.fails(*self.pair, *self.with_key("--key-file", "nowhere"), saying="--key-file")
        self.fails(*self.pair, "--server", url_of(self.server), "--key-file", "nowhere", saying="nowhere")
        result = self.exits(3, *self.pair, "--server", url_of(self.server))
        self.assertIn("give a key by --key-file or MESHGAUGE_KEY", result.stdout)

    def stages(self):
        """The stage of each comparison that runs."""
        batches = [self.server.get("/v1/batches/" + line["id"], extra=bearer(self.token)).json()
                   for line in requests(self.server, "POST", "/v1/batches")]
        return [one["progress"]["stage"] for batch in batches for one in batch["running"] if one["progress"]]

    def test_an_interrupt_ends_with_the_interval(self):
        a, b = self.file("1.obj", SLOW["a"]), self.file("2.obj", SLOW["b"])
        process = self.start(a, b, "--max-distance", "1e-9", "--strategy", "four_point", "--timeout", "100 s", "--json",
                             *self.with_key())
        until(lambda: set(self.stages()) & {"traverse", "reduce"})
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 2)
        (gate,) = json.loads(out)["gates"]
        self.assertEqual((gate["verdict"], gate["comparison"]["status"]), ("undecided", "cancelled"))


if __name__ == "__main__":
    unittest.main()
