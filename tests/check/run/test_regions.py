"""Regions of a gate, by flags and in a manifest, in every report."""

import unittest

from workplace import Workplace


class Regions(Workplace):
    def test_a_line_for_each(self):  # both squares are 2 apart
        left, right = "box: {min: [-9, -9, -9], max: [0.5, 9, 9]}", "sphere: {centre: [1, 0.5, 1], radius: 1.2}"
        pair = ("flat.obj", "raised.obj", "--max-distance", "3 mm", "--regions")
        self.exits(0, *pair, "[{name: left, %s, max_distance: 2.1 mm}, {name: right, %s}]" % (left, right))
        self.exits(1, *pair, "[{name: left, %s, max_distance: 1.9 mm}]" % left)
        self.exits(3, *pair, "[{name: left, %s, max_distance: 1.9 in}]" % left)
        self.exits(3, *pair, "[{name: left}]")
        self.exits(3, *pair, "[{name: far, box: {min: [50, 50, 50], max: [60, 60, 60]}}]")
        self.file("regions.yaml", """
version: 1
gates:
  - name: pair
    candidate: flat.obj
    baseline: raised.obj
    max_distance: 1 mm
    regions:
      - {name: left, %s, max_distance: 2.5 mm}
      - {name: right, %s, max_distance: 1.5 mm}
""" % (left, right))
        gate = self.report(1, "regions.yaml")["gates"][0]
        regions = gate["criteria"][1:]
        self.assertEqual([(one["region"], one["verdict"], one["limit"]) for one in regions],
                         [("left", "pass", 2.5), ("right", "fail", 1.5)])
        for one in (*regions, gate["distance"]):  # `distance` is that of the rest
            self.assertLessEqual(one["lower"], 2)
            self.assertGreaterEqual(one["upper"], 2)
        run = self.exits(1, "regions.yaml", "--junit", "regions.xml", "--markdown", "regions.md", "--html", "regions.html")
        self.assertRegex(run.stdout, r"(?m)^FAIL  pair  (rest|right): ")
        self.assertRegex(run.stdout, r"(?m)^    pass       distance in left: \S+ \.\. \S+ mm, at most 2\.5 mm$")
        self.assertRegex(run.stdout, r"(?m)^    fail       distance in right: .*, at most 1\.5 mm$")
        self.assertIn('<property name="region.left.verdict" value="pass" />', (self.folder / "regions.xml").read_text())
        self.assertIn("`pair`: distance in right", (self.folder / "regions.md").read_text())
        self.assertIn("distance in right", (self.folder / "regions.html").read_text())

    def test_groups_of_the_baseline(self):
        self.file("named.obj", "v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 2\ng left\nf 1 2 3\no Bohrung \u00e4\nf 1 3 4\n")
        pair = ("flat.obj", "named.obj", "--max-distance", "3 mm", "--regions")
        self.exits(0, *pair, "[{name: left, group: left, max_distance: 2.1 mm}, {name: bore, group: Bohrung \u00e4}]")
        self.exits(1, *pair, "[{name: left, group: left, max_distance: 1.9 mm}]")
        self.exits(3, *pair, "[{name: left, group: left, box: {min: [0, 0, 0], max: [1, 1, 1]}}]")
        run = self.exits(3, *pair, "[{name: left, group: right}]")
        self.assertIn("no group 'right': 'named.obj' has 'Bohrung \u00e4', 'left'", run.stdout + run.stderr)
        run = self.exits(3, *pair, "[{name: left, group: left}]", "--direction", "candidate_to_baseline")
        self.assertIn("the direction must be symmetric or baseline_to_candidate", run.stdout + run.stderr)
        self.file("groups.yaml", """
version: 1
gates:
  - name: pair
    candidate: flat.obj
    baseline: named.obj
    max_distance: 3 mm
    regions: [{name: left, group: left, max_distance: 1.5 mm}]
""")
        self.assertEqual(self.report(1, "groups.yaml")["gates"][0]["criteria"][1]["verdict"], "fail")


if __name__ == "__main__":
    unittest.main()
