"""Statistics on request: the same from the service, from stored meshes and from the command line."""

import json
import math
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from contract import validate
from harness import ASYNC, BINARY, ENDED, ENVIRONMENT, RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, until, wait_for, wavy_grid
from test_batches import accepted, ended, pairs, submit
from test_meshes import compare as compare_stored, id_of

ESTIMATES = ("mean", "rms", "p50", "p95", "p99")
FEW = {"samples": 1000}


def ball(rings):
    """A sphere around 0."""
    lines = []
    for j in range(rings + 1):
        for i in range(2 * rings):
            theta, phi = math.pi * j / rings, math.pi * i / rings
            lines.append("v %r %r %r" % (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)))
    for j in range(rings):
        for i in range(2 * rings):
            a, b = 2 * rings * j + i + 1, 2 * rings * j + (i + 1) % (2 * rings) + 1
            lines.append("f %d %d %d" % (a, a + 2 * rings, b))
            lines.append("f %d %d %d" % (b, a + 2 * rings, b + 2 * rings))
    return ("\n".join(lines) + "\n").encode()


# The whole ball is nearly equally near to each point, so a million samples take long; the interval does not.
MIDDLE = b"v 0 0 0\nv 1e-9 0 0\nv 0 1e-9 0\nf 1 2 3\n"
LONG_SAMPLING = {"statistics": {"samples": 1000000}, "direction": "a_to_b", "timeout_ms": 100000}


FACES = b"".join(b"f %d %d %d\n" % face for face in (
    (1, 3, 4), (1, 4, 2), (5, 6, 8), (5, 8, 7), (1, 2, 6), (1, 6, 5),
    (3, 7, 8), (3, 8, 4), (1, 5, 7), (1, 7, 3), (2, 4, 8), (2, 8, 6)))


def cube(x):
    corners = [(x + 2 * (i & 1), 2 * (i >> 1 & 1), 2 * (i >> 2)) for i in range(8)]
    return b"".join(b"v %g %g %g\n" % corner for corner in corners) + FACES


CUBE, MOVED_CUBE = cube(0), cube(0.25)


