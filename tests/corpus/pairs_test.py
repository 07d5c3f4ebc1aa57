#!/usr/bin/python3
"""Every pair of the corpus through the built binary, against reference.tsv.

usage: pairs_test.py MESHGAUGE   (the corpus: environment variable MESHGAUGE_CORPUS)

Without a corpus it passes and says so: the meshes are not part of the project.
"""
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.append(str(pathlib.Path(__file__).parents[1] / "chaos"))
from seeds import todays  # noqa: E402

BINARY = sys.argv.pop(1) if len(sys.argv) > 1 else "build/meshgauge"
CORPUS = pathlib.Path(os.environ.get("MESHGAUGE_CORPUS", "../shared/corpus"))
MOST_TRIANGLES = 250_000
TIMEOUT_MS = 60_000
MOST_TIMEOUT_MS = 180_000  # the most that a comparison takes: for what has to converge, on slow machines too


def rows(name):
    lines = (CORPUS / name).read_text().splitlines()
    return [line.split("\t") for line in lines if not line.startswith("#")]


class Pair:
    def __init__(self, row, references, made):
        self.name, self.a, b, _, faces_a, faces_b = row
        self.triangles = int(faces_a) + int(faces_b)
        self.a = str(CORPUS / self.a)
        self.b = self.make(b, made) if b.startswith("gen:") else str(CORPUS / b)
        _, lower, upper = references[self.name]
        self.lower, self.upper = lower, upper

    def make(self, recipe, made):
        program, mesh, distance = recipe[len("gen:"):].split()
        out = made / (self.name.replace("/", "_") + ".obj")
        subprocess.run([sys.executable, CORPUS / "scripts" / (program + ".py"), CORPUS / mesh, distance, out],
                       check=True, stdout=subprocess.DEVNULL)
        return str(out)

    def compare(self, *flags, timeout_ms=TIMEOUT_MS):
        command = [BINARY, "compare", self.a, self.b, "--json", "--timeout-ms", str(timeout_ms), *flags]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise AssertionError("%s: exit code %d: %s" % (self.name, done.returncode, done.stderr))
        return json.loads(done.stdout)


@unittest.skipUnless((CORPUS / "pairs.tsv").exists(), "no corpus: set MESHGAUGE_CORPUS")
class CorpusPairs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory()
        references = {row[0]: tuple(map(float, row[1:4])) for row in rows("reference.tsv")}
        chosen = [row for row in rows("pairs.tsv") if int(row[4]) + int(row[5]) <= MOST_TRIANGLES]
        cls.pairs = [Pair(row, references, pathlib.Path(cls.made.name)) for row in chosen]

    @classmethod
    def tearDownClass(cls):
        cls.made.cleanup()

    def over(self, pairs, check, at_once=2):
        """Runs check(pair) -> problems on so many threads; every problem is reported."""
        with concurrent.futures.ThreadPoolExecutor(at_once) as pool:
            found = [problem for problems in pool.map(check, pairs) for problem in problems]
        self.assertEqual(found, [])

    @staticmethod
    def interval_problems(pair, result, within):
        distance, status = result["distance"], result["status"]
        lower, upper = distance["lower"], distance["upper"]
        problems = []
        if not (0 <= lower <= upper and lower <= pair.upper and upper >= pair.lower):
            problems.append(f"{pair.name}: [{lower}, {upper}] does not meet [{pair.lower}, {pair.upper}]")
        if status == "converged":
            if upper - lower > within(result):
                problems.append(f"{pair.name}: converged, but [{lower}, {upper}] is wider than asked for")
        elif status != "timeout":
            problems.append(f"{pair.name}: ended as {status}")
        elif result["timings_ms"]["total"] < TIMEOUT_MS * 0.9:
            problems.append(f"{pair.name}: timed out early")
        return problems

    def test_four_point_diagonal_rule(self):
        def check(pair):
            result = pair.compare("--direction", "a_to_b", "--diagonal", "1e-3", "--strategy", "four_point")
            return self.interval_problems(pair, result, lambda r: 1e-3 * r["meshes"]["a"]["diagonal"])
        self.over(todays(self.pairs, 6), check)

    def test_auto_finishes_every_pair_at_1e_6(self):
        def check(pair):
            result = pair.compare("--direction", "a_to_b", "--diagonal", "1e-6", timeout_ms=MOST_TIMEOUT_MS)
            problems = self.interval_problems(pair, result, lambda r: 1e-6 * r["meshes"]["a"]["diagonal"])
            return problems + ([] if result["status"] == "converged" else [f"{pair.name}: {result['status']}"])
        # Of the larger pairs, which take most of the time, a sixth each day.
        small = [pair for pair in self.pairs if pair.triangles <= 60_000]
        self.over(small + todays([pair for pair in self.pairs if pair.triangles > 60_000], 6), check)

    def test_threads_that_come_late(self):
        # Four threads on fewer processors: one may begin when the others have measured all the vertices that it needs.
        [pair] = [pair for pair in self.pairs if pair.name == "half/tray"]

        def check(pair):
            result = pair.compare("--direction", "a_to_b", "--diagonal", "1e-6", "--threads", "4", timeout_ms=MOST_TIMEOUT_MS)
            return self.interval_problems(pair, result, lambda r: 1e-6 * r["meshes"]["a"]["diagonal"])
        self.over([pair] * 60, check, at_once=4)

    def test_triangle_set_where_its_published_code_is_wrong(self):
        # Coplanar triangles that overlap. So do half/cycloidal and the remesh the other way, but half a minute each.
        def check(pair):
            result = pair.compare("--direction", "a_to_b", "--diagonal", "1e-6", "--strategy", "triangle_set",
                                  timeout_ms=MOST_TIMEOUT_MS)
            problems = self.interval_problems(pair, result, lambda r: 1e-6 * r["meshes"]["a"]["diagonal"])
            return problems + ([] if result["status"] == "converged" else [f"{pair.name}: {result['status']}"])
        names = {"half/snail", "half/conrod", "remesh/tw107100_sf-tw107100"}
        self.over([pair for pair in self.pairs if pair.name in names], check)

    def test_relative_rule_and_symmetric_direction(self):
        def check(pair):
            result = pair.compare("--direction", "symmetric", "--relative", "0.01", "--absolute", "1e-9",
                                  timeout_ms=MOST_TIMEOUT_MS)
            both = result["a_to_b"], result["b_to_a"]
            problems = []
            if result["distance"]["lower"] != max(side["lower"] for side in both):
                problems.append(f"{pair.name}: the symmetric lower bound is not the larger one")
            if result["distance"]["upper"] != max(side["upper"] for side in both):
                problems.append(f"{pair.name}: the symmetric upper bound is not the larger one")
            if not (both[0]["lower"] <= pair.upper and both[0]["upper"] >= pair.lower):
                problems.append(f"{pair.name}: a_to_b does not meet the reference")
            if result["status"] != "converged":
                problems.append(f"{pair.name}: {result['status']}")
            return problems
        self.over([pair for pair in todays(self.pairs, 3) if pair.triangles <= 40_000], check)


if __name__ == "__main__":
    unittest.main()
