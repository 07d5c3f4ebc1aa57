"""The plugin for pytest, in runs of pytest of its own."""

import os
import pathlib
import re
import sys
import tempfile
import traceback
import unittest
import urllib.parse

try:
    import numpy  # noqa: F401  once, for all runs
    import pytest
except ImportError as missing:
    raise unittest.SkipTest(str(missing)) from None

TESTS = pathlib.Path(__file__).parent
HEAD = f"import sys; sys.path.insert(0, {str(TESTS)!r})\nimport shapes\n"
CLOSE = HEAD + """
def test_part(assert_mesh_close):
    assert_mesh_close(shapes.box(%s), "baselines/part.ply", max_distance="0.05 mm")
"""


class Plugin(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_pytest(self, source, *flags):
        """Exit code and output of pytest, in a process of its own that need not import it."""
        (self.folder / "test_it.py").write_text(source)
        with tempfile.TemporaryFile("w+") as output:
            sys.stdout.flush()
            sys.stderr.flush()
            child = os.fork()
            if child == 0:
                self.become_pytest(output, ["-p", "meshgauge.pytest_plugin", "-q", *flags, "test_it.py"])
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            output.seek(0)
            return code, output.read()

    def become_pytest(self, output, arguments):
        code = 70
        try:
            os.chdir(self.folder)
            for stream in (1, 2):
                os.dup2(output.fileno(), stream)
            code = int(pytest.main(arguments))
            sys.stdout.flush()
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)

    def test_baselines_are_written_when_asked(self):
        baseline = self.folder / "baselines/part.ply"
        code, output = self.run_pytest(CLOSE % 10)
        self.assertEqual(code, 1)
        self.assertIn("does not exist; pytest --meshgauge-update writes it", output)
        self.assertFalse(baseline.exists())
        code, output = self.run_pytest(CLOSE % 10, "--meshgauge-update")
        self.assertEqual((code, f"meshgauge: wrote {baseline}" in output), (0, True), output)
        written = baseline.read_bytes()
        self.assertEqual(self.run_pytest(CLOSE % 10.01)[0], 0)
        self.assertNotIn("wrote", self.run_pytest(CLOSE % 10.01, "--meshgauge-update")[1])  # within the limit
        self.assertEqual(baseline.read_bytes(), written)
        self.assertEqual(self.run_pytest(CLOSE % 10.1)[0], 1)
        self.assertIn("wrote", self.run_pytest(CLOSE % 10.1, "--meshgauge-update")[1])
        self.assertEqual(self.run_pytest(CLOSE % 10.1)[0], 0)
        self.assertEqual([path.name for path in baseline.parent.iterdir()], ["part.ply"])

    def test_a_report_whatever_the_test_is_called(self):
        """Ids that are no names of files, in bytes or characters, or that look alike when they are made names."""
        source = HEAD + """
import pytest

@pytest.mark.parametrize("name", ["x" * 300, "x" * 299 + "y", "\\u00e9" * 200, "a b", "a?b"])
def test_part(assert_mesh_close, name):
    assert_mesh_close(shapes.box(10.5), shapes.box(10), max_distance="0.05 mm")
"""
        (self.folder / "pytest.ini").write_text(
            "[pytest]\ndisable_test_id_escaping_and_forfeit_all_rights_to_community_support = True\n")
        code, output = self.run_pytest(source, "--meshgauge-reports", str(self.folder / "reports"))
        self.assertEqual((code, output.count("fail: the distance is at least")), (1, 5), output)
        reports = [path.name for path in (self.folder / "reports").iterdir()]
        self.assertEqual(len(reports), 5, reports)
        self.assertLess(max(len(os.fsencode(name)) for name in reports), 143)

    def test_a_folder_of_reports_that_is_none(self):
        (self.folder / "file").write_text("")
        code, output = self.run_pytest(CLOSE.replace('"baselines/part.ply"', "shapes.box(10)") % 10.5, "--meshgauge-reports",
                                       str(self.folder / "file"))
        self.assertEqual(code, 1)
        self.assertRegex(output, r"fail: the distance is at least 0\.\d+ mm")
        self.assertIn("report: none: ", output)

    def test_a_failure_says_where_and_has_a_report(self):
        self.run_pytest(CLOSE % 10, "--meshgauge-update")
        code, output = self.run_pytest(CLOSE % 10.5)
        self.assertEqual(code, 1)
        self.assertRegex(output, r"fail: the distance is at least 0\.\d+ mm, above the limit of 0.05 mm")
        self.assertRegex(output, r"look at \(10.5, 10.5, 10.5\) mm on triangle \d+ of actual: the nearest point of expected is \(10, 10, 10\)")
        self.assert_report(output, "0.05 mm")

    def assert_report(self, output, limit):
        report = pathlib.Path(urllib.parse.unquote(re.search(r"report: file://(\S+)", output)[1]))
        page = report.read_text()
        self.assertIn("data:image/png;base64", page)
        self.assertIn(limit, page)
        return report

    def test_a_report_has_all_limits(self):
        source = HEAD + """
def test_area(assert_mesh_close):
    assert_mesh_close(shapes.box(10), shapes.box(10.5), "5 mm", units=("mm", "mm"), uncertainty="0.001 mm",
                      max_share_beyond={"distance": "0.01 mm", "share": 0.001})
"""
        code, output = self.run_pytest(source)
        self.assertEqual(code, 1, output)
        page = self.assert_report(output, "0.1 % beyond 0.01 mm").read_text()
        self.assertIn("The gate fails", page)
        self.assertIn("0.001 mm", page)

    def test_a_limit_of_the_area_alone(self):
        source = HEAD + """
import pytest
def test_area(assert_mesh_close):
    with pytest.raises(TypeError, match="needs a limit"):
        assert_mesh_close(shapes.box(10), shapes.box(10))
    assert_mesh_close(shapes.box(10), shapes.box(10), max_share_beyond={"distance": 0.01, "share": 0.001})
    assert_mesh_close(shapes.box(10), shapes.box(10.5), max_share_beyond={"distance": 0.01, "share": 0.001})
"""
        code, output = self.run_pytest(source)
        self.assertEqual(code, 1, output)
        self.assertRegex(output, r"fail: between [\d.]+ and [\d.]+ % of the area is farther than 0.01; at most 0.1 % may be")

    def test_a_folder_for_reports_and_options(self):
        source = HEAD + """
def test_units(assert_mesh_close):
    inch = shapes.box(1)
    assert_mesh_close(inch, shapes.box(25.4), "0.01 mm", units=("in", "mm"))
    assert_mesh_close(inch, shapes.box(26), "0.01 mm", units=("in", "mm"), direction="b_to_a", timeout=20)
"""
        code, output = self.run_pytest(source, "--meshgauge-reports=reports", "-p", "no:cacheprovider")
        self.assertEqual(code, 1, output)
        self.assertEqual(self.assert_report(output, "0.01 mm").parent, (self.folder / "reports").resolve())

    def test_files_stay_what_they_are(self):
        source = HEAD + """
import pathlib
def test_file(assert_mesh_close, tmp_path):
    path = tmp_path / "made.obj"
    path.write_bytes(shapes.obj(shapes.box(3)))
    result = assert_mesh_close(path, "baselines/made.obj", 0.1)
    assert result.verdict == "pass"
    assert (pathlib.Path(__file__).parent / "baselines/made.obj").read_bytes() == path.read_bytes()
"""
        self.assertEqual(self.run_pytest(source, "--meshgauge-update")[0], 0)
        code, output = self.run_pytest(source.replace("baselines/made.obj", "baselines/made.stl"), "--meshgauge-update")
        self.assertEqual(code, 1)
        self.assertIn("name it *.obj", output)
        self.assertEqual(list((self.folder / "baselines").iterdir()), [self.folder / "baselines/made.obj"])

    def test_a_mesh_without_faces_is_a_cloud_only_if_it_is_declared(self):
        source = HEAD + """
def test_cloud(assert_mesh_close):
    points = shapes.box(3)[0]
    assert_mesh_close((points, None), shapes.box(3), 0.1, direction="a_to_b"%s)
"""
        code, output = self.run_pytest(source % "")
        self.assertEqual(code, 1, output)
        self.assertRegex(output, r"actual has \d+ points and no faces; if it is a point cloud, declare it by cloud=True")
        self.assertEqual(self.run_pytest(source % ", cloud=True")[0], 0)
        code, output = self.run_pytest(source.replace("points =", "points = 2 *") % ", cloud=True")
        self.assertEqual(code, 1, output)
        self.assertIn("report: file://", output)

    def test_objects_of_other_libraries(self):
        source = HEAD + """
import objects
def test_scene(assert_mesh_close):
    boxes = objects.Scene({"box": objects.Trimesh(*shapes.box(3), "mm")}, [("box", [0, 0, 0]), ("box", [%s, 0, 0])])
    assert_mesh_close(boxes, "baselines/boxes.ply", "0.1 mm", units="mm")
"""
        code, output = self.run_pytest(source % 9, "--meshgauge-update")
        self.assertEqual((code, "baselines/boxes.ply" in output), (0, True), output)
        self.assertEqual(self.run_pytest(source % 9.05)[0], 0)
        code, output = self.run_pytest(source % 9.5)
        self.assertEqual(code, 1, output)
        self.assertIn("note: a: meshes of a scene, at their places, measured as one: 2", output)
        self.assert_report(output, "0.1 mm")

    def test_a_mesh_that_is_none_is_an_error_not_a_difference(self):
        code, output = self.run_pytest(HEAD + """
def test_broken(assert_mesh_close):
    vertices, faces = shapes.box(3)
    assert_mesh_close((vertices * float("nan"), faces), shapes.box(3), 1)
""")
        self.assertEqual(code, 1)
        self.assertIn("InputError: vertex 0 of 'a' is NaN", output)


if __name__ == "__main__":
    unittest.main()