class Statistics(ServerCase):
    flags = ("--workers", "2")

    def statistics(self, **asked):
        answer = self.server.compare(**asked)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["statistics"]

    def test_not_asked_for(self):
        for options in ({}, {"statistics": False}):
            result = self.server.compare(options=options).json()
            self.assertIsNone(result["statistics"])
            self.assertNotIn("statistics", result["timings_ms"])

    def test_asked_for(self):
        answer = self.server.compare(options={"statistics": True})
        result = answer.json()
        self.assertIn("statistics;dur=", answer.headers["server-timing"])
        self.assertGreater(result["timings_ms"]["statistics"], 0)
        statistics = result["statistics"]
        self.assertIs(statistics["sampled"], True)
        self.assertEqual((statistics["status"], statistics["seed"]), ("complete", 1))
        for direction in ("a_to_b", "b_to_a"):
            found = statistics[direction]
            self.assertEqual((found["weight"], found["samples"]), ("area", 100000))
            for name in ESTIMATES:
                self.assertAlmostEqual(found[name]["value"], 2)
                self.assertLess(found[name]["standard_error"], 1e-12)
            self.assertLessEqual(found["max_seen"], result[direction]["upper"])
            self.assertAlmostEqual(sum(found["histogram"]["shares"]), 1)

    def test_each_direction(self):
        for direction, other in (("a_to_b", "b_to_a"), ("b_to_a", "a_to_b")):
            statistics = self.statistics(options={"statistics": FEW, "direction": direction})
            self.assertIsNotNone(statistics[direction])
            self.assertIsNone(statistics[other])
            self.assertEqual(statistics["status"], "complete")

    def test_the_seed_and_no_thread_makes_a_difference(self):
        meshes = dict(a=wavy_grid(30, 0.1), b=wavy_grid(23, 0.103))
        first = self.statistics(**meshes, options={"statistics": {"samples": 2000, "seed": 5}})
        self.assertEqual(first["seed"], 5)
        again = self.statistics(**meshes, options={"statistics": {"samples": 2000, "seed": 5}, "threads": 2})
        self.assertEqual(first, again)
        other = self.statistics(**meshes, options={"statistics": {"samples": 2000, "seed": 6}})
        self.assertNotEqual(first["a_to_b"]["mean"], other["a_to_b"]["mean"])
        for name in ESTIMATES:
            error = math.hypot(first["a_to_b"][name]["standard_error"], other["a_to_b"][name]["standard_error"])
            self.assertLess(abs(first["a_to_b"][name]["value"] - other["a_to_b"][name]["value"]), 5 * error)

    def test_stored_meshes_give_the_same_each_time(self):
        a, b = wavy_grid(20, 0.1), wavy_grid(17, 0.103)
        for mesh in (a, b):
            self.assertIn(self.server.send("POST", "/v1/meshes", mesh).status, (200, 201))
        options = {"statistics": FEW}
        sent = self.statistics(a=a, b=b, options=options)
        for _ in range(3):
            answer = compare_stored(self.server, id_of(a), id_of(b), options)
            self.assertEqual(answer.json()["statistics"], sent)

    def test_points_and_segments(self):
        point = b"v 0 0 5\nf 1 1 1\n"
        self.assertEqual(self.statistics(a=point, options={"statistics": FEW})["a_to_b"]["weight"], "points")
        segment = b"v 0 0 5\nv 0 0 7\nf 1 1 2\n"
        found = self.statistics(a=segment, b=SQUARE, options={"statistics": FEW})["a_to_b"]
        self.assertEqual(found["weight"], "length")
        self.assertAlmostEqual(found["mean"]["value"], 6, delta=5 * found["mean"]["standard_error"])

    def test_no_time_for_them(self):
        result = self.server.compare(**SLOW, options={**SLOW_OPTIONS, "timeout_ms": 400, "statistics": True}).json()
        self.assertEqual(result["status"], "timeout")
        self.assertEqual(result["statistics"]["status"], "timeout")
        self.assertIsNone(result["statistics"]["a_to_b"])
        self.assertLessEqual(result["distance"]["lower"], result["distance"]["upper"])

    def test_time_that_ends_while_sampling_leaves_the_interval(self):
        """A slow machine, and a busy one, needs more time for the interval, and for the samples as well."""
        for timeout_ms in (1500, 3000, 6000, 12000):
            result = self.server.compare(MIDDLE, ball(100), {**LONG_SAMPLING, "timeout_ms": timeout_ms}).json()
            if result["status"] != "timeout":
                break
        self.assertEqual((result["status"], result["statistics"]["status"]), ("converged", "timeout"))
        self.assertIsNone(result["statistics"]["a_to_b"])

    def test_cancelled_while_sampling(self):
        path = self.server.compare(MIDDLE, ball(100), LONG_SAMPLING, extra=ASYNC).headers["location"]

        def stage():
            job = self.server.get(path).json()
            self.assertNotIn(job["state"], ENDED)
            return (job["progress"] or {}).get("stage")
        until(lambda: stage() == "statistics")
        self.server.send("DELETE", path)
        job = wait_for(self.server, path, *ENDED)
        self.assertEqual(job["state"], "cancelled")
        self.assertEqual((job["result"]["status"], job["result"]["statistics"]["status"]), ("converged", "cancelled"))

    def test_what_is_refused(self):
        for statistics in (None, "yes", 1, [], {"bins": 3}, {"samples": 10}, {"samples": 1e3}, {"seed": -1}):
            self.refused(self.server.compare(options={"statistics": statistics}), 422, "invalid-request")

    def test_an_idempotency_key_holds_for_the_statistics_asked_for(self):
        extra = "Idempotency-Key: statistics\r\n"
        first = self.server.compare(options={"statistics": FEW}, extra=extra)
        self.assertEqual(self.server.compare(options={"statistics": FEW}, extra=extra).body, first.body)
        for options in ({}, {"statistics": True}, {"statistics": {"samples": 1000, "seed": 2}}):
            self.refused(self.server.compare(options=options, extra=extra), 422, "idempotency-key-reused")


AREAS = {"beyond": [0.5, 3], "quantiles": [0.95], "mean": True}


class Areas(ServerCase):
    def test_not_asked_for(self):
        result = self.server.compare().json()
        self.assertNotIn("areas", result)
        self.assertNotIn("areas", result["timings_ms"])

    def test_a_square_and_a_raised_one(self):
        answer = self.server.compare(a=SQUARE, b=RAISED, options={"areas": AREAS})
        self.assertEqual(answer.status, 200, answer.body)
        result = answer.json()
        self.assertIn("areas;dur=", answer.headers["server-timing"])
        self.assertIs(result["areas"]["certified"], True)
        for direction in ("a_to_b", "b_to_a"):
            found = result["areas"][direction]
            self.assertEqual(found["status"], "complete")
            self.assertEqual([one["distance"] for one in found["beyond"]], AREAS["beyond"])
            self.assertEqual(found["quantiles"][0]["share"], 0.95)
            intervals = [one["share"] for one in found["beyond"]] + [found["quantiles"][0]["distance"], found["mean"], found["rms"]]
            for interval in intervals:
                self.assertLessEqual(interval["lower"], interval["upper"])
            self.assertLessEqual(found["mean"]["lower"], found["rms"]["upper"])
            self.assertLessEqual(found["rms"]["upper"], result["distance"]["upper"])

    def test_what_is_refused(self):
        for areas in (None, True, [], {}, {"beyond": []}, {"beyond": [-1]}, {"quantiles": [1]}, {"mean": False},
                      {"mean": True, "share_tolerance": 0}, {"median": True}):
            self.refused(self.server.compare(options={"areas": areas}), 422, "invalid-request")


