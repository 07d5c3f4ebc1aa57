"""`meshgauge check`: what it writes: reports, deviation maps, new baselines."""

import json
import os
import unittest
import xml.etree.ElementTree

from workplace import Workplace, square


class Reports(Workplace):
    LIMIT = ("--max-distance", "1.5 mm")

    def test_the_report_goes_to_a_file_and_the_table_to_standard_output(self):
        result = self.exits(1, "flat.obj", "raised.obj", *self.LIMIT, "--json=report.json")
        self.assertIn("FAIL", result.stdout)
        self.assertIn("at most 1.5 mm", result.stdout)
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(report["exit_code"], 1)
        self.assertRegex(report["version"], r"^\d+\.\d+\.\d+$")

    def test_a_report_on_standard_output_is_alone_there(self):
        result = self.exits(1, "flat.obj", "raised.obj", *self.LIMIT, "--json")
        json.loads(result.stdout)
        self.assertIn("FAIL", result.stderr)

    def test_each_report_names_what_is_not_as_expected(self):
        manifest = self.manifest([("part", "raised.obj", "flat.obj", "3 mm", "expect: {watertight: true, triangles: {max: 1}, components: 1}")])
        kinds = ("json", "html", "junit", "markdown", "sarif", "code-quality")
        result = self.exits(1, manifest, *("--%s=out.%s" % (kind, kind) for kind in kinds))
        self.assertIn("watertight: no: 4 open edges, the first at (0.5, 0, 2) mm, expected yes",
                      result.stdout)
        for kind in kinds:
            text = (self.folder / ("out." + kind)).read_text().replace("&#58;", ":")
            self.assertIn("4 open edges, the first at (0.5, 0, 2) mm", text, kind)
            self.assertIn("at most 1", text, kind)
        sarif = json.loads((self.folder / "out.sarif").read_text())["runs"][0]
        self.assertEqual(sarif["results"][0]["ruleId"], "MG0005")
        self.assertEqual(sarif["tool"]["driver"]["rules"][sarif["results"][0]["ruleIndex"]]["id"], "MG0005")
        self.assertIn("meshgauge/expectation-not-met", (self.folder / "out.code-quality").read_text())
        self.exits(0, self.manifest([("part", "raised.obj", "flat.obj", "3 mm", "expect: {triangles: 2}")]))
        pair = ("raised.obj", "flat.obj", "--max-distance", "3 mm", "--expect")
        self.exits(0, *pair, "{triangles: 2, watertight: false}")
        self.assertIn("triangles: 2, expected 1", self.exits(1, *pair, "{triangles: 1}").stdout)
        self.fails(*pair, "{triangle: 1}", saying="--expect: unknown key 'triangle'")
        self.fails(*pair, "watertight", saying="--expect must be a map")
        self.fails("gates.yaml", "--expect", "{triangles: 1}", saying="--expect")
        self.exits(0, self.manifest([("part", "raised.obj", "flat.obj", "3 mm", "expect: {triangles: 1}", "on_fail: warn")]))

    def test_progress_is_plain_lines_without_a_terminal(self):
        result = self.exits(1, "flat.obj", "raised.obj", *self.LIMIT)
        self.assertRegex(result.stderr, r"^\[1/1\] FAIL  flat\.obj  .*\n$")
        self.assertNotIn("\033", result.stdout + result.stderr)

    def test_quiet_says_nothing_of_what_passes(self):
        result = self.exits(0, "flat.obj", "raised.obj", "--max-distance", "3", "--quiet")
        self.assertEqual((result.stdout, result.stderr), ("", ""))
        result = self.exits(1, "flat.obj", "raised.obj", *self.LIMIT, "--quiet")
        self.assertIn("FAIL", result.stdout)
        self.assertEqual(result.stderr, "")

    def test_reports_that_cannot_be_written_are_refused_before_the_work(self):
        pair = ("flat.obj", "raised.obj", *self.LIMIT)
        self.fails(*pair, "--json=none/report.json", saying="--json")
        self.fails(*pair, "--json=.", saying="--json")

    def test_nothing_is_written_over_what_is_read(self):
        for name in ("new.obj", "ref.ply"):
            self.file(name, square())
        os.link(self.folder / "ref.ply", self.folder / "hard.ply")
        os.symlink("ref.ply", self.folder / "soft.ply")
        pair = ("new.obj", "ref.ply", "--max-distance", "1")
        for name in ("ref.ply", "./ref.ply", "hard.ply", "soft.ply"):
            self.fails(*pair, "--deviation", name, saying="is the baseline of the gate")
            self.fails(*pair, "--html", name, saying="is the baseline of the gate")
        self.fails(*pair, "--json=new.obj", saying="is the candidate of the gate")
        self.manifest([("bracket", "flat.obj", "baselines/bracket.ply", 1)])
        self.file("baselines/bracket.ply", "ply\n")
        self.fails("gates.yaml", "--deviation", "baselines", saying="is the baseline of the gate 'bracket'")
        self.fails("gates.yaml", "--junit", "baselines/../gates.yaml", saying="is the manifest")
        self.assertEqual((self.folder / "ref.ply").read_bytes(), square())
        self.assertEqual((self.folder / "new.obj").read_bytes(), square())
        self.assertEqual((self.folder / "baselines/bracket.ply").read_bytes(), b"ply\n")

    def test_two_reports_do_not_share_a_file(self):
        pair = ("flat.obj", "raised.obj", "--max-distance", "3")
        self.fails(*pair, "--json=out", "--junit", "./out", saying="--junit: './out' is written by --json as well")
        self.fails(*pair, "--json=out.ply", "--deviation", "out.ply", saying="is written by --json as well")
        self.fails(*pair, "--json", "--junit", "-", saying="is used by --json already")
        self.assertFalse((self.folder / "out").exists())

    def test_a_full_disk_is_an_error(self):
        with open("/dev/full", "w") as full:
            result = self.exits(3, "flat.obj", "raised.obj", "--max-distance", "3", stdout=full)
        self.assertIn("could not be written", result.stderr)


    def test_all_reports_at_once_also_when_gates_fail(self):
        self.manifest([("good", "flat.obj", "raised.obj", 3), ("bad", "flat.obj", "raised.obj", 1)])
        asked = {"--junit": "r.xml", "--sarif": "r.sarif", "--markdown": "r.md", "--code-quality": "r.quality",
                 "--html": "r.html", "--json": "r.json"}
        self.exits(1, "gates.yaml", *("%s=%s" % pair for pair in asked.items()))
        text = {flag: (self.folder / name).read_text() for flag, name in asked.items()}
        suites = xml.etree.ElementTree.fromstring(text["--junit"])
        self.assertEqual(len(suites.findall(".//failure")), 1)
        self.assertEqual(len(json.loads(text["--sarif"])["runs"][0]["results"]), 1)
        self.assertEqual(len(json.loads(text["--code-quality"])), 1)
        for flag in ("--markdown", "--html", "--json"):
            self.assertIn("good", text[flag])
            self.assertIn("bad", text[flag])
        self.assertIn("data:image/png", text["--html"])  # pictures of the meshes, too

    def test_no_name_is_a_command_of_githubs_log(self):
        self.manifest([("'##[error]x'", "flat.obj", "raised.obj", 1), ("'::error::y'", "gone.obj", "raised.obj", 1)])
        for flags in ((), ("--only", "##[group]w"), ("--html=##[add-mask]/v",)):
            result = self.exits(3, "gates.yaml", *flags, "--no-annotations", environment={"GITHUB_ACTIONS": "true"})
            for line in (result.stdout + result.stderr).splitlines():
                self.assertNotIn("##[", line)
                self.assertFalse(line.lstrip().startswith("::"), line)
        self.assertIn("##\\x5B", result.stderr)
        self.assertIn("##[", self.exits(3, "gates.yaml").stdout)

    def test_annotations_are_written_where_github_runs_it(self):
        pair = ("flat.obj", "raised.obj", *self.LIMIT)
        github = {"GITHUB_ACTIONS": "true", "GITHUB_WORKSPACE": str(self.folder)}
        result = self.exits(1, *pair, "--json", environment=github)
        json.loads(result.stdout)
        (line,) = [line for line in result.stderr.splitlines() if line.startswith("::")]
        self.assertTrue(line.startswith("::error file=flat.obj,line=1,title=meshgauge%3A flat.obj::Gate 'flat.obj': the distance"), line)
        self.assertNotIn("::error", self.exits(1, *pair, "--no-annotations", environment=github).stderr)
        for elsewhere in ({}, {"GITHUB_ACTIONS": ""}, {"GITHUB_ACTIONS": "false"}):
            self.assertNotIn("::error", self.exits(1, *pair, environment=elsewhere).stderr)
        self.assertIn("\n::error ", self.exits(1, *pair, "--annotations").stderr)
        self.assertNotIn("::error", self.exits(1, *pair, "--annotations=log").stderr)
        self.assertEqual((self.folder / "log").read_text(), line + "\n")
        self.manifest([("part", "flat.obj", "raised.obj", 1)])
        (self.folder / "sub").mkdir()
        result = self.exits(1, "sub/../gates.yaml", environment=github)
        self.assertIn("\n::error file=gates.yaml,line=3,title=", result.stderr)
        wrong = self.manifest([("part", "none.obj", "raised.obj", "1 parsec")])
        self.assertIn("\n::error file=gates.yaml,line=", self.exits(3, wrong, environment=github).stderr)

    def test_what_changed_since_an_earlier_run(self):
        self.manifest([("part", "flat.obj", "raised.obj", 3)])
        self.exits(0, "gates.yaml", "--json=before.json")
        self.manifest([("part", "flat.obj", "raised.obj", 1)])
        self.exits(1, "gates.yaml", "--since", "before.json", "--markdown", "r.md", "--comment", "c.md")
        for name in ("r.md", "c.md"):
            self.assertRegex((self.folder / name).read_text(), r"\nChanged since `before`:\n\n.*\n.*\n\| `part` \| pass, .* \| fail, .* \|\n")
        self.file("bad.json", "{")
        for name in ("bad.json", "none.json"):
            result = self.exits(1, "gates.yaml", "--since", name, "--comment", "c.md")
            self.assertIn("meshgauge: --since: '%s'" % name, result.stderr)
            self.assertIn("is not known", (self.folder / "c.md").read_text())
        self.fails("gates.yaml", "--since", "before.json", "--json=before.json", saying="is the report of an earlier run")

    def test_two_reports_cannot_share_a_place(self):
        self.fails("flat.obj", "raised.obj", *self.LIMIT, "--json", "--markdown", "-", saying="--markdown")
        self.fails("flat.obj", "raised.obj", *self.LIMIT, "--json=x", "--sarif", "x", saying="--sarif")


