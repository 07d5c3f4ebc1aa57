"""glTF with files beside it: by HTTP parts, as an archive, stored, in a batch, and on the command line."""

import csv
import hashlib
import json
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest
import zipfile

from harness import BINARY, OWN_DATA, ROOT, ServerCase, post_head, until
from packages import zipped

CORPUS = pathlib.Path(os.environ.get("MESHGAUGE_CORPUS", ROOT.parent / "shared" / "corpus"))
WILD = ("03", "06", "08", "09", "10", "15", "16", "18", "25", "34", "35", "37", "38")  # rows of wild/INDEX.tsv with an external .bin
AS_JSON = "Content-Type: application/json\r\n"
AS_ZIP = 'Content-Type: application/zip\r\nContent-Disposition: attachment; filename="square.zip"\r\n'
SQUARE_BIN = struct.pack("<12f6H", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 2, 0, 2, 3)
RAISED_BIN = struct.pack("<12f6H", 0, 0, 2, 1, 0, 2, 1, 1, 2, 0, 1, 2, 0, 1, 2, 0, 2, 3)


def scene(uri="x.bin"):
    return json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60, "uri": uri}]}).encode()


def square_zip(data=SQUARE_BIN):
    return zipped({"m/s.gltf": scene("sub%20folder/x.bin"), "m/sub folder/x.bin": data, "m/picture.png": b"no picture"})


def form(*parts):
    """Each of a name, a file name and its content."""
    body = b""
    for name, filename, content in parts:
        body += (b'--XXboundaryXX\r\nContent-Disposition: form-data; name="%s"; filename="%s"\r\n\r\n%s\r\n'
                 % (name.encode(), filename.encode(), content))
    return body + b"--XXboundaryXX--\r\n"


