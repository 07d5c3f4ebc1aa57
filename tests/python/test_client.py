"""meshgauge.Client against a real service."""

import pathlib
import sys
import tempfile
import threading
import unittest
import http.server

import meshgauge
import objects
import shapes

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "e2e"))
import harness  # noqa: E402
import keys  # noqa: E402

SQUARE = shapes.grid(2)
RAISED = (SQUARE[0] + [0, 0, 2.0], SQUARE[1])
ENDLESS = dict(tolerance=0, strategy="four_point", timeout=100)


class WithService(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = harness.Server()
        cls.addClassCleanup(cls.server.stop)
        cls.client = meshgauge.Client(f"http://127.0.0.1:{cls.server.port}", retry_time=5)

    def test_the_result_is_that_of_compare(self):
        a, b = shapes.sphere(20), shapes.sphere(13)
        there, here = self.client.compare(a, b, threads=1), meshgauge.compare(a, b, threads=1)
        self.assertIsInstance(there, meshgauge.Result)
        self.assertEqual((there.lower, there.upper, there.witness), (here.lower, here.upper, here.witness))
        self.assertEqual(there.document["meshes"]["a"]["format"], "ply")

    def test_paths_and_bytes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / 'a "part".obj'
            path.write_bytes(shapes.obj(SQUARE))
            result = self.client.compare(path, shapes.obj(RAISED), "2.5 mm")
        self.assertEqual((result.verdict, result.unit), ("pass", "mm"))

    def test_refusals_are_those_of_compare(self):
        bad = (SQUARE[0], SQUARE[1] + 100)
        with self.assertRaisesRegex(meshgauge.InputError, "uses vertex"):
            self.client.compare(bad, SQUARE)
        with self.assertRaises(meshgauge.InputError) as caught:
            self.client.compare(b"v 0 0 x\n", SQUARE)
        self.assertEqual(caught.exception.kind, "unreadable-mesh")
        with self.assertRaisesRegex(meshgauge.InputError, "/direction"):
            self.client.compare(SQUARE, RAISED, direction="up")
        with self.assertRaisesRegex(meshgauge.InputError, "glTF of several files"):
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "a.gltf"
                path.write_text('{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin", "byteLength": 1}]}')
                self.client.compare(path, SQUARE)

    def test_submit_and_wait(self):
        job = self.client.submit(SQUARE, RAISED, 2.5)
        self.assertEqual(job.wait(60).verdict, "pass")
        self.assertEqual(job.state()["state"], "done")
        self.assertEqual(self.client.job(job.id).wait().verdict, "pass")
        job.cancel()
        with self.assertRaises(meshgauge.ServiceError) as caught:
            job.wait()
        self.assertEqual((caught.exception.status, caught.exception.kind), (404, "not-found"))

    def test_objects_their_notes_and_their_units(self):
        strips = objects.PolyData(SQUARE[0], strips=[6, 0, 3, 1, 4, 2, 5])
        note = "a: strips of triangles, split into triangles and measured: 1"
        self.assertIn(note, self.client.compare(strips, RAISED).notes)
        job = self.client.submit(strips, RAISED)
        for _ in range(2):
            self.assertEqual(job.wait(60).notes.count(note), 1)
        in_list = self.client.batch([(RAISED, SQUARE), (strips, RAISED), ([SQUARE, objects.Trimesh(*RAISED)], RAISED)])
        self.assertEqual([note in result.notes for result in in_list], [False, True, False])
        self.assertIn("a: meshes of a list, measured as one: 2", in_list[2].notes)
        inch = objects.Trimesh(*SQUARE, "in")
        for result in (self.client.compare(inch, inch, "1 mm"), *self.client.batch([(inch, inch)], "1 mm")):
            self.assertEqual((result.unit, result.document["meshes"]["a"]["unit"]["name"]), ("mm", "in"))
        with self.assertRaisesRegex(meshgauge.InputError, "extract_surface"):
            self.client.compare(SQUARE, objects.StructuredGrid())

    def test_wait_has_a_timeout_and_cancel_ends_it(self):
        job = self.client.submit(shapes.grid(40), shapes.grid(43), **ENDLESS)
        with self.assertRaises(TimeoutError):
            job.wait(0.3)
        job.cancel()
        try:
            self.assertEqual(job.wait(60).status, "cancelled")
        except meshgauge.ServiceError as before_it_began:
            self.assertEqual(before_it_began.kind, "cancelled")

    def test_the_map_of_a_comparison(self):
        closed = shapes.sphere(6)
        result = self.client.compare(RAISED, closed, sides=True)
        with self.assertRaises(meshgauge.ServiceError) as caught:
            self.client.map(result)
        self.assertEqual(caught.exception.status, 410)
        found = {name: self.client.map(result, name, normals=True, meshes=(RAISED, closed)) for name in ("ply", "glb", "vtp", "csv")}
        self.assertTrue(found["ply"].startswith(b"ply\n") and b"property float nx" in found["ply"])
        self.assertTrue(found["glb"].startswith(b"glTF") and b"NORMAL" in found["glb"])
        self.assertIn(b'Name="Normals"', found["vtp"])
        head, *lines = found["csv"].decode().splitlines()
        self.assertEqual((head, len(lines)), ("x,y,z,distance,signed_distance,nx,ny,nz", len(RAISED[0])))
        here = meshgauge.compare(RAISED, closed, sides=True, vertex_distances=True)
        self.assertEqual([float(line.split(",")[3]) for line in lines], list(here.vertex_distances))
        self.assertEqual(self.client.map(result.document["id"], "csv", normals=True), found["csv"])
        of_b = self.client.map(result, "csv", of="b").decode().splitlines()
        self.assertEqual((of_b[0], len(of_b)), ("x,y,z,distance", 1 + len(closed[0])))
        with self.assertRaisesRegex(meshgauge.InputError, "format must be one of ply, glb, vtp, csv, not 'obj'"):
            self.client.map(result, "obj")
        with self.assertRaisesRegex(Exception, "a .csv has the whole mesh"):
            self.client.map(result, "csv", max_triangles=9)
        with self.assertRaises(meshgauge.ServiceError) as caught:
            self.client.map("none")
        self.assertEqual(caught.exception.status, 404)

    def test_a_batch(self):
        broken = b"v 0 0 x\n"
        found = self.client.batch([(SQUARE, RAISED), (SQUARE, RAISED, {"max_distance": 1}), (broken, SQUARE), (RAISED, SQUARE)],
                                  2.5, name="four pairs")
        self.assertEqual([r.verdict for r in (found[0], found[1], found[3])], ["pass", "fail", "pass"])
        self.assertIsInstance(found[2], meshgauge.InputError)
        self.assertEqual(self.client.batch([]), [])
        with self.assertRaisesRegex(meshgauge.InputError, "a' must be a path"):
            self.client.batch([(None, SQUARE)])


class WithKeys(unittest.TestCase):
    def test_a_key_is_needed(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "keys.json"
            token, entry = keys.new_key("python")
            keys.write_keys(path, entry)
            server = harness.Server("--keys-file", str(path))
            self.addCleanup(server.stop)
            url = f"http://127.0.0.1:{server.port}"
            with self.assertRaises(meshgauge.ServiceError) as caught:
                meshgauge.Client(url).compare(SQUARE, RAISED)
            self.assertEqual((caught.exception.status, caught.exception.kind), (401, "unauthorized"))
            self.assertEqual(meshgauge.Client(url, token).compare(SQUARE, RAISED, 2.5).verdict, "pass")


class Refusing(http.server.BaseHTTPRequestHandler):
    """Answers 503 twice, then something that is no result; and redirects a GET."""

    asked = 0
    seen = []

    def do_POST(self):
        type(self).asked += 1
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(503 if self.asked <= 2 else 200)
        self.send_header("Retry-After", "0")
        self.end_headers()
        self.wfile.write(b"<html>")

    def do_GET(self):
        self.seen.append(self.path)
        self.send_response(302)
        self.send_header("Location", "/elsewhere")
        self.end_headers()

    def log_message(self, *_):
        pass


class WithoutService(unittest.TestCase):
    def test_an_address_where_nothing_listens(self):
        client = meshgauge.Client("http://127.0.0.1:1", retry_time=0.1)
        with self.assertRaisesRegex(meshgauge.ServiceError, "cannot be reached") as caught:
            client.compare(SQUARE, RAISED)
        self.assertIsNone(caught.exception.status)

    def test_retries_other_answers_and_redirections(self):
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Refusing)
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        self.addCleanup(lambda: (server.shutdown(), thread.join(), server.server_close()))
        client = meshgauge.Client(f"http://127.0.0.1:{server.server_port}/", "key", retry_time=30)
        with self.assertRaisesRegex(meshgauge.ServiceError, "not that of a meshgauge service"):
            client.compare(SQUARE, RAISED)
        self.assertEqual(Refusing.asked, 3)
        with self.assertRaises(meshgauge.ServiceError):
            client.job("1").state()
        self.assertEqual(Refusing.seen, ["/v1/comparisons/1"])

    def test_addresses_and_keys_that_are_refused(self):
        for url, key, message in (("meshgauge.example", None, "http://HOST"), ("ftp://x", None, "http://HOST"),
                                  ("http://user:secret@127.0.0.1", None, "password"), ("http://meshgauge.example", "key", "use https"),
                                  ("http://127.0.0.1", "two words", "visible ASCII"), ("http://127.0.0.1", "a\nb", "visible ASCII")):
            with self.subTest(url), self.assertRaisesRegex(meshgauge.InputError, message):
                meshgauge.Client(url, key)
        meshgauge.Client("http://meshgauge.example", "key", key_in_clear=True)


if __name__ == "__main__":
    unittest.main()
