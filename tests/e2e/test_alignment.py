"""Alignment: the candidate is moved first, by request, by stored meshes, in batches, in maps and in check alike."""

import json
import math
import subprocess
import tempfile
import unittest
from pathlib import Path

from harness import BINARY, ENVIRONMENT, ServerCase
from maps import compared, ply_of, store
from test_batches import accepted, ended, pairs, submit

QUARTER = {"transform": {"row_major": [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, -2, 0, 0, 0, 1]}}


def part(turn=0.0, shift=0.0, points=False):
    """A wavy sheet that fits itself in one pose alone, turned about z and shifted along x."""
    lines = []
    for j in range(25):
        for i in range(25):
            x, y = i / 24, 0.7 * j / 24
            z = 0.1 * math.sin(5 * x + 1) * math.cos(3 * y) + 0.2 * x * y
            lines.append("v %r %r %r" % (math.cos(turn) * x - math.sin(turn) * y + shift, math.sin(turn) * x + math.cos(turn) * y, z))
    for j in range(0 if points else 24):
        for i in range(24):
            a = 25 * j + i + 1
            lines.append("f %d %d %d\nf %d %d %d" % (a, a + 1, a + 26, a, a + 26, a + 25))
    return ("\n".join(lines) + "\n").encode()


PART, AWAY = part(), part(0.4, 0.1)


class Alignment(ServerCase):
    def aligned(self, a, b, align, **options):
        answer = self.server.compare(a, b, options={"align": align, **options})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def test_without_it_nothing_is_said(self):
        for options in ({}, {"align": "none"}):
            result = self.server.compare(AWAY, PART, options=options).json()
            self.assertNotIn("alignment", result)
            self.assertNotIn("align", result["timings_ms"])
            self.assertGreater(result["distance"]["lower"], 0.05)

    def test_a_displaced_copy_fits(self):
        result = self.aligned(AWAY, PART, "rigid")
        self.assertLess(result["distance"]["upper"], 1e-9)
        found = result["alignment"]
        self.assertEqual((found["moved"], found["method"], found["converged"]), ("a", "best_fit", True))
        self.assertAlmostEqual(found["angle_degrees"], math.degrees(0.4), places=6)
        self.assertGreater(found["residual_before"], found["residual"])
        self.assertIn("mesh a was moved before it was measured, by best fit", result["notes"][0])
        again = self.aligned(AWAY, PART, {"transform": found["transform"]})
        self.assertEqual((again["distance"], again["precision_floor"]), (result["distance"], result["precision_floor"]))

    def test_a_fit_from_a_pose_states_it(self):
        align = {"transform": QUARTER["transform"], "fit": True}
        found = self.aligned(AWAY, PART, align)["alignment"]
        self.assertEqual((found["method"], found["start"]), ("best_fit", QUARTER["transform"]))
        self.assertNotIn("start", self.aligned(AWAY, PART, "rigid")["alignment"])
        with tempfile.TemporaryDirectory() as folder:
            for name, mesh in (("a.obj", AWAY), ("b.obj", PART)):
                Path(folder, name).write_bytes(mesh)
            run = subprocess.run([BINARY, "check", "a.obj", "b.obj", "--max-distance", "9", "--align", json.dumps(align), "--json", "--timeout", "180 s",
                                  "--server", "http://127.0.0.1:%d" % self.server.port], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300)
            self.assertEqual(run.returncode, 0, run.stderr)

    def test_a_scan_fits(self):
        result = self.aligned(part(0.3, 0.1, points=True), PART, {"overlap": 0.9}, direction="a_to_b", gate={"max_distance": 0.001})
        self.assertEqual((result["verdict"], result["alignment"]["overlap"]), ("pass", 0.9))

    def test_stored_meshes_are_moved_by_each_request_alone(self):
        results = [compared(self.server, AWAY, PART, {"align": align, "threads": 1})[1] for align in ("rigid", QUARTER, "none", QUARTER, "rigid")]
        distances = [result["distance"] for result in results]
        self.assertEqual((distances[0], distances[1]), (distances[4], distances[3]))
        self.assertEqual(len({distance["upper"] for distance in distances}), 3)
        self.assertLess(distances[0]["upper"], 1e-9)
        self.assertGreater(distances[1]["lower"], 1.9)

    def test_areas_statistics_and_maps_are_of_the_moved_mesh(self):
        path, result = compared(self.server, AWAY, PART, {"align": "rigid", "areas": {"mean": True}, "statistics": {"samples": 1000}, "direction": "a_to_b"})
        self.assertLess(result["areas"]["a_to_b"]["mean"]["upper"], 1e-9)
        self.assertLess(result["statistics"]["a_to_b"]["max_seen"], 1e-9)
        _, distances, _ = ply_of(self.server.get(path + "/deviation.ply").body)
        self.assertLess(max(distances), 1e-9)

    def test_a_batch(self):
        a, b = store(self.server, AWAY), store(self.server, PART)
        batch = ended(self.server, accepted(submit(self.server, pairs((a, b), options={"align": "rigid", "gate": {"max_distance": 0.001}}))))
        self.assertEqual(batch["counts"]["pass"], 1)

    def test_what_is_refused_and_where(self):
        for align, where in (("stiff", "/align"), ({"overlap": 2}, "/align/overlap"), ({"transform": {"row_major": [1]}}, "/align/transform/row_major"),
                             ({"transform": {"row_major": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}}, "/align/transform/row_major")):
            answer = self.server.compare(options={"align": align})
            self.refused(answer, 422, "invalid-request")
            self.assertEqual(answer.json()["errors"][0]["where"], where)

    def test_check_measures_the_same_here_and_by_the_service(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, mesh in (("a.obj", AWAY), ("b.obj", PART)):
                Path(folder, name).write_bytes(mesh)
            Path(folder, "gates.yaml").write_text(
                "version: 1\ndefaults: {max_distance: 0.001, threads: 1, timeout: 180 s}\ngates:\n"
                "  - {name: fits, candidate: a.obj, baseline: b.obj, align: rigid}\n"
                "  - {name: turned, candidate: a.obj, baseline: b.obj, align: %s}\n" % json.dumps(QUARTER))

            def gates(*flags):
                run = subprocess.run([BINARY, "check", "gates.yaml", "--json", *flags], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300)
                self.assertEqual(run.returncode, 1, run.stderr)
                return json.loads(run.stdout)["gates"]
            here, there = gates(), gates("--server", "http://127.0.0.1:%d" % self.server.port)
            self.assertEqual([gate["verdict"] for gate in here], ["pass", "fail"])
            for one, other in zip(here, there):
                self.assertEqual((one["verdict"], one["comparison"]["alignment"]), (other["verdict"], other["comparison"]["alignment"]))
                self.assertIn("the candidate was moved before it was measured", one["notes"][0])
            run = subprocess.run([BINARY, "check", "a.obj", "b.obj", "--max-distance", "0.001", "--align", "rigid", "--markdown", "-", "--deviation", "map.ply"],
                                 cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn("the candidate was moved", run.stdout)
            self.assertLess(max(ply_of(Path(folder, "map.ply").read_bytes())[1]), 1e-9)


if __name__ == "__main__":
    unittest.main()