class Pictures(Workplace):
    def pictures(self, folder="pictures"):
        return {path.name: path.read_bytes() for path in (self.folder / folder).iterdir()}

    def test_each_gate_that_does_not_pass_has_a_small_png(self):
        self.file("broken.obj", "v 0 0 zero\n")
        self.manifest([("good", "flat.obj", "raised.obj", 3), ("bad", "flat.obj", "raised.obj", 1),
                       ("Odd/<b>name", "flat.obj", "raised.obj", 1), ("broken", "broken.obj", "flat.obj", 1),
                       ("open", "raised.obj", "flat.obj", 3, "expect: {watertight: true}")])
        self.exits(3, "gates.yaml", "--pictures", "pictures", "--jobs", "4", "--threads", "1")
        found = self.pictures()
        self.assertEqual(len(found), 3, sorted(found))
        self.assertLessEqual({"bad.png", "open.png"}, set(found))
        for name, data in found.items():
            self.assertRegex(name, r"\A[a-z0-9._-]+\.png\Z")
            self.assertTrue(data.startswith(b"\x89PNG\r\n"), name)
            self.assertLessEqual(len(data), 200_000)
        self.exits(3, "gates.yaml", "--pictures", "again", "--jobs", "1", "--threads", "1", "--html", "report.html")
        self.assertEqual(self.pictures("again"), found)

    def test_of_two_files(self):
        self.exits(1, "flat.obj", "raised.obj", "--max-distance", "1", "--pictures", "pictures")
        self.assertEqual(list(self.pictures()), ["flat.obj.png"])
        self.exits(0, "flat.obj", "raised.obj", "--max-distance", "3", "--pictures", "pictures")
        self.assertEqual(list(self.pictures()), [])  # that of the run before does not stay

    def test_another_file_in_its_place_is_left_alone(self):
        pair = ("flat.obj", "raised.obj", "--max-distance", "3", "--pictures", "pictures")
        for data in (b"", b"mine", b"\x89PNG\r\n\x1a\n" + bytes(100)):
            self.file("pictures/flat.obj.png", data)
            self.fails(*pair, saying="--pictures: 'pictures/flat.obj.png' is no picture that meshgauge has made")
            self.assertEqual(self.pictures(), {"flat.obj.png": data})

    def test_a_folder_that_cannot_be_written(self):
        pair = ("flat.obj", "raised.obj", "--max-distance", "1")
        self.fails(*pair, "--pictures", "flat.obj", saying="--pictures: 'flat.obj' cannot be created as a folder")
        (self.folder / "pictures/flat.obj.png/full").mkdir(parents=True)
        result = self.exits(3, *pair, "--pictures", "pictures")
        self.assertIn("FAIL", result.stdout)
        self.assertIn("the picture 'pictures/flat.obj.png' cannot be written", result.stderr)


