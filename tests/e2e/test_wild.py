"""Mesh files as programs write them (wild/ of the corpus): over HTTP and on the command line, each gets the answer that
its row of INDEX.tsv asks for."""

import json
import pathlib
import re
import subprocess
import unittest

from harness import BINARY, OWN_DATA
from packages import zipped
from test_formats import CORPUS, FormatCase, table

WILD = CORPUS / "wild"
OF_THE_SIZE = 1e-6
OF_SIX_DIGITS = 5.1e-6  # each number of the index has so many
# Rows whose box is not that of the surface; docs/formats.md gives the reasons.
OTHER_BOXES = ("30/farm.gltf", "35/manny_med_mod.gltf")
NAMES = ("beam lattice", "glTF 1.0", "4OFF")


def with_its_files(file):
    """What a client sends: the file, or a .zip of a .gltf and the files beside it. Content and name."""
    beside = [other for other in sorted(file.parent.iterdir()) if other != file and other.is_file()]
    if file.suffix != ".gltf" or not beside:
        return file.read_bytes(), file.name
    return zipped({member.name: member.read_bytes() for member in (file, *beside)}), file.name + ".zip"


class Row:
    def __init__(self, columns):
        self.file, self.want, triangles, box, self.why = (columns + [""] * 5)[:5]
        self.path = WILD / self.file
        self.triangles = int(triangles) if triangles else None
        self.box = [float(x) for x in box.split()] if self.file not in OTHER_BOXES else []
        self.refused = re.match(r"refuse (\d+)", self.want)

    def words(self):
        """What the text of a refusal has to hold."""
        if "the line" in self.want:
            return r"line \d+ of '"
        return next(name for name in NAMES if name in self.want)

    def ear(self):
        """The surface with its concave faces split by another program; None when the row does not name one."""
        return next(self.path.parent.glob("*.ear.obj")) if ".ear.obj" in self.want else None


@unittest.skipUnless((WILD / "INDEX.tsv").exists(), "no corpus: set MESHGAUGE_CORPUS")
class Wild(FormatCase):
    def rows(self, wanted):
        rows = [row for row in map(Row, table(WILD / "INDEX.tsv")) if bool(row.refused) == wanted]
        self.assertGreater(len(rows), 5)
        return rows

    def on_the_command_line(self, a, b, *flags):
        return subprocess.run([BINARY, "compare", str(a), str(b), "--json", *flags], capture_output=True, text=True,
                              timeout=120, env=OWN_DATA)

    def over_http(self, a, b, options=b"{}"):
        return self.compare(with_its_files(a), with_its_files(b), options)

    def check_mesh(self, row, mesh):
        if row.triangles is not None:
            self.assertEqual(mesh["triangles"], row.triangles)
        size = max(map(abs, row.box), default=0)
        for told, found in zip(row.box, mesh["bbox"]["low"] + mesh["bbox"]["high"]):
            self.assertAlmostEqual(found, told, delta=max(OF_THE_SIZE * size, OF_SIX_DIGITS * abs(told)))
        if "helper volumes" in row.want:
            self.assertGreater(mesh["helper_objects"], 0)
            self.assertTrue([note for note in mesh["notes"] if "not printed" in note], mesh["notes"])
        if "concave faces counted" in row.want:
            self.assertGreater(mesh["polygons"]["concave"], 0)

    def check_result(self, row, result):
        self.assertEqual(result["distance"]["upper"] if result["distance"]["lower"] else 0, 0)
        self.assertLessEqual(result["distance"]["upper"], 1e-3 * result["meshes"]["a"]["diagonal"])
        for part in "ab":
            self.check_mesh(row, result["meshes"][part])

    def check_ear(self, result):
        self.assertLessEqual(result["distance"]["upper"], 1e-6 * result["meshes"]["a"]["diagonal"])

    def test_what_is_accepted_on_the_command_line(self):
        for row in self.rows(wanted=False):
            with self.subTest(row.file, why=row.why):
                done = self.on_the_command_line(row.path, row.path)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.check_result(row, json.loads(done.stdout))
                if row.ear():
                    done = self.on_the_command_line(row.path, row.ear(), "--diagonal", "5e-7")
                    self.check_ear(json.loads(done.stdout))

    def test_what_is_accepted_over_http(self):
        for row in self.rows(wanted=False):
            with self.subTest(row.file, why=row.why):
                answer = self.over_http(row.path, row.path)
                self.assertEqual(answer.status, 200, answer.body[:300])
                self.check_result(row, answer.json())
                if row.ear():
                    self.check_ear(self.over_http(row.path, row.ear(), b'{"tolerance": {"diagonal": 5e-7}}').json())

    def test_what_is_refused_on_the_command_line(self):
        for row in self.rows(wanted=True):
            with self.subTest(row.file, why=row.why):
                done = self.on_the_command_line(row.path, row.path)
                self.assertEqual((done.returncode, done.stdout), (3, ""))
                self.assertRegex(done.stderr, row.words())
                self.assertIn(str(row.path), done.stderr)

    def test_what_is_refused_over_http(self):
        for row in self.rows(wanted=True):
            with self.subTest(row.file, why=row.why):
                answer = self.over_http(row.path, row.path)
                self.assertEqual(answer.status, int(row.refused[1]), answer.body[:300])
                problem = answer.json()
                self.assertRegex(problem["detail"], row.words())
                self.assertEqual([error["part"] for error in problem["errors"]], ["a"])
                self.assertIn("'a'", problem["detail"])


if __name__ == "__main__":
    unittest.main()
