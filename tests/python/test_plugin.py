"""The plugin for pytest, in runs of pytest of its own."""

import importlib.util
import json
import os
import pathlib
import re
import struct
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


# In each of two tests, one mesh or two for one baseline.
SHARED = HEAD + """
import pytest
@pytest.mark.parametrize("size", [%s])
def test_part(assert_mesh_close, size):
    assert_mesh_close(shapes.box(size), "baselines/part.ply", max_distance="0.05 mm")
"""
# As xdist makes a worker of a process.
WORKER = """
def pytest_configure(config):
    config.workerinput, config.workeroutput = {}, {}
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
        reports = [path.name for path in (self.folder / "reports").glob("*.html")]
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
        picture = pathlib.Path(urllib.parse.unquote(re.search(r"picture: file://(\S+)", output)[1]))
        self.assertEqual(picture, report.with_suffix(".png"))
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG\r\n"))
        self.assertEqual([path.name for path in report.parent.iterdir() if path.name.startswith(".")], [])
        return report

    def files(self, folder="baselines"):
        top = self.folder / folder
        return sorted(path.relative_to(top).as_posix() for path in top.rglob("*") if path.is_file())

    def test_a_baseline_has_its_place_by_the_tests_name(self):
        source = HEAD + """
import pytest
LIMIT = {"max_distance": "0.05 mm"}
def test_part(assert_mesh_close):
    assert_mesh_close(shapes.box(%s), **LIMIT)
    assert_mesh_close(shapes.box(3), shapes.box(3), **LIMIT)
    assert_mesh_close(shapes.box(4), **LIMIT)
@pytest.mark.parametrize("what", ["10", "a/b", "a b", "x::yz", "x.yz"])
def test_each(assert_mesh_close, what):
    assert_mesh_close(shapes.box(len(what)), **LIMIT)
class TestLid:
    def test_part(self, assert_mesh_close, tmp_path):
        (tmp_path / "made.obj").write_bytes(shapes.obj(shapes.box(5)))
        assert_mesh_close(tmp_path / "made.obj", **LIMIT)
"""
        code, output = self.run_pytest(source % 10)
        self.assertEqual(code, 1, output)
        self.assertIn("baselines/test_it/test_part.ply does not exist; pytest --meshgauge-update writes it", output)
        code, output = self.run_pytest(source % 10, "--meshgauge-update")
        self.assertEqual(code, 0, output)
        written = self.files()
        self.assertEqual(len(written), 8, written)
        for name in ("TestLid.test_part.obj", "test_each-10.ply", "test_part+2.ply", "test_part.ply"):
            self.assertIn(f"test_it/{name}", written)
        odd = [name for name in written if re.fullmatch(r"test_it/test_each-a-b-[0-9a-f]{8}\.ply", name)]
        self.assertEqual(len(odd), 2, written)
        self.assertEqual(self.run_pytest(source % 10.01)[0], 0)
        self.assertEqual(self.run_pytest(source % 10.1)[0], 1)
        self.assertEqual(self.files(), written)

    def test_a_baseline_that_is_there_may_have_another_suffix(self):
        folder = self.folder / "baselines/test_it"
        folder.mkdir(parents=True)
        (folder / "test_part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        source = HEAD + """
import numpy
def test_part(assert_mesh_close):
    corners = numpy.array([[0.0, 0, 0], [%s, 0, 0], [0, 1, 0]])
    assert_mesh_close((corners, numpy.array([[0, 1, 2]])), max_distance=0.1)