class Topology(ServerCase):
    def test_not_asked_for(self):
        self.assertNotIn("topology", self.server.compare().json()["meshes"]["a"])

    def test_a_square_in_inches(self):
        options = {"topology": True, "units": {"a": "in", "b": "mm"}, "gate": {"max_distance": 50, "units": "mm"}}
        answer = self.server.compare(a=SQUARE, b=RAISED, options=options)
        self.assertEqual(answer.status, 200, answer.body)
        meshes = answer.json()["meshes"]
        for mesh in meshes.values():
            found = mesh["topology"]
            self.assertEqual((found["watertight"], found["oriented"], found["components"]), (False, True, 1))
            self.assertEqual((found["edges"], found["open_edges"]["count"], found["euler_characteristic"]), (5, 4, 1))
            self.assertIsNone(found["volume"])
        first = meshes["a"]["topology"]["open_edges"]["first"]
        self.assertIn(12.7, [round(x, 9) for x in first])

    def test_what_is_refused(self):
        for asked in (None, 1, "true", {}):
            self.refused(self.server.compare(options={"topology": asked}), 422, "invalid-request")


class LimitsOfTheSides(ServerCase):
    def verdict_of(self, b=CUBE, **gate):
        answer = self.server.compare(a=MOVED_CUBE, b=b, options={"gate": gate})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["verdict"], answer.json()["sides"]["verdict"]

    def test_a_zone_alone_and_beside_a_limit(self):  # a quarter inside, a quarter outside
        self.assertEqual(self.verdict_of(zone=[-0.3, 0.3]), ("pass", "pass"))
        self.assertEqual(self.verdict_of(zone=[-0.2, 0.3], units="mm"), ("fail", "fail"))
        self.assertEqual(self.verdict_of(zone=[-0.3, 0.2], narrow=True), ("fail", "fail"))
        self.assertEqual(self.verdict_of(zone=[-0.3, 0.3], max_distance=0.2), ("fail", "pass"))
        self.assertEqual(self.verdict_of(zone=[-0.3, 0.3], uncertainty=0.1), ("undecided", "undecided"))

    def test_a_baseline_that_is_open(self):
        self.assertEqual(self.verdict_of(b=SQUARE, zone=[-9, 9]), ("undecided", "undecided"))
        result = self.server.compare(a=MOVED_CUBE, b=SQUARE, options={"sides": True}).json()
        self.assertEqual(result["sides"]["refused"]["reason"], "open")
        self.assertIsNone(result["sides"]["inside"])

    def test_the_report_of_a_batch_names_what_fails(self):
        ids = [self.server.send("POST", "/v1/meshes", mesh).json()["id"] for mesh in (MOVED_CUBE, CUBE)]
        path = accepted(submit(self.server, pairs(ids, options={"gate": {"zone": [-0.3, 0.2]}, "expect": {"watertight": False}})))
        ended(self.server, path)
        self.assertRegex(self.server.get(path + "/junit.xml").body.decode(),
                         r"fail: the distance outside is at least \S+, above the limit of 0\.2; pass: .*; fail: watertight: yes, expected no")

    def test_sides_without_a_gate(self):
        result = self.server.compare(a=MOVED_CUBE, b=CUBE, options={"sides": {"length_tolerance": 0.001}}).json()
        self.assertNotIn("verdict", result["sides"])
        for side in ("outside", "inside"):
            self.assertLessEqual(result["sides"][side]["lower"], 0.25)
            self.assertGreaterEqual(result["sides"][side]["upper"], 0.25)

    def test_the_gate_is_that_of_the_request(self):
        gate = {"zone": [-0.3, 0.3], "uncertainty": 0.01, "units": "b"}
        result = self.server.compare(a=MOVED_CUBE, b=CUBE, options={"gate": gate}).json()
        self.assertEqual(result["gate"], {"max_distance": None, **gate})
        self.assertEqual(self.server.get("/v1/comparisons/" + result["id"]).json()["gate"], result["gate"])

    def test_what_is_refused(self):
        for zone in (None, 1, [], [1], [0.1, 0.2], [-0.1, -0.2], ["1 mm", "1 mm"]):
            self.refused(self.server.compare(options={"gate": {"zone": zone}}), 422, "invalid-request")
        for asked in ({"sides": 1}, {"sides": {"more": 1}}, {"sides": True, "direction": "b_to_a"}):
            self.refused(self.server.compare(options=asked), 422, "invalid-request")


