"""Mesh files over HTTP: their notes in the result, and every file of the corpus."""

import contextlib
import glob
import json
import os
import pathlib
import re
import time
import unittest

from harness import ROOT, SQUARE, ServerCase, post_head
from maps import Glb
from packages import package_3mf
from test_batches import accepted, ended, results, submit

CORPUS = pathlib.Path(os.environ.get("MESHGAUGE_CORPUS", ROOT.parent / "shared" / "corpus"))
SANITIZED = os.environ.get("MESHGAUGE_SANITIZED") == "1"
MOST_KB = 64 * 1024


def square_3mf(unit):
    return package_3mf(unit, ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)), ((0, 1, 2), (0, 2, 3)))


class FormatCase(ServerCase):
    def compare(self, a, b, options=b"{}", files=()):
        """Each file is (content, file name[, media type]); `files` are the files beside `a`."""
        body = b""
        for part, (content, name, *media_type) in (("a", a), ("b", b), *(("a.files", file) for file in files)):
            kind = b"Content-Type: %s\r\n" % media_type[0].encode() if media_type else b""
            body += (b'--XXboundaryXX\r\nContent-Disposition: form-data; name="%s"; filename="%s"\r\n%s\r\n%s\r\n'
                     % (part.encode(), name.encode(), kind, content))
        body += b'--XXboundaryXX\r\nContent-Disposition: form-data; name="options"\r\n\r\n%s\r\n--XXboundaryXX--\r\n' % options
        return self.server.raw(post_head(len(body)) + body)


class Notes(FormatCase):
    def test_a_name_or_a_media_type_that_contradicts_the_content(self):
        result = self.compare((SQUARE, "a.stl", "model/obj"), (SQUARE, "b", "model/gltf-binary")).json()
        a, b = result["meshes"]["a"], result["meshes"]["b"]
        self.assertEqual((a["format"], a["format_mismatch"]), ("obj", {"file_name": "stl", "media_type": None}))
        self.assertEqual((b["format"], b["format_mismatch"]), ("obj", {"file_name": None, "media_type": "glb"}))
        self.assertEqual(a["notes"], ["the file name says stl, but the content is obj; it was read as that"])
        result = self.compare((SQUARE, "a.obj", "model/obj"), (SQUARE, "b.obj", "application/octet-stream")).json()
        self.assertEqual([result["meshes"][part]["format_mismatch"] for part in "ab"], [None, None])

    def test_a_3mf_keeps_its_own_numbers(self):
        inches = self.compare((square_3mf("inch"), "a.3mf"), (SQUARE, "b.obj")).json()
        self.assertEqual(inches["meshes"]["a"]["unit"], {"name": "in", "source": "file"})
        self.assertEqual(inches["meshes"]["a"]["bbox"]["high"], [1, 1, 0])
        self.assertEqual(inches["meshes"]["b"]["unit"], {"name": None, "source": "unknown"})
        self.assertEqual(inches["unit"], {"name": None, "source": "unknown"})
        self.assertEqual(inches["distance"]["lower"], 0)
        self.assertLessEqual(inches["distance"]["upper"], 1e-5)

    def test_polygons_points_and_degenerate_triangles(self):
        mesh = SQUARE + b"f 1 2 3 4\np 1\nl 1 2\nf 1 2\nf 1 1 2\n"
        a = self.compare((mesh, "a.obj"), (SQUARE, "b.obj")).json()["meshes"]["a"]
        self.assertEqual((a["polygons"]["count"], a["skipped_primitives"], a["degenerate"], a["welded_vertices"]), (1, 3, 1, 0))
        self.assertEqual(len(a["notes"]), 3)


CLOUD = b"# scan\n0.5 0.5 0.25 0 0 1\n0 0 0.5\n1 1 0\n"