"""
        self.assertEqual(self.run_pytest(source % 1)[0], 0)
        code, output = self.run_pytest(source % 2, "--meshgauge-update")
        self.assertEqual((code, "remove it, so that *.ply takes its place" in output), (1, True), output)
        (folder / "test_part.stl").write_text("solid s\nendsolid s\n")
        code, output = self.run_pytest(source % 1)
        self.assertEqual((code, "there are 2 baselines of this test" in output), (1, True), output)

    def test_a_baseline_of_two_tests_is_written_for_one(self):
        code, output = self.run_pytest(SHARED % "10, 10.01", "--meshgauge-update")
        self.assertEqual((code, output.count("meshgauge: wrote")), (0, 1), output)
        code, output = self.run_pytest(SHARED % "11, 12", "--meshgauge-update")
        self.assertEqual(code, 1, output)
        self.assertRegex(output, r"part\.ply is that of test_it\.py::test_part\[11\] as well, of another mesh: give each its own")
        self.assertEqual(self.run_pytest(SHARED % "11")[0], 0)
        twice = HEAD + """
def test_twice(assert_mesh_close):
    for size in (10, 20):
        assert_mesh_close(shapes.box(size), "baselines/twice.ply", max_distance=0.1)
"""
        self.assertIn("that of test_it.py::test_twice as well", self.run_pytest(twice, "--meshgauge-update")[1])

    def test_workers_know_what_the_others_have_written(self):
        (self.folder / "conftest.py").write_text(WORKER)
        (self.folder / "base").mkdir()

        def run_worker(name, size):
            return self.run_pytest(SHARED % size, "--meshgauge-update", f"--basetemp=base/{name}")

        self.assertEqual(run_worker("gw0", 10)[0], 0)
        self.assertEqual(run_worker("gw1", 10.01)[0], 0)
        code, output = run_worker("gw2", 11)
        self.assertEqual((code, "that of test_it.py::test_part[10] as well" in output), (1, True), output)
        self.assertEqual(self.files(), ["part.ply"])

    @unittest.skipUnless(importlib.util.find_spec("xdist"), "needs pytest-xdist")
    def test_with_xdist(self):
        source = HEAD + """
import pytest
@pytest.mark.parametrize("size", range(1, 9))
def test_own(assert_mesh_close, size):
    assert_mesh_close(shapes.box(size), max_distance="0.05 mm")
    assert_mesh_close(shapes.box(3), "baselines/shared.ply", max_distance="0.05 mm")
"""
        workers = ("-n", "2")
        code, output = self.run_pytest(source, "--meshgauge-update", *workers)
        self.assertEqual((code, output.count("meshgauge: wrote")), (0, 9), output)
        self.assertEqual(self.files(), ["shared.ply", *(f"test_it/test_own-{size}.ply" for size in range(1, 9))])
        self.assertEqual(self.run_pytest(source, *workers)[0], 0)
        other = source.replace("box(3)", "box(3 + size % 2)")
        code, output = self.run_pytest(other, "--dist=each", "--tx", "2*popen")  # each test by both workers
        self.assertEqual(code, 1, output)
        reports = set(re.findall(r"report: file://(\S+)", output))
        self.assertEqual(len(reports), 4, output)
        for report in reports:
            self.assertIn("</html>", pathlib.Path(urllib.parse.unquote(report)).read_text())

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

    def test_nothing_is_written_unless_all_else_is_right(self):
        (self.folder / "scene.gltf").write_text(json.dumps({"asset": {"version": "2.0"}, "buffers": [
            {"uri": "points.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
            "scene": 0}))
        (self.folder / "points.bin").write_bytes(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0))
        for call, words in (("shapes.box(3)", "needs a limit"),
                            ("(shapes.box(3)[0], None), max_distance=1", "Error|no faces"),
                            ("shapes.box(3), max_distance=1, nonsense=2", "nonsense"),
                            ("shapes.box(3), max_distance=-1", "max_distance"),
                            ("HERE / 'scene.gltf', max_distance=1", "a glTF of several files; give a .glb")):
            source = HEAD + f"""
import pathlib
HERE = pathlib.Path(__file__).parent
def test_one(assert_mesh_close):
    assert_mesh_close({call})
"""
            code, output = self.run_pytest(source, "--meshgauge-update")
            self.assertEqual(code, 1, output)
            self.assertRegex(output, words)
            self.assertFalse((self.folder / "baselines").exists(), call)

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