class Deviation(Workplace):
    def test_of_two_files_by_the_suffix_of_the_name(self):
        pair = ("flat.obj", "raised.obj", "--max-distance", "3")
        self.exits(0, *pair, "--deviation", "map.ply")
        self.assertTrue((self.folder / "map.ply").read_bytes().startswith(b"ply\n"))
        self.exits(0, *pair, "--deviation", "map.glb")
        self.assertTrue((self.folder / "map.glb").read_bytes().startswith(b"glTF"))
        self.exits(0, *pair, "--map", "map.vtp")
        self.assertIn(b"<VTKFile", (self.folder / "map.vtp").read_bytes())
        self.fails(*pair, "--deviation", "map.obj", saying="map.obj")
        self.fails(*pair, "--deviation", "none/map.ply", saying="--deviation")

    def test_of_a_manifest_in_a_folder_by_the_gates_names(self):
        self.file("broken.obj", "v 0 0 zero\n")
        self.manifest([("a/b", "flat.obj", "raised.obj", 3), ("a_b", "flat.obj", "raised.obj", 1),
                       ("..", "raised.obj", "flat.obj", 1), ("broken", "broken.obj", "flat.obj", 1)])
        self.exits(3, "gates.yaml", "--deviation", "maps")
        self.assertEqual(sorted(os.listdir(self.folder / "maps")), ["_...ply", "a_b-2.ply", "a_b.ply"])
        self.fails("gates.yaml", "--deviation", "flat.obj", saying="flat.obj")


