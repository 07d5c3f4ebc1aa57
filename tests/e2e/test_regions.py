"""Regions: the same from the service, in a batch and from the command line."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

from harness import BINARY, ENVIRONMENT, RAISED, SQUARE, ServerCase
from test_batches import accepted, ended, pairs, put, results, submit

# Both squares, [0, 1] x [0, 1], are 2 apart.
LEFT = {"name": "left", "box": {"min": [-9, -9, -9], "max": [0.5, 9, 9]}}
BALL = {"name": "the ball", "sphere": {"centre": [1, 0.5, 1], "radius": 1.2}}
FAR = {"name": "far", "box": {"min": [50, 50, 50], "max": [60, 60, 60]}}


def limited(region, limit):
    return {**region, "max_distance": limit}


class Regions(ServerCase):
    flags = ("--workers", "2")

    def measured(self, **options):
        answer = self.server.compare(options=options)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def test_an_interval_for_each_and_for_the_rest(self):
        result = self.measured(regions=[LEFT, BALL])
        self.assertEqual([region["name"] for region in result["regions"]], ["left", "the ball", "rest"])
        for region in result["regions"]:
            self.assertIsNone(region["verdict"])
            self.assertNotIn("max_distance", region)
            self.assertLessEqual(region["distance"]["lower"], 2)
            self.assertGreaterEqual(region["distance"]["upper"], 2)
            self.assertIs(region["empty"], False)
        for end in ("lower", "upper"):
            self.assertEqual(result["distance"][end], max(region["distance"][end] for region in result["regions"]))
        self.assertIsNone(result["verdict"])
        self.assertNotIn("regions", self.measured())

    def test_each_has_its_limit(self):
        verdicts = lambda result: (result["verdict"], [region["verdict"] for region in result["regions"]])
        gate = {"max_distance": 3, "units": "mm"}
        self.assertEqual(verdicts(self.measured(gate=gate, regions=[limited(LEFT, 2.5), BALL])), ("pass", ["pass"] * 3))
        self.assertEqual(verdicts(self.measured(gate=gate, regions=[limited(LEFT, 1.5), BALL])),
                         ("fail", ["fail", "pass", "pass"]))
        self.assertEqual(verdicts(self.measured(gate={"max_distance": 1}, regions=[limited(LEFT, 2.5)])),
                         ("fail", ["pass", "fail"]))
        unsure = {"max_distance": 3, "uncertainty": 0.5}
        self.assertEqual(verdicts(self.measured(gate=unsure, regions=[limited(LEFT, 2.25)])),
                         ("undecided", ["undecided", "pass"]))

    def test_what_is_refused(self):
        wrong = [None, {}, [], [1], [{"name": "x"}], [{**LEFT, "more": 1}], [LEFT, LEFT], [{**LEFT, "name": "rest"}],
                 [{**LEFT, "name": 1}], [limited(LEFT, 1)], [{**LEFT, **BALL}],
                 [{"name": "x", "box": {"min": [0, 0, 1], "max": [1, 1, 0]}}],
                 [{"name": "x", "sphere": {"centre": [0, 0], "radius": 1}}], [{"name": "x", "group": ""}], [{**LEFT, "group": "x"}]]
        for regions in wrong:
            with self.subTest(regions):
                self.refused(self.server.compare(options={"regions": regions}), 422, "invalid-request")
        problem = self.server.compare(options={"regions": [LEFT, FAR]}).json()
        self.assertIn("the region 'far' holds no point that is measured from: 'a' lies from (0, 0, 0) to", problem["detail"])
        self.assertEqual(problem["errors"][0]["where"], "/regions/1")

    def test_groups_of_mesh_b(self):
        b = b"v 0 0 2\nv 1 0 2\nv 0 1 2\nv 1 1 3\ng low\nf 1 2 3\ng high all\nf 2 4 3\n"
        compare = lambda **options: self.server.compare(SQUARE, b, options=options)
        low, high = {"name": "the low one", "group": "low"}, {"name": "high", "group": "high"}
        for _ in range(2):  # the second from the cache
            found = compare(gate={"max_distance": 4}, regions=[limited(low, 2.5), limited(high, 2.5)]).json()["regions"]
            self.assertEqual([(one["name"], one.get("group"), one["verdict"]) for one in found],
                             [("the low one", "low", "pass"), ("high", "high", "fail"), ("rest", None, "pass")])
            self.assertIsNone(found[0]["a_to_b"])
            self.assertEqual(found[1]["b_to_a"]["witness"]["triangle_a"], 1)
        found = compare(direction="b_to_a", regions=[low, high, {"name": "all", "group": "all"}]).json()["regions"]
        for one, distance in zip(found, (2, 3, 3)):
            self.assertLessEqual(one["distance"]["lower"], distance)
            self.assertGreaterEqual(one["distance"]["upper"], distance)
        self.assertIs(found[3]["empty"], True)
        for options, where, said in (
                ({"regions": [low, {"name": "x", "group": "Low"}]}, "/regions/1/group", "no group 'Low': 'b' has 'all', 'high', 'low'"),
                ({"regions": [low], "direction": "a_to_b"}, "/regions/0/group", "'the low one' is a group of mesh b: the direction must be symmetric or b_to_a")):
            problem = self.refused(compare(**options), 422, "invalid-request")
            self.assertIn(said, problem["detail"])
            self.assertEqual(problem["errors"][0]["where"], where)
        of_a = self.server.compare(b, SQUARE, options={"regions": [low]}).json()["detail"]
        self.assertTrue(of_a.endswith("; 'a' has it, but regions are groups of 'b' alone"), of_a)
        self.assertIn("'b' has none; groups", self.server.compare(options={"regions": [low]}).json()["detail"])

    def test_the_command_line_says_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, mesh in (("a.obj", SQUARE), ("b.obj", RAISED)):
                Path(folder, name).write_bytes(mesh if isinstance(mesh, bytes) else mesh.encode())
            run = lambda *more: subprocess.run(
                [BINARY, "compare", "a.obj", "b.obj", "--max-distance", "3", "--threads", "1", "--fast", "--regions",
                 json.dumps([limited(LEFT, 2.5), BALL]), *more], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)
            document = json.loads(run("--json").stdout)
            table = run().stdout
        asked = {"max_distance": 3, "narrow": False, "threads": 1, "regions": [limited(LEFT, 2.5), BALL]}
        self.assertEqual(document["regions"], self.measured(**asked)["regions"])
        self.assertRegex(table, r"(?m)^  pass      the distance in left is at most \S+, within the limit of 2\.5$")
        self.assertRegex(table, r"(?m)^  pass      the distance outside of all regions is at most \S+, within the limit of 3$")
        self.assertRegex(table, r"(?m)^region    left: \S+ \.\. \S+$")

    def test_in_a_batch(self):
        a, b = put(self.server, SQUARE), put(self.server, RAISED)
        options = {"gate": {"max_distance": 3}, "regions": [limited(LEFT, 1.5)]}
        path = accepted(submit(self.server, pairs((a, b), options=options)))
        self.assertEqual(ended(self.server, path)["counts"]["fail"], 1)
        line, = results(self.server, path)
        self.assertEqual([one["verdict"] for one in line["result"]["regions"]], ["fail", "pass"])
        said = self.server.get(path + "/junit.xml").body.decode()
        self.assertRegex(said, r"fail: the distance in left is at least \S+, above the limit of 1\.5; pass: the distance outside of all regions is")


if __name__ == "__main__":
    unittest.main()
