"""The harness of ./dev bench: that it measures, resumes and reports. Not how fast anything is.

MESHGAUGE_BUILD is the build folder.
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from harness import contenders, meshes, page, paper, pairs, plan, results, rivals, store, tables, targets, text

HERE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ.get("MESHGAUGE_BUILD", HERE.parents[1] / "build"))


def row(**values):
    """A finished run of `auto` in 1 s, but for `values`."""
    base = dict.fromkeys(store.COLUMNS)
    base.update(
        experiment="pairs",
        pair="p",
        meshes="m",
        contender="auto",
        program="1",
        tolerance=1e-4,
        gate="",
        limits="60s",
        repetition=0.0,
        session="s",
        kind="k",
        at=0.0,
        status="converged",
        seconds=1.0,
        build=0.5,
        traverse=0.25,
        reduce=0.25,
        certify=0.0,
        triangles_a=2000.0,
        triangles_b=2000.0,
        lower=1.0,
        upper=1.001,
        diagonal=10.0,
        peak_bytes=1e6,
        wall=1.1,
        user=1.0,
        system=0.1,
        load=0.0,
    )
    return base | values


# A rival whose intervals are twice the true ones.
RIVAL = """
import json, subprocess, sys
a, b, tolerance, limit = sys.argv[1:]
assert a.endswith(".obj") and b.endswith(".obj") and float(limit) > 0
done = subprocess.run(
    ["{meshgauge}", "compare", a, b, "--json", "--direction", "a_to_b", "--absolute", tolerance], stdout=subprocess.PIPE
)
found = json.loads(done.stdout)["distance"]
print(json.dumps(dict(status="converged", lower=2 * found["lower"], upper=2 * found["upper"], user_s=0.25)))
"""


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)


class Reduced(unittest.TestCase):
    def results(self):
        runs = []
        for pair, auto, cgal in (("a", 1, 8), ("b", 2, 4), ("c", 4, 2)):
            runs += [
                row(pair=pair, seconds=float(auto)),
                row(pair=pair, seconds=auto + 1.0, repetition=1.0),
                row(pair=pair, contender="cgal", seconds=float(cgal)),
            ]
        runs.append(row(pair="d"))
        runs.append(row(pair="d", contender="cgal", status="timeout", seconds=None))
        runs += [row(pair="e"), row(pair="e", contender="cgal", seconds=0.0)]
        return results.Results(runs)

    def test_ratios(self):
        ratios = self.results().ratios("pairs", 1e-4, "auto", "cgal")
        self.assertEqual(ratios.values, {"a": 8, "b": 2, "c": 0.5})
        self.assertAlmostEqual(ratios.geometric_mean(), 2)
        self.assertEqual((ratios.median(), ratios.least(), ratios.most()), (2, ("c", 0.5), ("a", 8)))
        self.assertEqual((ratios.below(1), ratios.winnings()), ([(0.5, "c")], 2 / 3))

    def test_targets_losses_and_failures_are_named(self):
        found = self.results()
        self.assertIn("2.00x | **missed**", targets.table(found))
        self.assertIn("| c | 0.0001 | `cgal` | 0.500x", tables.losses(found))
        self.assertIn("| d | 0.0001 | `cgal` | timeout", tables.failures(found))

    def test_one_failed_repetition_is_a_failure(self):
        self.assertFalse(results.Result([row(), row(status="crash", seconds=None)]).finished)

    def test_the_newest_program_counts(self):
        found = results.Results([row(seconds=1.0), row(seconds=5.0, program="2")])
        self.assertEqual(found.cases["pairs", "p", 1e-4, ""]["auto"].seconds, 5)

    def test_an_interval_that_misses_the_reference(self):
        near = {"reference_lower": 1.002, "reference_upper": 1.003}
        self.assertTrue(results.Result([row(**near)]).is_wrong(None))
        self.assertFalse(results.Result([row(**near | {"upper": 1.0025})]).is_wrong(None))
        # The peer's number is good to its tolerance, here 0.001.
        self.assertFalse(results.Result([row(contender="cgal", **near, upper=1.0015, lower=1.0015)]).is_wrong(None))

    def test_growth(self):
        points = [(1000, 1.0), (2000, 2.0), (8000, 8.0)]
        self.assertAlmostEqual(results.slope(points), 1)
        self.assertEqual([round(factor, 9) for _, factor in results.doublings(points)], [2, 2])
        self.assertAlmostEqual(targets.bytes_per_triangle([(10, 1500), (20, 2500)]), 100)

    def test_an_interval_without_a_reference_is_held_against_auto(self):
        found = results.Results([row(), row(contender="other", lower=1.01, upper=1.02)])
        case = found.cases["pairs", "p", 1e-4, ""]
        self.assertEqual((case["other"].status, case["auto"].status), ("wrong interval", "converged"))
        self.assertIn("| p | 0.0001 | `other` | wrong interval", tables.failures(found))
        self.assertFalse(found.ratios("pairs", 1e-4, "auto", "other"))  # takes part in no mean
        self.assertTrue(results.Result([row(lower=2.0)]).is_wrong(None))  # lower > upper

    def test_the_papers_first_table(self):
        runs = [
            row(experiment="paper", pair=pair, tolerance=1e-3, contender=name, seconds=seconds)
            for pair in ("half/a", "remesh/b_ftet", "remesh/c_iso")
            for name, seconds in (("four_point", 1.0), ("triangle_set", 3.0))
        ]
        table = paper.table1(results.Results(runs))
        self.assertIn("| decimated | 0.001 of the unit, 180 s | 1 | 100 % / 97.65 % |", table)
        self.assertIn("| tetwild | 0.001 of the unit, 180 s | 1 |", table)
        self.assertIn("3.00x / 27.5x", table)
        self.assertEqual(len(table.splitlines()), 4)
        self.assertEqual(plan.paper_kind("remesh/tw107100_sf_iso"), "")


    def test_pairs_by_rank(self):
        runs = []
        for k in range(25):
            pair = dict(experiment="paper", pair=f"half/{k}", tolerance=1e-3, vertices_a=1000.0 - k)
            runs += [row(contender="four_point", **pair), row(contender="triangle_set", seconds=k + 1.0, **pair)]
        ratios = paper.speedups(results.Results(runs), "paper", 1e-3)["decimated"]
        points, groups = paper.by_rank(ratios)
        self.assertEqual((points[0], points[-1]), ((1, 25.0), (25, 1.0)))  # sorted by vertices
        self.assertEqual((len(groups), groups[0]), (10, (1.5, 24.5)))

    def test_tightness(self):
        names = ("pair", "strategy", "points", "mean_tightness", "median_tightness", "seconds_per_bound")
        rows = [
            dict(zip(names, values))
            for values in (
                (plan.TIGHTNESS_PAIR, "n_point", "4", "8", "7", "1e-6"),
                (plan.TIGHTNESS_PAIR, "n_point", "10", "6", "5", "3e-6"),
                (plan.TIGHTNESS_PAIR, "triangle_set", "", "5", "4", "9e-6"),
                ("a", "n_point", "4", "1", "2", "1e-6"),
            )
        ]
        table = paper.tightness(rows)
        self.assertIn("| res/hand_dec4 | `4-point` | 8.00 | 1.00 µs |", table)
        self.assertIn("| other pairs | `4-point` | 2.00 |", table)
        self.assertIn("res/hand_dec4: -1 a microsecond, -0.001 a nanosecond", table)

    def test_stages_of_a_series(self):
        runs = [
            row(experiment="placement", pair="place/x_d0.01", at=0.01, contender=name, survivors=500.0)
            for name in ("four_point", "triangle_set")
        ] + [row(experiment="placement", pair="place/x_d0", contender="four_point", status="timeout", seconds=None)]
        table = paper.stage_table(results.Results(runs), "placement")
        self.assertIn("| x | 0.01 | 250 ms + 250 ms | 1.00 s | 75 % | 250 ms + 250 ms | 1.00 s | 75 % |", table)
        self.assertIn("| x | 0 | – | timeout | – | – | – | – |", table)
        runs = [row(experiment="resolution", pair="res/x_dec1", contender="four_point", survivors=9.0, subdivisions=40.0)]
        self.assertIn("| x | dec1 | 2 000 | 9 | 40 | – | – |", paper.subdivisions(results.Results(runs)))

    def test_the_handicap_is_named_wherever_triangle_set_is_shown(self):
        own, theirs = results.Results([row()]), results.Results([row(), row(contender="triangle_set")])
        tables_of = (tables.finished, tables.process, tables.speedups, tables.by_kind)
        for make in tables_of:
            made = {"x": lambda make=make: make(theirs)}
            filled = page.fill("<!-- figures: x -->\n<!-- end -->", made)
            self.assertIn("-->\n`triangle_set` has a [handicap](#the", filled)
            self.assertNotIn("handicap", text.with_handicap(make(own)))
        self.assertIn("\n`triangle_set` has a [handicap](../benchmarks.md#the", tables.all_pairs(theirs))

    def test_sentences(self):
        run = row(contender="four_point", queries=30.0, cache_hits=10.0, subdivisions=4.0)
        self.assertIn("4 subdivisions, 30 queries, and 10 points (25 % of all)", paper.sharing(results.Results([run])))
        micro = {"benchmarks": [{"name": "distance_point_triangle", "real_time": 10.0}]}
        self.assertIn("No figures", paper.distances(micro))
        micro["benchmarks"].append({"name": "distance_triangle_triangle", "real_time": 80.0})
        self.assertIn("8.00x", paper.distances(micro))

    def test_published_codes_and_samplers(self):
        runs = [
            row(kind="smooth"),
            row(kind="smooth", contender="x", seconds=30.0),
            row(kind="smooth", contender="y", seconds=10.0),
            row(kind="smooth", contender="z", status="timeout", seconds=None),
            row(kind="smooth", contender="s", status="sampled", seconds=5.0, lower=0.9, upper=None),
        ]
        found = results.Results(runs)
        self.assertEqual(found.published(), ["x", "y", "z"])
        self.assertEqual(found.over_published(1e-4).values, {"p": 10})
        self.assertIn("kind smooth, geometric mean | ≥ 20x | 10.0x | **missed**", targets.table(found))
        self.assertIn("over the fastest of `x`, `y`, `z`", tables.by_kind(found))
        self.assertIn("samples of `s` | 0.0001 | 1 of 1 | 5.00x | 5.00x | 10 % | 10 % |", tables.samples(found))
        self.assertNotIn("`s`", tables.finished(found))
        runs += [row(pair="q", contender="x", program="2"), row(pair="q")]
        self.assertIn("several builds (x: 2)", tables.mixed(results.Results(runs)))
        self.assertIn("come from one build", tables.mixed(found))


class Rivals(Folder):
    def test_an_argument(self):
        self.assertEqual(rivals.parsed("mine=sh -c 'a b'", contenders.is_own).command[1:], ("-c", "a b"))
        for wrong in ("sh", "A=sh", "auto=sh", "mine=", "mine=no-such-program"):
            with self.assertRaises(SystemExit):
                rivals.parsed(wrong, contenders.is_own)

    def test_an_answer(self):
        good = {"status": "converged", "lower": 1, "upper": 2, "user_s": 0.5}
        self.assertEqual(rivals.outcome(json.dumps(good), 3.0)["seconds"], 0.5)
        self.assertEqual(rivals.outcome('{"status": "timeout"}', 3.0), {"status": "timeout"})
        sampled = rivals.outcome('{"status": "sampled", "lower": 1, "user_s": 0.5}', 3.0)
        self.assertEqual((sampled["lower"], sampled["upper"]), (1, None))
        for wrong in ("", "[]", "{}", json.dumps(good | {"upper": "x"}), json.dumps(good | {"lower": math.nan})):
            with self.assertRaises((ValueError, KeyError, TypeError)):
                rivals.outcome(wrong, 3.0)

    def test_a_record(self):
        path = self.folder / "record.tsv"
        path.write_text(
            "# measured elsewhere\n# pair\ttolerance\ttriangles of A\tof B\tx\ty\tmeshgauge\n"
            "half/a\t0.0001\t8\t4\t8.0\t2.0\t1.0\nhalf/b\t0.0001\t8\t4\ttimeout\t8.0\t1.0\n"
            "half/c\t0.0001\t8\t4\t0\t8.0\t1.0\n"
        )
        record = rivals.Record.read(path)
        table = record.table()
        self.assertIn("Measured elsewhere.", table)
        self.assertIn("| x | 0.0001 | 3 | 8.00x | 8.00x | 8.00x | 1 | 1 | 1 |", table)
        self.assertIn("| the faster of them | 0.0001 | 3 | 4.00x | 2.00x | 8.00x | 0 | 0 | 1 |", table)
        self.assertIn("| half | 0.0001 | 2 | 4.00x |", record.by_kind())
        path.write_text("# pair\ttolerance\tx\tmeshgauge\nhalf/a\t0.1\t8.0\n")
        with self.assertRaisesRegex(SystemExit, "line 2"):
            rivals.Record.read(path)


class Meshes(Folder):
    def test_a_torus_is_closed(self):
        points, faces = meshes.torus(500)
        edges = [edge for a, b, c in faces for edge in ((a, b), (b, c), (c, a))]
        self.assertEqual(len(edges), len(set(edges)))
        self.assertEqual(set(edges), {(b, a) for a, b in edges})
        self.assertEqual({i for face in faces for i in face}, set(range(len(points))))

    def test_every_format_is_the_same_mesh(self):
        a = self.folder / "a.ply"
        meshes.write(meshes.torus(500), a)
        for suffix in meshes.WRITERS:
            b = self.folder / ("b" + suffix)
            meshes.write(meshes.torus(500), b)
            done = subprocess.run(
                [BUILD / "meshgauge", "compare", a, b, "--json"], capture_output=True, text=True, check=True
            )
            answer = json.loads(done.stdout)
            self.assertEqual(answer["meshes"]["b"]["triangles"], answer["meshes"]["a"]["triangles"])
            self.assertLess(answer["distance"]["lower"], 1e-6)

    def test_pairs_of_a_folder(self):
        for name in ("one/b.obj", "one/a.obj", "two/a.stl", "two/b.ply.gz", "lonely/a.obj"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            (self.folder / name).touch()
        found = pairs.in_folder(self.folder, self.folder)
        self.assertEqual(
            [(pair.name, pair.a.name, pair.b.name) for pair in found],
            [("one", "a.obj", "b.obj"), ("two", "a.stl", "b.ply.gz")],
        )


class EndToEnd(Folder):
    def bench(self, *flags):
        command = [sys.executable, HERE / "run.py", "--quick", "--limit-gib", "1", "--build", BUILD, "--out", self.folder / "out", *flags]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return store.Store(self.folder / "out").open().rows

    def test_it_measures_goes_on_and_reports(self):
        flags = ("--contenders", "auto,four_point", "--experiments", "pairs,gate,growth,placement,reading")
        rows = self.bench(*flags)
        self.assertEqual({r["experiment"] for r in rows}, {"pairs", "gate", "growth", "placement", "reading"})
        self.assertLessEqual({r["status"] for r in rows}, set(contenders.FINISHED))
        for r in rows:
            self.assertLessEqual(r["lower"], r["upper"])
            self.assertGreater(r["seconds"], 0)
            self.assertGreater(r["peak_bytes"], 1 << 20)
            self.assertFalse(math.isnan(r["wall"]))
        verdicts = {(r["gate"], r["verdict"]) for r in rows if r["gate"]}
        self.assertEqual(verdicts, {("2h", "pass"), ("h/2", "fail")})
        self.assertEqual(self.bench(*flags), rows)  # nothing is left to measure
        written = (self.folder / "out/benchmarks.md").read_text()
        self.assertIn("| `auto` finishes at 0.0001 | every pair | 5 of 5 | met |", written)
        self.assertTrue((self.folder / "out/benchmarks/results.csv").exists())

    def test_a_rival_takes_part(self):
        program = self.folder / "rival.py"
        program.write_text(RIVAL.format(meshgauge=BUILD / "meshgauge"))
        flags = ("--contenders", "auto", "--rival", f"double={sys.executable} {program}", "--experiments", "pairs,paper")
        rows = [r for r in self.bench(*flags) if r["contender"] == "double"]
        self.assertEqual({r["status"] for r in rows}, {"converged"})
        self.assertEqual({r["seconds"] for r in rows}, {0.25})
        page_text = (self.folder / "out/benchmarks.md").read_text()
        self.assertIn("| 0.0001 | `double` | 5 | 20 % | 0 | 0 | 4 | 0 |", page_text)  # twice 0 is right

    def test_every_marker_of_the_page_has_its_figures(self):
        made = page.fragments(results.Results([row()]), self.folder, [])
        filled = page.fill(page.PAGE.read_text(), made)
        self.assertEqual({name for _, name, _ in page.MARKED.findall(filled)}, set(made))
        self.assertEqual(page.fill(filled, made), filled)


if __name__ == "__main__":
    unittest.main()