class Clouds(FormatCase):
    """A point cloud over HTTP: by a form, stored, in a batch, with a map, and refused where it is measured to."""

    def test_measured_from_it(self):
        for content, name in ((CLOUD, "a.xyz"), (b"v 0.5 0.5 0.25\nv 0 0 0.5\nv 1 1 0\n", "a.obj"),
                              (b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                               b"end_header\n.5 .5 .25\n0 0 .5\n1 1 0\n", "a.ply")):
            answer = self.compare((content, name), (SQUARE, "b.obj"), b'{"direction": "a_to_b", "statistics": true}')
            self.assertEqual(answer.status, 200, answer.body)
            result, mesh = answer.json(), answer.json()["meshes"]["a"]
            self.assertEqual((mesh["triangles"], mesh["vertices"], mesh["degenerate"]), (0, 3, 0))
            self.assertLessEqual(result["distance"]["lower"], 0.5)
            self.assertGreaterEqual(result["distance"]["upper"], 0.5)
            self.assertLess(result["distance"]["upper"] - result["distance"]["lower"], 1e-12)
            self.assertEqual((result["a_to_b"]["culling"]["triangles"], result["a_to_b"]["witness"]["triangle_a"]), (3, 1))
            self.assertEqual(result["statistics"]["a_to_b"]["weight"], "points")
            self.assertIn("point cloud", mesh["notes"][0])

    def test_not_to_it(self):
        for a, b, options, part in (((CLOUD, "a.xyz"), (SQUARE, "b.obj"), b"{}", "a"),
                                    ((CLOUD, "a.xyz"), (SQUARE, "b.obj"), b'{"direction": "symmetric"}', "a"),
                                    ((CLOUD, "a.xyz"), (SQUARE, "b.obj"), b'{"direction": "b_to_a"}', "a"),
                                    ((SQUARE, "a.obj"), (CLOUD, "b.xyz"), b'{"direction": "a_to_b"}', "b"),
                                    ((CLOUD, "a.xyz"), (CLOUD, "b.xyz"), b'{"direction": "a_to_b"}', "b")):
            problem = self.refused(self.compare(a, b, options), 422, "empty-mesh")
            self.assertEqual([error["part"] for error in problem["errors"]], [part])
            self.assertIn("is a point cloud of 3 points", problem["detail"])

    def test_stored_with_its_maps(self):
        name = 'Content-Disposition: attachment; filename="scan.xyz"\r\n'
        answer = self.server.send("POST", "/v1/meshes", CLOUD, name)
        self.assertEqual(answer.status, 201, answer.body)
        pair = {"a": answer.json()["id"], "b": self.server.send("POST", "/v1/meshes", SQUARE).json()["id"],
                "options": {"direction": "a_to_b"}}
        for _ in range(2):  # the second time from memory
            answer = self.server.send("POST", "/v1/comparisons", json.dumps(pair).encode(), "Content-Type: application/json\r\n")
            self.assertEqual((answer.status, answer.json()["meshes"]["a"]["triangles"]), (200, 0), answer.body)
        path = "/v1/comparisons/" + answer.json()["id"]
        ply = self.server.get(path + "/deviation.ply").body
        self.assertIn(b"element vertex 3\n", ply)
        self.assertNotIn(b"element face", ply)
        glb = Glb(self.server.get(path + "/deviation.glb?max_triangles=2").body)
        self.assertEqual((glb.primitive["mode"], glb.accessor("POSITION")["count"]), (0, 1 + 1))
        self.assertEqual((glb.extras["candidate_triangles"], glb.extras["candidate_vertices"]), (0, 3))
        self.assertEqual(self.server.get(path + "/deviation.glb?of=b").status, 200)

    def test_in_a_batch(self):
        def put(content, name):
            return self.server.send("POST", "/v1/meshes", content, 'Content-Disposition: attachment; filename="%s"\r\n' % name).json()["id"]
        square, scans = put(SQUARE, "b.obj"), [put(b"0 0 0.5\n1 1 0.5\n", "near.xyz"), put(b"0 0 3\n1 1 0\n", "far.xyz")]
        manifest = {"options": {"direction": "a_to_b", "gate": {"max_distance": 1}},
                    "comparisons": [{"name": name, "a": scan, "b": square} for name, scan in zip(("near", "far"), scans)] +
                                   [{"name": "to a cloud", "a": square, "b": scans[0]}]}
        path = accepted(submit(self.server, manifest))
        counts = ended(self.server, path)["counts"]
        self.assertEqual((counts["pass"], counts["fail"], counts["failed"]), (1, 1, 1))
        found = {line["name"]: line for line in results(self.server, path)}
        self.assertEqual([found[name]["result"]["meshes"]["a"]["triangles"] for name in ("near", "far")], [0, 0])
        self.assertIn("is a point cloud of 2 points", found["to a cloud"]["problem"]["detail"])
        self.assertRegex(self.server.get(path + "/junit.xml").body.decode(), r"fail: the distance is at least \S+, above the limit of 1")

    def test_hostile_files(self):
        for content, status, slug, where in ((b"0 0\n", 422, "unreadable-mesh", "line 1"), (b"0 0 nan\n", 422, "non-finite-vertex", "line 1"),
                                             (b"1 2 3\n1 2 1e999\n", 422, "non-finite-vertex", "line 2"), (b"#\n", 422, "empty-mesh", ""),
                                             (b"\0\1\2\3", 415, "unsupported-format", ""), (b"0 0 1e308", 422, "coordinate-too-large", "vertex 0"),
                                             (b"1;2;3\n", 422, "unreadable-mesh", "line 1")):
            answer = self.compare((content, "a.xyz"), (SQUARE, "b.obj"), b'{"direction": "a_to_b"}')
            problem = self.refused(answer, status, slug)
            self.assertEqual([(error["part"], error["where"]) for error in problem["errors"]], [("a", where)], content)