class LimitOfTheArea(ServerCase):
    def verdict_of(self, **gate):
        answer = self.server.compare(a=SQUARE, b=RAISED, options={"gate": gate})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["verdict"], answer.json()["share_beyond"]["verdict"]

    def test_alone_and_beside_one_of_the_distance(self):  # all of both is at 2
        near, far = {"distance": 0.5, "share": 0.9}, {"distance": 2.5, "share": 0}
        self.assertEqual(self.verdict_of(max_share_beyond=near), ("fail", "fail"))
        self.assertEqual(self.verdict_of(max_share_beyond=far, units="mm"), ("pass", "pass"))
        self.assertEqual(self.verdict_of(max_share_beyond=far, max_distance=3, narrow=True), ("pass", "pass"))
        self.assertEqual(self.verdict_of(max_share_beyond=far, max_distance=0.5), ("fail", "pass"))
        self.assertEqual(self.verdict_of(max_share_beyond={"distance": 2, "share": 0.5}), ("undecided", "undecided"))
        self.assertEqual(self.verdict_of(max_share_beyond=far, uncertainty=0.4), ("pass", "pass"))
        self.assertEqual(self.verdict_of(max_share_beyond=far, uncertainty=0.6), ("undecided", "undecided"))

    def test_the_gate_is_that_of_the_request(self):
        gate = {"max_share_beyond": {"distance": 0.5, "share": 0.9}, "units": "b"}
        result = self.server.compare(options={"gate": gate, "areas": {"beyond": [0.25]}}).json()
        self.assertEqual(result["gate"], {"max_distance": None, **gate})
        self.assertEqual([one["distance"] for one in result["areas"]["a_to_b"]["beyond"]], [0.25, 0.5])
        job = self.server.get("/v1/comparisons/" + result["id"]).json()
        self.assertEqual(job["gate"], result["gate"])

    def test_what_is_refused(self):
        for limit in (None, 1, {}, {"distance": 1}, {"share": 1}, {"distance": -1, "share": 0}, {"distance": 1, "share": 1.2},
                      {"distance": 1, "share": "0.01"}, {"distance": 1, "share": 0, "more": 1}):
            self.refused(self.server.compare(options={"gate": {"max_share_beyond": limit}}), 422, "invalid-request")
        self.refused(self.server.compare(options={"gate": {"units": "mm"}}), 422, "invalid-request")
        for uncertainty in (-1, "one", None):
            gate = {"max_distance": 1, "uncertainty": uncertainty}
            self.refused(self.server.compare(options={"gate": gate}), 422, "invalid-request")


