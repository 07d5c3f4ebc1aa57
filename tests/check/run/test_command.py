"""`meshgauge check`: verdicts, exit codes and what is printed."""

import itertools
import json
import os
import stat
import subprocess
import unittest

from contract import validate
from harness import BINARY, ENVIRONMENT, ROOT, SLOW, wavy_grid
from workplace import Workplace, square, threads

PASS, FAIL, UNDECIDED, ERROR = "pass", "fail", "undecided", "error"
CODES = {PASS: 0, FAIL: 1, UNDECIDED: 2, ERROR: 3}
WORST_FIRST = (ERROR, FAIL, UNDECIDED, PASS)


def stl(height):
    """A square at this height, as an STL."""
    corners = [(x, y, height) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    facets = ["facet normal 0 0 1\nouter loop\n%sendloop\nendfacet\n" % "".join("vertex %r %r %r\n" % corners[i] for i in three)
              for three in ((0, 1, 2), (0, 2, 3))]
    return "solid s\n" + "".join(facets) + "endsolid s\n"


class Pair(Workplace):
    def test_exit_codes_of_a_pair(self):
        pair = ("flat.obj", "raised.obj")
        self.exits(0, *pair, "--max-distance", "2.001")
        self.exits(1, *pair, "--max-distance", "1.999 mm")
        self.exits(3, *pair, "--max-distance", "2", "--strategy", "best")
        self.exits(3, "none.obj", "flat.obj", "--max-distance", "2")

    def test_the_limit_is_a_share_of_the_baselines_diagonal(self):
        self.file("large.obj", square(size=10.0))  # diagonal 14.14
        one_way = ("flat.obj", "large.obj", "--direction", "candidate_to_baseline")
        report = self.report(0, *one_way, "--max-distance", "0.01 %")
        self.assertAlmostEqual(report["gates"][0]["limit"]["max_distance"], 1e-4 * 200 ** 0.5)
        self.assertEqual(report["gates"][0]["limit"]["diagonal_share"], 1e-4)
        self.exits(1, "flat.obj", "large.obj", "--max-distance", "85 %")  # the far corner is 90 % of it away
        self.exits(0, "flat.obj", "large.obj", "--max-distance", "91 %")

    def test_a_hole_is_found_at_its_place(self):
        self.file("hole.obj", square(hole=True))
        gate = self.report(1, "hole.obj", "flat.obj", "--max-distance", "0.1 mm")["gates"][0]
        self.assertEqual(gate["verdict"], FAIL)
        self.assertEqual(gate["witness"]["on"], "baseline")
        x, y, z = gate["witness"]["point"]
        self.assertGreater(y - x, 0.1)  # in the triangle that is missing
        self.assertEqual(z, 0)
        self.assertEqual(gate["witness"]["triangle"], 1)
        self.assertIn("The candidate lacks", gate["advice"])

    def test_undecided_by_its_timeout_says_what_would_decide(self):
        a, b = self.file("1.obj", SLOW["a"]), self.file("2.obj", SLOW["b"])
        hard = (a, b, "--max-distance", "0", "--strategy", "four_point", "--timeout", "500 ms")
        gate = self.report(2, *hard)["gates"][0]
        self.assertEqual(gate["verdict"], UNDECIDED)
        self.assertEqual(gate["comparison"]["status"], "timeout")
        self.assertRegex(gate["advice"], r"^Decided by a limit of at least \S+ \(pass\); or a longer timeout than 0.5 s\.$")
        self.exits(1, *hard, "--undecided", "fail")
        self.exits(0, *hard, "--undecided=warn")
        # The limit that the advice names decides.
        self.exits(0, a, b, "--max-distance", repr(gate["distance"]["upper"]), "--strategy", "four_point")

    def test_a_limit_of_the_area(self):  # all of both squares is at 2
        pair = ("flat.obj", "raised.obj")
        self.exits(0, *pair, "--max-share-beyond", "2.5 mm: 0 %")
        self.exits(1, *pair, "--max-share-beyond", "1.5 mm: 99 %")
        self.exits(0, *pair, "--max-share-beyond", "1.5 mm: 100 %")
        self.exits(1, *pair, "--max-share-beyond", "2.5 mm: 0 %", "--max-distance", "1 mm")
        self.exits(3, *pair, "--max-share-beyond", "2.5 mm: 0 %", "--max-distance", "3 in")
        self.exits(3, *pair, "--max-share-beyond", "1.5 mm: 120 %")
        gate = self.report(2, *pair, "--max-share-beyond", "2: 50 %")["gates"][0]  # within rounding error of 2
        [share] = gate["criteria"]
        self.assertEqual((share["name"], share["limit"]), ("share beyond", 0.5))
        self.assertLess(share["lower"], 0.5)
        self.assertGreater(share["upper"], 0.5)
        self.assertEqual(gate["limit"], {"max_distance": None, "diagonal_share": None, "units": None,
                                         "max_share_beyond": {"distance": 2, "diagonal_share": None, "share": 0.5}})
        self.assertIn("another distance than 2: part of the area", gate["advice"])

    def test_an_uncertainty(self):  # both squares are 2 apart
        pair = ("flat.obj", "raised.obj", "--uncertainty", "0.25 mm")
        self.exits(0, *pair, "--max-distance", "2.26 mm")
        self.exits(1, *pair, "--max-distance", "1.74 mm")
        self.exits(0, *pair, "--max-share-beyond", "2.26 mm: 0 %")
        self.exits(1, *pair, "--max-share-beyond", "1.74 mm: 1 %")
        self.exits(2, *pair, "--max-share-beyond", "2.1 mm: 1 %")
        self.exits(3, *pair, "--max-distance", "0.2 mm")
        self.exits(3, *pair, "--max-distance", "3 in")
        for limit in ("1.9 mm", "2.1 mm"):
            gate = self.report(2, *pair, "--max-distance", limit)["gates"][0]
            self.assertEqual(gate["limit"]["uncertainty"], 0.25)
            self.assertIn("closer to its limit than the uncertainty", gate["advice"])

    def test_the_example_of_metrology(self):
        text = (ROOT / "docs/metrology.md").read_text().split("```yaml\n")[1].split("```")[0]
        self.file("tolerance.yaml", text)
        self.file("nominal/part.stl", stl(0))
        for height, code in ((0.03, 0), (0.045, 2), (0.055, 2), (0.07, 1), (0.6, 1)):
            self.file("scans/part.stl", stl(height))
            self.assertEqual([gate["name"] for gate in self.report(code, "tolerance.yaml")["gates"]],
                             ["profile-part", "area-part"])

    CLOUDS = {"cut.obj": square().split(b"f", 1)[0],
              "none.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                          b"element face 0\nproperty list uchar int vertex_indices\nend_header\n0.5 0.5 0\n"}

    def test_a_candidate_without_faces_is_a_cloud_only_if_it_is_declared(self):
        one_way = ("flat.obj", "--max-distance", "0.1", "--direction", "candidate_to_baseline")
        for name, data in self.CLOUDS.items():
            self.file(name, data)
            gate = self.report(3, name, *one_way)["gates"][0]
            self.assertEqual((gate["verdict"], gate["distance"], gate["comparison"]), (ERROR, None, None))
            self.assertRegex(gate["error"]["message"], r"' has \d points? and no faces; .*, declare it by --cloud$")
            self.exits(3, name, *one_way, "--undecided=warn")
            self.exits(0, name, *one_way, "--cloud")
            self.exits(3, name, *one_way[:-2], "--cloud")  # the distance to a cloud is not known
        self.file("scan.xyz", "0.5 0.5 0\n")
        self.exits(0, "scan.xyz", *one_way)
        self.exits(0, "flat.obj", "raised.obj", "--max-distance", "3", "--cloud")
        self.fails(self.manifest([("part", "flat.obj", "raised.obj", 3)]), "--cloud", saying="--cloud")

    def test_a_file_is_not_its_own_baseline(self):
        os.symlink("flat.obj", self.folder / "link.obj")
        for other in ("flat.obj", "./flat.obj", "link.obj"):
            self.fails("flat.obj", other, "--max-distance", "1", saying="the same file")

    def test_a_name_cannot_speak_to_the_runner(self):
        name = "a\n::error::b\033[31m\u202e.obj"
        self.file(name, square())
        for arguments in (("--update-baselines",), ("--max-distance", "1", "--json=" + name)):
            result = self.check("flat.obj", name, *arguments)
            self.assertIn("::error::b\\x1B[31m\\u202E.obj", result.stdout + result.stderr)
            for line in (result.stdout + result.stderr).splitlines():
                self.assertNotIn("\033", line)
                self.assertNotIn("\u202e", line)
                self.assertFalse(line.startswith("::"))

    def test_flags_that_do_not_fit(self):
        pair = ("flat.obj", "raised.obj")
        self.fails(*pair, saying="--max-distance")
        for limit in ("1,5 mm", "-1", "nan", "2 m 3", ""):
            self.fails(*pair, "--max-distance", limit, saying="--max-distance")
        limited = (*pair, "--max-distance", "1")
        self.fails(*limited, "--direction", "up", saying="baseline_to_candidate")
        self.fails(*limited, "--timeout", "soon", saying="--timeout")
        self.fails(*limited, "--timeout", "1 h 3", saying="--timeout")
        self.fails(*limited, "--threads", "65", saying="--threads")
        self.fails(*limited, "--jobs", "-1", saying="--jobs")
        self.fails(*limited, "--undecided", "maybe", saying="--undecided")
        self.fails(*limited, "--dry-run", saying="--update-baselines")
        self.fails("--max-distance", "1", saying="CANDIDATE BASELINE")
        self.fails("a", "b", "c", "--max-distance", "1", saying="c")


class Manifest(Workplace):
    GATES = {PASS: ("good", "flat.obj", "raised.obj", "2.5 mm"), FAIL: ("bad", "flat.obj", "raised.obj", "1.5 mm"),
             UNDECIDED: ("hard", "1.obj", "2.obj", "0", "strategy: four_point", "timeout: 300 ms"),
             ERROR: ("broken", "broken.obj", "flat.obj", "1")}

    def setUp(self):
        super().setUp()
        self.file("1.obj", SLOW["a"])
        self.file("2.obj", SLOW["b"])
        self.file("broken.obj", "v 0 0 zero\n")

    def test_exit_codes_of_every_mix(self):
        for count in range(1, 5):
            for mix in itertools.combinations(WORST_FIRST, count):
                self.manifest([self.GATES[verdict] for verdict in reversed(mix)])
                report = self.report(CODES[mix[0]], "gates.yaml")
                self.assertEqual([gate["verdict"] for gate in report["gates"]], list(reversed(mix)))
                self.assertEqual(report["exit_code"], CODES[mix[0]])
                self.assertEqual({v for v, n in report["counts"].items() if n}, set(mix))

    def test_gates_that_only_warn(self):
        warn = [(*self.GATES[verdict], "on_fail: warn") for verdict in (PASS, FAIL, UNDECIDED)]
        self.manifest(warn)
        report = self.report(0, "gates.yaml")
        self.assertEqual([gate["level"] for gate in report["gates"]], ["ok", "warning", "warning"])
        self.manifest(warn + [(*self.GATES[ERROR], "on_fail: warn")])
        self.exits(3, "gates.yaml")

    def test_undecided_counts_as_asked(self):
        self.manifest([self.GATES[PASS], self.GATES[UNDECIDED]])
        for rule, code, level in (("fail", 1, "failure"), ("warn", 0, "warning")):
            report = self.report(code, "gates.yaml", "--undecided", rule)
            self.assertEqual(report["gates"][1]["level"], level)
        self.manifest([self.GATES[FAIL], self.GATES[UNDECIDED]])
        self.exits(1, "gates.yaml", "--undecided", "warn")

    def test_only_some(self):
        self.manifest([self.GATES[PASS], self.GATES[FAIL]])
        self.assertEqual([g["name"] for g in self.report(0, "gates.yaml", "--only", "go*")["gates"]], ["good"])
        self.exits(1, "gates.yaml", "--only", "*")
        self.fails("gates.yaml", "--only", "none*", saying="none*")
        both = self.report(1, "gates.yaml", "--only", "go*", "--only", "b?d")["gates"]
        self.assertEqual([gate["name"] for gate in both], ["good", "bad"])
        self.fails("gates.yaml", "--only", "go*", "--only", "none*", saying="none*")
        for empty in (("--only", ""), ("--only=",), ("--only", "good", "--only", "")):
            self.fails("gates.yaml", *empty, saying="--only")

    def test_clouds_are_declared_by_a_gate_or_by_the_defaults(self):
        self.file("cut.obj", Pair.CLOUDS["cut.obj"])
        cut, one_way = ("cut", "cut.obj", "flat.obj", "0.1 mm"), "direction: candidate_to_baseline"
        gate = self.report(3, self.manifest([(*cut, one_way, "on_fail: warn")]))["gates"][0]
        self.assertIn("'cut.obj' has 4 points and no faces; ", gate["advice"])
        self.assertIn("'cloud: true' in the manifest", gate["advice"])
        self.exits(0, self.manifest([(*cut, one_way, "cloud: true")]))
        self.exits(0, self.manifest([(*cut, one_way)], "cloud: true"))
        self.exits(3, self.manifest([(*cut, one_way, "cloud: false")], "cloud: true"))
        result = self.exits(1, self.manifest([(*cut, one_way, "cloud: true", "expect: {oriented: true}")]))
        self.assertIn("oriented: no", result.stdout)

    def test_what_is_not_asked_for_need_not_be_there(self):
        self.manifest([self.GATES[PASS], ("other", "none.obj", "none.obj", "1")])
        self.exits(3, "gates.yaml")
        self.exits(0, "gates.yaml", "--only", "good")

    def test_flags_of_two_files_do_not_go_with_a_manifest(self):
        self.manifest([self.GATES[PASS]])
        for flag, value in (("--max-distance", "1"), ("--direction", "symmetric"), ("--strategy", "auto")):
            self.fails("gates.yaml", flag, value, saying=flag)

    def test_timeout_and_threads_by_flag_are_for_every_gate(self):
        self.manifest([self.GATES[PASS], self.GATES[FAIL]])
        report = self.report(1, "gates.yaml", "--timeout", "7 s", "--threads", "3", "--statistics")
        for gate in report["gates"]:
            self.assertEqual(gate["timeout_ms"], 7000)
            self.assertEqual(gate["comparison"]["engine"]["threads"], 3)
            self.assertIsNotNone(gate["comparison"]["statistics"])

    def test_mistakes_of_the_manifest_stop_everything_and_name_their_lines(self):
        self.file("gates.yaml", "version: 1\ngates:\n  - name: a\n    candidat: flat.obj\n    baseline: none.obj\n"
                                "    max_distance: 1,5\n")
        result = self.fails("gates.yaml", saying="gates.yaml:4:")
        self.assertIn("gates.yaml:6:", result.stderr)
        self.fails("nowhere.yaml", saying="nowhere.yaml")

    def test_reports_say_why_nothing_was_measured(self):
        reports = {"--json": "report.json", "--junit": "junit.xml", "--sarif": "report.sarif", "--markdown": "summary.md",
                   "--code-quality": "quality.json", "--html": "report.html"}
        flags = [f"{flag}={file}" for flag, file in reports.items()]

        def refused(words, *wrong):
            for file in reports.values():
                self.file(file, "of an earlier run, that passed")
            self.exits(3, "gates.yaml", *flags, *wrong)
            for file in reports.values():
                self.assertIn(words, (self.folder / file).read_text(), file)

        self.manifest([self.GATES[PASS]])
        refused("nowhere", "--only", "nowhere")
        refused("soon", "--timeout", "soon")
        refused("jobs", "--jobs", "-1")
        self.manifest([self.GATES[PASS], self.GATES[PASS], ("third", "none.obj", "flat.obj", "1")])
        refused("none.obj")
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual((report["exit_code"], report["counts"]["error"]), (3, 2))
        self.assertEqual([gate["manifest"]["line"] for gate in report["gates"]], [7, 12])
        self.assertEqual(report["gates"][1]["name"], "gates.yaml:12:16")
        self.assertIn("'none.obj' does not exist", report["gates"][1]["error"]["message"])
        self.assertEqual((self.folder / "junit.xml").read_text().count("<error "), 2)

    def test_files_that_are_taken_for_others(self):
        self.manifest([self.GATES[PASS]])
        self.fails("flat.obj", saying="'flat.obj' is a mesh: name its baseline")
        self.fails("flat.STL.gz", saying="is a mesh")
        self.assertIn("--json=out.json", self.exits(3, "gates.yaml", "--json", "out.json").stderr)
        self.fails("gates.yaml", "flat.obj", "--max-distance", "1", saying="is a manifest: give it alone")
        self.fails("flat.obj", "gates.yaml", "--max-distance", "1", saying="is a manifest: give it alone")

    def test_new_baselines_are_not_reported(self):
        self.manifest([self.GATES[PASS]])
        for flag in ("--json", "--junit=x", "--sarif=x", "--markdown=x", "--code-quality=x", "--html=x", "--pictures=x",
                     "--deviation=x", "--server=http://127.0.0.1:1", "--statistics", "--undecided=warn",
                     "--against=main"):
            self.fails("gates.yaml", "--update-baselines", "--dry-run", flag, saying=flag.split("=")[0])
        self.exits(0, "gates.yaml", "--update-baselines", "--dry-run")

    @unittest.skipIf(os.geteuid() == 0, "root may read everything")
    def test_an_unreadable_file(self):
        os.chmod(self.folder / "raised.obj", 0)
        self.addCleanup(os.chmod, self.folder / "raised.obj", stat.S_IRUSR)
        gate = self.report(3, "flat.obj", "raised.obj", "--max-distance", "1")["gates"][0]
        self.assertIn("Permission denied", gate["error"]["message"])

    def test_files_that_cannot_be_measured(self):
        self.file("empty.obj", "")
        self.file("nan.obj", square().replace(b"v 1 1 0", b"v nan 1 0").replace(b"v 1.0 1.0 0", b"v nan 1 0"))
        for name, saying in (("none.obj", "No such file"), ("empty.obj", "'empty.obj'"), ("nan.obj", "line 3 of 'nan.obj'"),
                             (".", "is a folder"), ("/dev/zero", "not a regular file")):
            for pair in ((name, "flat.obj"), ("flat.obj", name)):
                gate = self.report(3, *pair, "--max-distance", "1")["gates"][0]
                self.assertEqual(gate["verdict"], ERROR)
                self.assertIn(saying, gate["error"]["message"])
                self.assertIsNone(gate["comparison"])


class SameAsCompare(Workplace):
    def compared(self, a, b, *flags):
        done = subprocess.run([BINARY, "compare", a, b, "--json", *flags], capture_output=True, text=True, check=True,
                              cwd=self.folder, env=ENVIRONMENT)
        return json.loads(done.stdout)

    def test_the_same_bits_on_one_thread(self):
        self.file("fine.obj", wavy_grid(40, 0.1))
        self.file("coarse.obj", wavy_grid(31, 0.103))
        limit = "0.004"
        flags = ("--max-distance", limit, "--threads", "1", "--fast")  # how far narrowing gets depends on the time that it takes
        gates = self.report(0, "fine.obj", "coarse.obj", *flags)["gates"]
        self.manifest([(name, "fine.obj", "coarse.obj", limit, "threads: 1") for name in ("one", "two", "three")])
        gates += self.report(0, "gates.yaml", "--jobs", "3", "--fast")["gates"]
        expected = self.compared("fine.obj", "coarse.obj", *flags, "--diagonal", "1e-9")
        for gate in gates:
            document = gate["comparison"]
            validate(document, "Comparison")
            for changing in ("id", "timings_ms"):
                del document[changing]
                expected.pop(changing, None)
            self.assertEqual(document, expected)


class MeshesAreShared(Workplace):
    def test_a_baseline_of_many_gates_is_read_once(self):
        self.file("baseline.obj", wavy_grid(250, 0.1))
        for i in range(8):
            self.file("candidate%d.obj" % i, wavy_grid(5, 0.1 + i / 1e4))
        self.manifest([("gate%d" % i, "candidate%d.obj" % i, "baseline.obj", 1) for i in range(8)])
        report = self.report(0, "gates.yaml", "--jobs", "1")
        waited = [gate["comparison"]["timings_ms"]["read_b"] for gate in report["gates"]]
        # The first gate reads the baseline. The others find it, in almost no time.
        self.assertGreater(max(waited), 20 * sorted(waited)[-2])


class Terminal(Workplace):
    def on_a_terminal(self, *arguments, environment=None):
        """Exit code, and what a terminal of 80 columns was sent."""
        master, slave = os.openpty()
        process = self.start(*arguments, stdout=slave, stderr=slave, environment=environment)
        os.close(slave)
        seen = b""
        while True:
            try:
                piece = os.read(master, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            seen += piece
        os.close(master)
        return process.wait(60), seen.decode()

    def test_colours_unless_they_are_switched_off(self):
        arguments = ("flat.obj", "raised.obj", "--max-distance", "1.5")
        for extra, environment, coloured in (((), {}, True), ((), {"NO_COLOR": ""}, True), ((), {"NO_COLOR": "1"}, False),
                                             (("--no-colour",), {}, False), (("--no-color",), {}, False)):
            code, seen = self.on_a_terminal(*arguments, *extra, environment=environment)
            self.assertEqual(code, 1)
            self.assertIn("FAIL", seen)
            self.assertEqual("\033[31mFAIL" in seen, coloured, (extra, environment))

    def test_progress_is_drawn_and_gone(self):
        a, b = self.file("1.obj", SLOW["a"]), self.file("2.obj", SLOW["b"])
        code, seen = self.on_a_terminal(a, b, "--max-distance", "0", "--strategy", "four_point", "--timeout", "1 s")
        self.assertEqual(code, 2)
        self.assertIn("0 of 1 gates", seen)
        self.assertIn("\033[J", seen)
        after = seen[seen.rindex("\033[J"):]
        self.assertIn("UNDECIDED", after)
        self.assertNotIn("of 1 gates", after)


if __name__ == "__main__":
    unittest.main()
