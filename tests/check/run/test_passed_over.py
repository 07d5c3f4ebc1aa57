"""`meshgauge check` on names that people and other systems take for the same: nothing is passed over without a word."""

import os
import shutil

from workplace import Workplace, square

# 40 names; what a glob '*.obj' of the folder 'parts' makes of each.
TAKEN = ["plain.obj", "BRACKET.obj", "Bracket.obj", "bracket.obj", "with blank.obj", " leading.obj", "inner  blanks.obj", "trailing .obj",
         "back\\slash.obj", "a.b.obj", "x.OBJ.obj", "\u00e4.obj", "\u00c4.obj", "(1).obj", "[1].obj", "{stem}.obj", "quote'.obj"]
BY_CASE = ["CAP.OBJ", "cap.Obj", "lid.oBj", "LID.obJ", "Pin.OBj", "pin.ObJ", "Plate.oBJ", "\u00d6l.OBJ", "two words.OBJ", "back\\case.OBJ",
           "two\nlines.OBJ"]
BY_BLANKS = ["after.obj ", "carriage.obj\r", "AFTER.OBJ ", "tab.obj\t", "no-break.obj\u00a0", "behind the dot. obj"]
HIDDEN = [".hidden.obj", "._BRACKET.obj", "._CAP.OBJ", ".Hidden.Obj"]
ARCHIVED = ["parts\\flat.obj", "PARTS\\upper.OBJ"]  # beside the folder
MANIFEST = """version: 1
defaults: {max_distance: 0.1, unmatched_baselines: ignore}
gates:
  - {name: "%s", candidate: "parts/*.obj", baseline: "base/{name}"}
"""


def shown(name):
    return name.replace("\n", "?").replace("\t", "?").replace("\r", "?")


class PassedOver(Workplace):
    def measured(self, *arguments):
        report = self.report(0, "gates.yaml", *arguments)
        return report, sorted(gate["candidate"] for gate in report["gates"])

    def test_each_of_forty_files_is_measured_or_named(self):
        names = TAKEN + BY_CASE + BY_BLANKS + HIDDEN
        self.assertEqual(len(names) + len(ARCHIVED), 40)
        for name in names:
            self.file("parts/" + name, square())
            self.file("base/" + name, square())
        for name in ARCHIVED:
            self.file(name, square())
        self.file("gates.yaml", MANIFEST % "{name}")
        said = self.exits(3, "gates.yaml").stderr
        for name in BY_CASE + BY_BLANKS:
            self.assertIn("'parts/%s'" % shown(name), said)
        for name in ARCHIVED:
            self.assertIn("'%s'" % name, said)
        self.assertIn("parts/*.[oO][bB][jJ]", said)
        for name in TAKEN:
            self.assertNotIn("'parts/%s'" % shown(name), said)
        for name in BY_CASE + BY_BLANKS:
            os.remove(self.folder / "parts" / name)
        for name in ARCHIVED:
            os.remove(self.folder / name)
        report, measured = self.measured()
        self.assertEqual(measured, sorted("parts/" + name for name in TAKEN))
        notes = "\n".join(note for gate in report["gates"] for note in gate["notes"])
        for name in HIDDEN:
            self.assertIn("'parts/%s'" % name, notes)

    def test_the_hidden_are_named_by_every_report(self):
        self.file("parts/a.obj", square())
        self.file("parts/.b.obj", square())
        self.file("base/a.obj", square())
        self.file("gates.yaml", MANIFEST % "{stem}")
        reports = {flag: self.folder / ("report" + flag) for flag in ("junit", "sarif", "markdown", "html", "code-quality", "json")}
        for quiet in ([], ["--quiet"]):
            result = self.exits(0, "gates.yaml", *quiet, *("--%s=%s" % item for item in reports.items()))
            self.assertIn("note: 'parts/*.obj' passes over 'parts/.b.obj': a wildcard matches no leading dot", result.stdout)
        for flag, path in reports.items():
            self.assertRegex(path.read_text(), r"parts/(?:&#46;|\.)b(?:&#46;|\.)obj", flag)
        self.file("gates.yaml", MANIFEST % "{stem}" + "  - {name: dot, candidate: parts/.b.obj, baseline: base/a.obj}\n")
        self.assertNotIn("note:", self.exits(0, "gates.yaml").stdout)

    def test_a_pattern_of_both_cases_takes_both(self):
        for name in ("a.obj", "B.OBJ"):
            self.file("parts/" + name, square())
            self.file("base/" + name, square())
        self.file("gates.yaml", MANIFEST % "{stem}")
        self.fails("gates.yaml", saying="gate '{stem}': the candidate 'parts/*.obj' passes over 'parts/B.OBJ', which it misses only by upper "
                                        "and lower case: write 'parts/*.[oO][bB][jJ]' to take both, or rename it")
        self.file("gates.yaml", MANIFEST.replace("*.obj", "*.[oO][bB][jJ]") % "{stem}")
        self.assertEqual(self.measured()[1], ["parts/B.OBJ", "parts/a.obj"])

    def test_a_folder_of_many_files_gets_a_short_message(self):
        (self.folder / "parts").mkdir()
        for i in range(20000):
            (self.folder / "parts" / ("P%05d.OBJ" % i)).touch()
        self.file("parts/a.obj", square())
        self.file("base/a.obj", square())
        self.file("gates.yaml", MANIFEST % "{stem}")
        said = self.exits(3, "gates.yaml").stderr
        self.assertRegex(said, r" and \d+ more, which it misses only by upper and lower case")
        self.assertLess(len(said), 10000)
        shutil.rmtree(self.folder / "parts")