class UpdateBaselines(Workplace):
    def test_a_dry_run_says_what_the_real_one_does(self):
        self.manifest([("new", "flat.obj", "kept/new.obj", 0.1), ("old", "flat.obj", "raised.obj", 0.1)])
        self.assertIn("new.obj", self.exits(3, "gates.yaml").stdout)
        (self.folder / "kept").mkdir()
        before = (self.folder / "raised.obj").read_bytes()
        said = self.exits(0, "gates.yaml", "--update-baselines", "--dry-run").stdout
        self.assertIn("create kept/new.obj from flat.obj", said)
        self.assertFalse((self.folder / "kept" / "new.obj").exists())
        self.assertEqual((self.folder / "raised.obj").read_bytes(), before)
        self.assertEqual(self.exits(0, "gates.yaml", "--update-baselines").stdout, said)
        self.exits(0, "gates.yaml")

    def test_a_baseline_within_the_limit_is_left(self):
        self.file("near.obj", "v 0 0 0.01\nv 1 0 0.01\nv 0 1 0.01\nf 1 2 3\n")
        self.file("base.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.file("far.obj", "v 0 0 2\nv 1 0 2\nv 0 1 2\nf 1 2 3\n")
        self.file("other.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.manifest([("near", "near.obj", "base.obj", 0.1), ("far", "far.obj", "other.obj", 0.1), ("new", "far.obj", "new.obj", 0.1)])
        said = self.exits(0, "gates.yaml", "--update-baselines=missing", "--dry-run").stdout
        self.assertEqual(said, "create new.obj from far.obj\n")
        said = self.exits(0, "gates.yaml", "--update-baselines").stdout
        self.assertIn("leave base.obj: near.obj is within the limit, 0.00999", said)
        self.assertIn("replace other.obj from far.obj: 1.99999 .. 2.00001 apart, at most 0.1", said)
        self.assertIn("create new.obj from far.obj\n", said)
        self.assertEqual((self.folder / "base.obj").read_text()[:7], "v 0 0 0")
        self.assertIn("replace base.obj from near.obj\n", self.exits(0, "gates.yaml", "--update-baselines=all").stdout)
        self.assertEqual((self.folder / "base.obj").read_text()[:10], "v 0 0 0.01")
        self.fails("gates.yaml", "--update-baselines=some", saying="--update-baselines")

    def test_two_files(self):
        self.exits(0, "flat.obj", "new.obj", "--update-baselines")
        self.assertEqual((self.folder / "new.obj").read_bytes(), (self.folder / "flat.obj").read_bytes())
        self.fails("none.obj", "new.obj", "--update-baselines", saying="none.obj")


if __name__ == "__main__":
    unittest.main()
