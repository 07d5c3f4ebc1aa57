"""`meshgauge check` before there is a manifest: it explains one, and `--init` writes one."""

import os

from workplace import Workplace, square


class Explained(Workplace):
    def explains(self, *arguments, saying, gate, init):
        """Four lines: what is wrong, a manifest of two lines, what writes one."""
        lines = self.exits(3, *arguments).stderr.splitlines()
        self.assertEqual(len(lines), 4, lines)
        self.assertEqual(lines[0], "meshgauge: check takes two mesh files, CANDIDATE BASELINE, or one manifest of gates%s. Several meshes "
                                   "stand in a manifest, gates.yaml:" % saying)
        self.assertEqual(lines[1:3], ["  version: 1", "  gates: [{%s, max_distance: 0.05 mm}]" % gate])
        self.assertEqual(lines[3], "meshgauge check --init%s writes one for the meshes that are there; meshgauge check gates.yaml runs it."
                         % init)

    def test_no_file_and_no_manifest(self):
        self.explains(saying="; none is named, and there is no gates.yaml here",
                      gate='name: "{stem}", candidate: "parts/*.stl", baseline: "baselines/{name}"', init="")

    def test_the_manifest_of_the_folder_is_taken(self):
        self.manifest([("x", "flat.obj", "raised.obj", 3)])
        self.assertEqual(self.report(0)["gates"][0]["manifest"], {"file": "gates.yaml", "line": 3})

    def test_more_than_two_files(self):
        for name in ("parts/a.obj", "parts/b.OBJ", "parts/c.obj"):
            self.file(name, square())
        self.explains("parts/a.obj", "parts/b.OBJ", "parts/c.obj", "--max-distance", "1", saying="; 3 files are named",
                      gate='name: "{stem}", candidate: "parts/*.[oO][bB][jJ]", baseline: "baselines/{name}"', init=" 'parts'")

    def test_folders(self):
        for name in ("parts/a.obj", "baselines/a.obj"):
            self.file(name, square())
        self.explains("parts/", "baselines", saying=", not two folders",
                      gate='name: "{stem}", candidate: "parts/*.obj", baseline: "baselines/{name}"', init="")
        self.explains("parts", saying=", not the folder 'parts'",
                      gate='name: "{stem}", candidate: "parts/*.obj", baseline: "baselines/{name}"', init=" 'parts'")

    def test_a_report_has_the_mistake(self):
        self.exits(3, "flat.obj", "raised.obj", "flat.obj", "--json=report.json")
        self.assertIn("3 files are named", (self.folder / "report.json").read_text())

    def test_control_characters_are_escaped(self):
        self.file("a\x1b[31m/x.obj", square())
        self.assertNotIn("\x1b", self.exits(3, "a\x1b[31m").stderr)


class Init(Workplace):
    def setUp(self):
        super().setUp()
        os.remove(self.folder / "flat.obj")
        os.remove(self.folder / "raised.obj")

    def test_a_pair_of_folders_passes_at_once(self):
        for name in ("a.obj", "B.OBJ", "with blank.obj"):
            self.file("parts/" + name, square())
            self.file("baselines/" + name, square())
        result = self.exits(0, "--init")
        self.assertIn("wrote gates.yaml\n", result.stdout)
        self.assertEqual(result.stderr, "")
        self.assertEqual(self.report(0)["counts"]["pass"], 3)

    def test_baselines_are_made_next(self):
        self.file("meshes/a.obj", square())
        self.file("meshes/b.STL", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n")
        result = self.exits(0, "--init", "meshes", "--max-distance", "0.2 mm")
        self.assertIn("to do: ", result.stderr)
        self.assertIn("max_distance: 0.2 mm", (self.folder / "meshes/gates.yaml").read_text())
        self.exits(0, "meshes/gates.yaml", "--update-baselines")
        self.assertEqual(self.report(0, "meshes/gates.yaml")["counts"]["pass"], 2)

    def test_refused(self):
        def refused(*arguments, saying):
            self.fails("--init", *arguments, saying="meshgauge: --init: " + saying)
        refused(saying="no mesh file is in '.' or in the folders directly in it: name the folder that holds them")
        refused("gone", saying="'gone' is no folder: name the one that holds the meshes")
        refused("a", "b", saying="takes one folder; 2 are named")
        self.file("a.obj", square())
        refused("--json", saying="writes a manifest and measures nothing: leave out --json")
        refused("--max-distance", "wide", saying="--max-distance: ")
        os.symlink("gone.yaml", self.folder / "gates.yaml")
        refused(saying="'gates.yaml' exists and is left as it is: run it, or remove it first")
        self.assertFalse((self.folder / "gone.yaml").exists())