class Kept(unittest.TestCase):
    def test_a_result_is_as_it_was_after_a_kill(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        results = []
        for _ in range(2):
            server = Server("--data-dir", folder.name)
            self.addCleanup(server.stop)
            results.append(server.compare(options={"statistics": FEW}, extra="Idempotency-Key: k\r\n").body)
            server.stop(signal.SIGKILL)
        self.assertEqual(results[0], results[1])
        self.assertEqual(json.loads(results[0])["statistics"]["status"], "complete")


class Cli(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.files = [str(Path(folder.name) / name) for name in ("a.obj", "b.obj")]
        for path, mesh in zip(self.files, (wavy_grid(20, 0.1), wavy_grid(17, 0.103))):
            Path(path).write_bytes(mesh)

    def run_cli(self, *flags):
        return subprocess.run([BINARY, "compare", *self.files, *flags], capture_output=True, text=True, timeout=120,
                              env=ENVIRONMENT)

    def test_the_same_as_over_http(self):
        server = Server()
        self.addCleanup(server.stop)
        sent = server.compare(*(Path(path).read_bytes() for path in self.files),
                              {"statistics": {"samples": 2000, "seed": 3}}).json()
        document = json.loads(self.run_cli("--json", "--statistics", "--samples", "2000", "--seed", "3").stdout)
        validate(document, "Comparison")
        self.assertEqual(document["statistics"], sent["statistics"])

    def test_areas_are_those_over_http(self):
        server = Server()
        self.addCleanup(server.stop)
        asked = {"beyond": [0.001, 0.01], "quantiles": [0.95], "mean": True, "share_tolerance": 0.05, "length_tolerance": 0.1}
        sent = server.compare(*(Path(path).read_bytes() for path in self.files), {"areas": asked, "threads": 1}).json()
        flags = ("--threads", "1", "--beyond", "0.001,0.01", "--quantiles", "0.95", "--mean", "--share-tolerance", "0.05", "--length-tolerance", "0.1")
        self.assertEqual(json.loads(self.run_cli("--json", *flags).stdout)["areas"], sent["areas"])
        table = self.run_cli(*flags).stdout
        for words in ("certified a to b", "share beyond 0.001", "p95", "rms", ", areas "):
            self.assertIn(words, table)

    def test_topology_and_expectations_are_those_over_http(self):
        server = Server()
        self.addCleanup(server.stop)
        sent = server.compare(*(Path(path).read_bytes() for path in self.files), {"topology": True}).json()
        here = json.loads(self.run_cli("--json", "--topology").stdout)
        self.assertEqual(here["meshes"]["a"]["topology"], sent["meshes"]["a"]["topology"])
        self.assertIn("watertight, ", self.run_cli("--topology").stdout)
        sent = server.compare(*(Path(path).read_bytes() for path in self.files),
                              {"expect": {"watertight": True, "triangles": {"min": 1}, "volume": {"within": 0.01}}}).json()
        found = self.run_cli("--json", "--expect", "{watertight: true, triangles: {min: 1}, volume: {within: 1 %}}")
        self.assertEqual([json.loads(found.stdout)[member] for member in ("expect", "expectations")], [sent["expect"], sent["expectations"]])
        self.assertEqual(sent["expect"], {"watertight": True, "triangles": {"min": 1}, "volume": {"within": 0.01}})
        self.assertEqual([one["name"] for one in sent["expectations"]], ["watertight", "triangles", "volume.within"])
        self.assertEqual((sent["verdict"], sent["gate"], found.returncode), ("fail", None, 1))
        validate(sent, "Comparison")
        self.assertIn("  fail      watertight: no: ", self.run_cli("--expect", "{watertight: true}").stdout)

    def test_a_limit_of_the_area(self):
        flags = ("--max-share-beyond", "0.5 mm: 1 %")
        document = json.loads(self.run_cli("--json", *flags).stdout)
        validate(document, "Comparison")
        self.assertEqual(document["verdict"], "pass")
        self.assertEqual(document["share_beyond"]["share"], {"lower": 0, "upper": 0})
        self.assertIn("verdict   pass\n  pass      ", self.run_cli(*flags).stdout)
        self.assertIn("within the limit of 1 mm\n  pass      ", self.run_cli(*flags, "--max-distance", "1 mm").stdout)

    def test_the_table(self):
        table = self.run_cli("--statistics").stdout
        for line in ("sampled   a to b: 100000 points by area", "sampled   b to a: ", "  mean ", "  p95 ", "  max seen",
                     "  up to ", "#####", ", statistics "):
            self.assertIn(line, table)
        for line in table.splitlines():
            self.assertEqual(line, line.rstrip())
        self.assertNotIn("sampled", self.run_cli().stdout)

    def test_every_length_of_the_table_has_its_unit(self):
        table = self.run_cli("--statistics", "--unit", "mm").stdout
        for line in (r"distance  \S+ \.\. \S+ mm,", r"a to b    \S+ \.\. \S+ mm, culled", r"b to a    \S+ \.\. \S+ mm, culled",
                     r"  witness \(.*\) mm on triangle", r"  nearest \(.*\) mm on triangle",
                     r"sampled   a to b: .*, value \+- standard error, in mm\n"):
            self.assertRegex(table, line)

    def test_bad_flags(self):
        for flags, saying in ((("--statistics", "--samples", "999"), "--samples must be an integer from 1000 to 1000000"),
                              (("--statistics", "--seed", "-1"), "--seed must be"),
                              (("--max-share-beyond", "1 mm"), "--max-share-beyond: must be a distance, ':' and a share"),
                              (("--max-share-beyond", "1 mm: 120 %"), "--max-share-beyond.share must be from 0 % to 100 %"),
                              (("--max-share-beyond", "1 parsec: 1 %"), "--max-share-beyond.distance must have a unit of length"),
                              (("--max-share-beyond", "1 mm: 1 %", "--max-distance", "1"), "in one unit"),
                              (("--fast",), "--fast: needs --max-distance, --max-share-beyond or --zone")):
            result = self.run_cli(*flags)
            self.assertEqual(result.returncode, 3, flags)
            self.assertIn(saying, result.stderr)


if __name__ == "__main__":
    unittest.main()