class Service(ServerCase):
    def ask(self, *parts, extra=""):
        body = form(*parts)
        return self.server.raw(post_head(len(body), extra) + body)

    def check_distance(self, document, expected=2):
        self.assertLessEqual(document["distance"]["lower"], expected)
        self.assertGreaterEqual(document["distance"]["upper"], expected)
        for mesh in document["meshes"].values():
            self.assertEqual((mesh["format"], mesh["triangles"], mesh["format_mismatch"]), ("gltf", 2, None))

    def test_parts(self):
        answer = self.ask(("a.files", "x.bin", SQUARE_BIN), ("a", "square.gltf", scene()), ("b", "raised.gltf", scene("d/y.bin")),
                          ("b.files", "d/y.bin", RAISED_BIN), ("b.files", "unused.bin", b"of a picture"))
        self.assertEqual(answer.status, 200, answer.body)
        self.check_distance(answer.json())

    def test_archives(self):
        answer = self.ask(("a", "a.zip", square_zip()), ("b", "", square_zip(RAISED_BIN)))
        self.assertEqual(answer.status, 200, answer.body)
        self.check_distance(answer.json())
        self.assertEqual(answer.json()["meshes"]["a"]["sha256"], hashlib.sha256(square_zip()).hexdigest())
        self.assertEqual(answer.json()["meshes"]["a"]["bytes"], len(square_zip()))

    def test_large_files_are_put_together_from_files(self):
        padding = bytes(3 << 20)
        answer = self.ask(("a", "a.gltf", scene()), ("a.files", "x.bin", SQUARE_BIN + padding),
                          ("b", "b.gltf", scene()), ("b.files", "x.bin", RAISED_BIN + padding))
        self.assertEqual(answer.status, 200, answer.body)
        self.check_distance(answer.json())

    def test_as_a_job(self):
        parts = (("a", "a.gltf", scene()), ("a.files", "x.bin", SQUARE_BIN), ("b", "b.gltf", scene()), ("b.files", "x.bin", RAISED_BIN))
        answer = self.ask(*parts, extra="Prefer: respond-async\r\nIdempotency-Key: once\r\n")
        self.assertEqual(answer.status, 202, answer.body)
        path = answer.headers["location"]
        until(lambda: self.server.get(path).json()["state"] == "done")
        self.check_distance(self.server.get(path).json()["result"])
        again = self.ask(*parts, extra="Idempotency-Key: once\r\n")
        self.assertEqual(again.json()["id"], path.rsplit("/", 1)[1])
        other = self.ask(*parts[:3], ("b.files", "x.bin", SQUARE_BIN), extra="Idempotency-Key: once\r\n")
        self.refused(other, 422, "idempotency-key-reused")

    def store(self, content):
        answer = self.server.send("PUT", "/v1/meshes/" + hashlib.sha256(content).hexdigest(), content, AS_ZIP)
        self.assertIn(answer.status, (200, 201), answer.body)
        self.assertEqual(answer.json()["media_type"], "application/zip")
        return answer.json()["id"]

    def test_stored(self):
        pair = {"a": self.store(square_zip()), "b": self.store(square_zip(RAISED_BIN))}
        answer = self.server.send("POST", "/v1/comparisons", json.dumps(pair).encode(), AS_JSON)
        self.assertEqual(answer.status, 200, answer.body)
        self.check_distance(answer.json())

    def finished(self, answer):
        self.assertEqual(answer.status, 202, answer.body)
        path = answer.headers["location"]
        until(lambda: self.server.get(path).json()["finished"])
        line, = self.server.get(path + "/results.jsonl").body.splitlines()
        return json.loads(line)

    def test_batches(self):
        stored = {"comparisons": [{"a": self.store(square_zip()), "b": self.store(square_zip(RAISED_BIN))}]}
        self.check_distance(self.finished(self.server.send("POST", "/v1/batches", json.dumps(stored).encode(), AS_JSON))["result"])
        sent = {"comparisons": [{"a": {"part": "one"}, "b": {"part": "two"}}]}
        body = form(("manifest", "", json.dumps(sent).encode()), ("one", "a.zip", square_zip()), ("two", "b.zip", square_zip(RAISED_BIN)))
        answer = self.server.send("POST", "/v1/batches", body, "Content-Type: multipart/form-data; boundary=XXboundaryXX\r\n")
        self.check_distance(self.finished(answer)["result"])

    def test_what_is_missing(self):
        problem = self.refused(self.ask(("a", "a.gltf", scene()), ("b", "b.zip", square_zip())), 422, "unreadable-mesh")
        self.assertIn("buffers[0] of 'a': names the file 'x.bin', which was not sent with it: put both into one .zip (or, over HTTP, "
                      "send the file as a part 'a.files' or 'b.files')", problem["detail"])
        for parts in ((("a", "a.gltf", scene()), ("a.files", "y.bin", SQUARE_BIN)),
                      (("a", "a.zip", zipped({"m/s.gltf": scene(), "x.bin": SQUARE_BIN})),)):
            problem = self.refused(self.ask(*parts, ("b", "b.zip", square_zip())), 422, "unreadable-mesh")
            self.assertIn("names the file 'x.bin', which is not among the files sent with it", problem["detail"])
        problem = self.refused(self.ask(("a", "a.zip", zipped({"s.gltf": scene(), "t.gltf": scene(), "x.bin": SQUARE_BIN})),
                                        ("b", "b.zip", square_zip())), 422, "unreadable-mesh")
        self.assertIn("a zip archive with 2 .gltf files; exactly one is allowed", problem["detail"])

    def test_a_pointer_of_git_lfs_for_a_file(self):
        pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 60\n"
        problem = self.refused(self.ask(("a", "a.zip", zipped({"s.gltf": scene(), "x.bin": pointer})), ("b", "b.zip", square_zip())),
                               415, "unsupported-format")
        self.assertIn("buffers[0] of 'a': 'x.bin' is a Git LFS pointer, not a mesh: 'git lfs pull'", problem["detail"])

    def test_names_that_lead_elsewhere(self):
        for name, what in (("../x.bin", "has '..'"), ("d/../../x.bin", "has '..'"), ("/etc/passwd", "is absolute"),
                           ("file:///etc/passwd", "has a scheme"), ("C:x.bin", "has a scheme"), ("http://127.0.0.1:9/x", "has a scheme"),
                           ("d/", "names a folder"), ("", "is empty"), ("t.gltf", "is that of a .gltf"), ("x" * 2000, "is longer")):
            problem = self.refused(self.ask(("a", "a.gltf", scene()), ("a.files", name, SQUARE_BIN), ("b", "b.zip", square_zip())),
                                   400, "malformed-request")
            self.assertEqual(problem["errors"][0]["part"], "a.files")
            self.assertIn(what, problem["detail"])
        for uri, what in (("../x.bin", "has '..'"), ("%2e%2e/x.bin", "has '..'"), ("%2E%2E%2Fx.bin", "has '..'"),
                          ("/etc/passwd", "is absolute"), ("%2fetc%2fpasswd", "is absolute"), ("/dev/zero", "is absolute"),
                          ("file:///etc/passwd", "has a scheme"), ("http://127.0.0.1:9/x.bin", "has a scheme"),
                          ("..\\x.bin", "has a backslash"), ("x%00.bin", "has a control character")):
            for a in (("a", "a.gltf", scene(uri)), ("a", "a.zip", zipped({"m/s.gltf": scene(uri), "x.bin": SQUARE_BIN, uri: SQUARE_BIN}))):
                problem = self.refused(self.ask(a, ("b", "b.zip", square_zip())), 422, "unreadable-mesh")
                self.assertIn("buffers[0].uri of 'a'", problem["detail"])
                self.assertIn(what, problem["detail"])

    def test_links_in_an_archive_are_no_links(self):
        link = zipfile.ZipInfo("x.bin")
        link.external_attr = 0o120777 << 16
        problem = self.refused(self.ask(("a", "a.zip", zipped({"s.gltf": scene(), link: b"/dev/zero"})), ("b", "b.zip", square_zip())),
                               422, "unreadable-mesh")
        self.assertIn("byteLength is 60, but there are 9 bytes of data in 'x.bin'", problem["detail"])

    def test_what_files_do_not_go_with(self):
        for content in (b"v 0 0 0\n", b"", square_zip()):
            problem = self.refused(self.ask(("a", "a", content), ("a.files", "x.bin", SQUARE_BIN), ("b", "b.zip", square_zip())),
                                   400, "malformed-request")
            self.assertIn("the part 'a' is not a .gltf document", problem["detail"])
        twice = self.ask(("a", "a.gltf", scene()), ("a.files", "x.bin", b""), ("a.files", "./x.bin", b""), ("b", "b.zip", square_zip()))
        self.assertIn("was sent twice", self.refused(twice, 400, "malformed-request")["detail"])
        many = [("a.files", "x%d.bin" % i, b"") for i in range(65)]
        self.assertIn("too many parts 'a.files' (limit 64)", self.refused(self.ask(("a", "a", scene()), *many), 400, "malformed-request")["detail"])

    def test_check_by_a_service_sends_an_archive(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, data in (("square", SQUARE_BIN), ("raised", RAISED_BIN)):
                (pathlib.Path(folder) / (name + ".gltf")).write_bytes(scene(name + ".bin"))
                (pathlib.Path(folder) / (name + ".bin")).write_bytes(data)
            url = "http://127.0.0.1:%d" % self.server.port
            for limit, code in (("2.5", 0), ("1.5", 1)):
                told = subprocess.run([BINARY, "check", "square.gltf", "raised.gltf", "--max-distance", limit, "--server", url],
                                      capture_output=True, text=True, timeout=120, env=OWN_DATA, cwd=folder)
                self.assertEqual(told.returncode, code, told.stdout + told.stderr)
            (pathlib.Path(folder) / "raised.bin").unlink()
            told = subprocess.run([BINARY, "check", "square.gltf", "raised.gltf", "--max-distance", "1", "--server", url],
                                  capture_output=True, text=True, timeout=120, env=OWN_DATA, cwd=folder)
            self.assertEqual(told.returncode, 3)
            self.assertIn("'raised.gltf' is a glTF of several files: './raised.bin' cannot be read: No such file", told.stdout)

    @unittest.skipUnless((CORPUS / "wild" / "INDEX.tsv").exists(), "no corpus: set MESHGAUGE_CORPUS")
    def test_the_wild(self):
        """Files of the corpus as parts, and by `check`; test_wild has the rest."""
        index = (CORPUS / "wild" / "INDEX.tsv").read_text().splitlines()
        rows = {row[0].split("/")[0]: row for row in csv.reader(index, delimiter="\t")}
        for number in WILD:
            file = CORPUS / "wild" / rows[number][0]
            beside = [path for path in file.parent.iterdir() if path != file]
            parts = [("a.files", path.name, path.read_bytes()) for path in beside]
            archive = zipped({path.name: path.read_bytes() for path in (file, *beside)})
            answer = self.ask(("a", file.name, file.read_bytes()), *parts, ("b", file.stem + ".zip", archive))
            self.assertEqual(answer.status, 200, (rows[number], answer.body))
            self.assertEqual(answer.json()["distance"]["lower"], 0)
            self.assertEqual([mesh["triangles"] for mesh in answer.json()["meshes"].values()], 2 * [int(rows[number][2])])
            with tempfile.TemporaryDirectory() as folder:
                baseline = pathlib.Path(folder) / "baseline.zip"
                baseline.write_bytes(archive)
                check = subprocess.run([BINARY, "check", file, baseline, "--max-distance", "1"], capture_output=True, text=True,
                                       timeout=120, env=OWN_DATA)
            self.assertEqual(check.returncode, 0, check.stdout + check.stderr)


class CommandLine(unittest.TestCase):
    def setUp(self):
        self.root = tempfile.TemporaryDirectory()
        self.addCleanup(self.root.cleanup)
        self.folder = pathlib.Path(self.root.name) / "in"
        (self.folder / "sub").mkdir(parents=True)
        for path in (self.folder / "x.bin", self.folder / "sub" / "x y.bin", self.folder.parent / "out.bin"):
            path.write_bytes(SQUARE_BIN)

    def tell(self, command, uri, *more):
        for name in ("s.gltf", "t.gltf"):
            (self.folder / name).write_bytes(scene(uri))
        run = subprocess.run([BINARY, command, self.folder / "s.gltf", self.folder / "t.gltf", *more], capture_output=True, text=True, timeout=60, env=OWN_DATA)
        return run.returncode, run.stdout + run.stderr

    def refused(self, uri, what):
        for command, more in (("compare", ()), ("check", ("--max-distance", "1"))):
            code, text = self.tell(command, uri, *more)
            self.assertEqual(code, 3, (command, uri, text))
            self.assertIn(what, text, (command, uri))

    def test_files_beside_it(self):
        for uri in ("x.bin", "sub/x%20y.bin", "./sub//x y.bin"):
            self.assertEqual(self.tell("compare", uri)[0], 0)
            self.assertEqual(self.tell("check", uri, "--max-distance", "1")[0], 0)

    def test_an_archive(self):
        archive, other = self.folder / "s.zip", self.folder / "t.zip"
        for path in (archive, other):
            path.write_bytes(square_zip())
        for command in (("compare", archive, other), ("check", archive, other, "--max-distance", "1")):
            run = subprocess.run([BINARY, *command], capture_output=True, text=True, timeout=60, env=OWN_DATA)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        run = subprocess.run([BINARY, "check", archive], capture_output=True, text=True, timeout=60, env=OWN_DATA)
        self.assertIn("is a mesh: name its baseline behind it", run.stderr)

    def test_nothing_outside_of_its_folder(self):
        (self.folder / "link.bin").symlink_to(self.folder.parent / "out.bin")
        (self.folder / "inner.bin").symlink_to("x.bin")
        (self.folder / "up").symlink_to(self.folder.parent)
        (self.folder / "zero.bin").symlink_to("/dev/zero")
        for uri in ("../out.bin", "sub/../../out.bin", "%2e%2e/out.bin", "%2E%2E%2Fout.bin"):
            self.refused(uri, "has '..', which may lead out of the folder of the .gltf")
        for uri in (str(self.folder.parent / "out.bin"), "/dev/zero", "%2Fetc%2Fpasswd"):
            self.refused(uri, "is absolute")
        for uri in ("file:///etc/passwd", "http://127.0.0.1:9/x.bin", "https://127.0.0.1:9/x.bin"):
            self.refused(uri, "has a scheme, and nothing is fetched")
        for uri in ("link.bin", "inner.bin", "up/out.bin", "zero.bin"):
            self.refused(uri, "is a symbolic link or lies behind one, which is not followed")

    def test_what_is_no_file(self):
        os.mkfifo(self.folder / "pipe.bin")  # nothing writes to it: opening it would wait for ever
        self.refused("pipe.bin", "pipe.bin' is not a regular file")
        self.refused("sub", "sub' is a folder")
        self.refused("none.bin", "none.bin' cannot be read: No such file or directory")


if __name__ == "__main__":
    unittest.main()