def table(path):
    lines = path.read_text().splitlines()
    return [line.split("\t") for line in lines if line and not line.startswith("#")]


def other_answers():
    """The files that docs/formats.md says are answered otherwise than the index asks."""
    text = (ROOT / "docs" / "formats.md").read_text().split("## Where the readers answer otherwise", 1)[1]
    files = set()
    for pattern in re.findall(r"^\| (`.*?`) \|", text, re.M):
        for name in re.findall(r"`(.*?)`", pattern):
            head, braces, tail = re.fullmatch(r"(.*?)(?:\{(.*)\}(.*))?", name).groups()
            files |= {head + middle + tail for middle in braces.split(",")} if braces else {head}
    return files


def beside(file):
    """The files of the same folder that a .gltf names."""
    names = re.findall(rb'"uri"\s*:\s*"([^"%/:]+)"', file.read_bytes()) if file.suffix == ".gltf" else []
    paths = {file.parent / name.decode(errors="replace") for name in names}
    return [(path.read_bytes(), path.name) for path in paths if path.is_file() and path.suffix != ".gltf"]


def resident_kb(pid):
    """The resident memory of the process and of the processes that it started."""
    total = 0
    with contextlib.suppress(FileNotFoundError, ProcessLookupError, TypeError):  # one may end while it is looked at
        total += int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text())[1])
        for children in glob.glob(f"/proc/{pid}/task/*/children"):
            total += sum(resident_kb(int(child)) for child in pathlib.Path(children).read_text().split())
    return total


@unittest.skipUnless((CORPUS / "formats" / "INDEX.tsv").exists(), "no corpus: set MESHGAUGE_CORPUS")
class Corpus(FormatCase):
    def ask(self, file, other, options=b"{}"):
        answer = self.compare((file.read_bytes(), file.name), (other.read_bytes(), other.name), options, beside(file))
        self.assertIsNotNone(answer, file)
        return answer

    def rows(self, folder):
        return [row for row in table(CORPUS / folder / "INDEX.tsv") if "not an input" not in row[2]]

    def check_row(self, folder, row, answer):
        """Accepted or refused as the index asks, or as docs/formats.md lists."""
        accepted = answer.status == 200
        if not accepted:
            self.assertIn(answer.status, (413, 415, 422), row)
            problem = answer.json()
            self.assertEqual([error["part"] for error in problem["errors"]], ["a"], row)
            self.assertIn("'a'", problem["detail"])
        asked = row[2]
        agrees = (any(word in asked for word in ("accept", "documented choice", "finite answer")) if accepted
                  else "422" in asked or "413" in asked)
        self.assertEqual(agrees, f"{folder}/{row[0]}" not in other_answers(), (row[0], asked, answer.body[:300]))

    def within(self, told, mesh):
        """How far the index lets a surface be from another."""
        size = max(abs(x) for corner in ("low", "high") for x in mesh["bbox"][corner])
        try:
            return float(told)
        except ValueError:
            return size * (1e-9 if "1e-9" in told else 2 ** -19 if "after the shift" in told else 2 ** -21)

    def test_every_file_gives_the_answer_of_its_index(self):
        cube = CORPUS / "formats" / "unit_cube.obj"
        self.ask(cube, cube)
        before = resident_kb(self.server.process.pid)
        for folder in ("formats", "malformed"):
            for row in self.rows(folder):
                self.check_row(folder, row, self.ask(CORPUS / folder / row[0], cube))
        kept = self.kept_after(before)
        print(f"{kept / 1024:.1f} MB more resident than before")

    def kept_after(self, before):
        """What is resident beyond `before` once it is back within the bound."""
        end = time.monotonic() + 30
        while (kept := resident_kb(self.server.process.pid) - before) > MOST_KB and not SANITIZED:  # which keep what was freed
            self.assertLess(time.monotonic(), end, f"{kept} KB more resident than at the start")
            time.sleep(0.1)
        return kept

    def test_the_same_surface_as_named(self):
        for row in self.rows("formats"):
            if len(row) < 6 or not row[4]:
                continue
            answer = self.ask(CORPUS / "formats" / row[0], CORPUS / "formats" / row[4], b'{"tolerance": {"diagonal": 1e-6}}')
            if answer.status != 200:
                continue  # test_every_file_... has looked at it
            result = answer.json()
            allowed = 3 ** 0.5 * self.within(row[5], result["meshes"]["b"])
            self.assertEqual(result["status"], "converged", row)
            self.assertLessEqual(result["distance"]["lower"], allowed, row)
            self.assertLessEqual(result["distance"]["upper"], allowed + 1e-6 * result["meshes"]["a"]["diagonal"], row)


if __name__ == "__main__":
    unittest.main()
