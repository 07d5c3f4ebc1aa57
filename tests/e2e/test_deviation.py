"""Deviation maps of comparisons: what is in them, and which requests for one are refused."""

import csv
import hashlib
import io
import json
import re
import resource
import signal
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

from harness import BINARY, ENVIRONMENT, RAISED, SLOW, SLOW_OPTIONS, SQUARE, ServerCase, occupy_guests, until
from maps import FLAT, KINDS, WAVY, Glb, as_floats, compared, ply_of, positions_of


def box(half, top):
    """A closed box about the origin whose height is 2 * top."""
    corners = [(x, y, z) for z in (-top, top) for y in (-half, half) for x in (-half, half)]
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
    return ("".join("v %r %r %r\n" % p for p in corners) + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)).encode()


class Content(ServerCase):
    flags = ("--workers", "2")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.path, cls.result = compared(cls.server)

    def map(self, name, path=None):
        answer = self.server.get("%s/deviation.%s" % (path or self.path, name))
        self.assertEqual(answer.status, 200, answer.body[:500])
        return answer

    def written_by(self, suffix, command, *flags):
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / name for name in ("a.obj", "b.obj", "map" + suffix)]
            files[0].write_bytes(WAVY)
            files[1].write_bytes(FLAT)
            done = subprocess.run([BINARY, command, *map(str, files[:2]), *flags, "--threads", "1", "--deviation", str(files[2])],
                                  env=ENVIRONMENT, capture_output=True, timeout=60)
            self.assertEqual(done.returncode, 1 if "--max-distance" in flags else 0, done.stderr)  # the gate fails
            return files[2].read_bytes()

    def test_the_files_are_those_of_the_commands(self):
        for suffix, media_type in ((".ply", "model/ply"), (".glb", "model/gltf-binary"), (".vtp", "application/vnd.vtk.polydata"), (".csv", "text/csv")):
            answer = self.map(suffix[1:])
            self.assertEqual(answer.headers["content-type"], media_type)
            for command in ("check", "compare"):
                self.assertEqual(answer.body, self.written_by(suffix, command, "--max-distance", "0.05 mm", "--fast"), suffix)

    def test_a_map_that_cannot_be_written_takes_no_result_with_it(self):
        def small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / name for name in ("a.obj", "b.obj", "map.ply")]
            files[0].write_bytes(WAVY)
            files[1].write_bytes(FLAT)
            done = subprocess.run([BINARY, "compare", "--json", *map(str, files[:2]), "--map", str(files[2])], env=ENVIRONMENT,
                                  capture_output=True, timeout=60, preexec_fn=small_files)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn(b"map.ply", done.stderr)
            self.assertLessEqual(json.loads(done.stdout)["distance"]["lower"], self.result["distance"]["upper"])
            self.assertFalse(files[2].exists())

    def test_csv(self):
        lines = self.written_by(".csv", "compare").decode().splitlines()
        self.assertEqual(lines[0], "x,y,z,distance")
        rows = [tuple(map(float, line.split(","))) for line in lines[1:]]
        _, distances, _ = ply_of(self.written_by(".ply", "compare"))
        self.assertEqual([row[:3] for row in rows], [tuple(p) for p in positions_of(WAVY)])
        self.assertEqual([row[3] for row in rows], distances)

    def test_sides(self):
        cube, larger = box(1, 1), box(1.0625, 0.75)  # inside on two sides, outside on the others
        for options, flags in (({"sides": {}}, ["--sides"]), ({"zone": [-1, 1], "narrow": False}, ["--zone=-1, 1", "--fast"])):
            path, result = compared(self.server, larger, cube, {**options, "threads": 1})
            self.assertIsNone(result["sides"]["refused"])
            files = {}
            with tempfile.TemporaryDirectory() as folder:
                for name, mesh in (("a.obj", larger), ("b.obj", cube)):
                    Path(folder, name).write_bytes(mesh)
                for suffix in KINDS:
                    subprocess.run([BINARY, "compare", "a.obj", "b.obj", *flags, "--threads", "1", "--map", "map." + suffix], cwd=folder, env=ENVIRONMENT,
                                   check=True, capture_output=True, timeout=60)
                    files[suffix] = Path(folder, "map." + suffix).read_bytes()
            for suffix, content in files.items():
                self.assertEqual(content, self.map(suffix, path).body)
            lines = files["csv"].decode().splitlines()
            self.assertEqual(lines[0], "x,y,z,distance,signed_distance")
            for line in lines[1:]:
                x, y, z, distance, sign = map(float, line.split(","))
                self.assertEqual(sign, -distance if max(abs(x), abs(y), abs(z)) < 1 else distance)
            glb = Glb(files["glb"])
            sides = [side for side, in glb.numbers("_SIDE", "f", 1)]
            self.assertLessEqual({-1, 1}, set(sides))
            for point, (distance,), side in zip(glb.numbers("POSITION", "f", 3), glb.numbers("_DISTANCE", "f", 1), sides):
                if distance > 1e-6:
                    self.assertEqual(side, 1 if max(map(abs, point)) > 1 else -1, point)
            self.assertIn(b'Name="signed_distance"', files["vtp"])
            other = self.map("ply?of=b", path).body  # of the baseline no side was asked
            self.assertNotIn(b"signed_distance", other)
        path, result = compared(self.server, cube, FLAT, {"sides": {}})
        self.assertEqual(result["sides"]["refused"]["reason"], "open")
        why = result["sides"]["refused"]["detail"].replace("mesh b", "the baseline")
        comments, _, _ = ply_of(self.map("ply", path).body)
        self.assertIn("no signed_distance: " + why, comments)
        self.assertEqual(Glb(self.map("glb", path).body).extras["no_sides"], why)
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "a.obj").write_bytes(cube)
            Path(folder, "b.obj").write_bytes(FLAT)
            done = subprocess.run([BINARY, "compare", "a.obj", "b.obj", "--sides", "--map", "map.csv"], cwd=folder, env=ENVIRONMENT, check=True,
                                  capture_output=True, timeout=60)
            self.assertEqual(done.stderr.decode(), "meshgauge: 'map.csv' has no signed distance: %s\n" % why)
            self.assertEqual(Path(folder, "map.csv").read_bytes(), self.map("csv", path).body)
        rows = list(csv.DictReader(io.StringIO(self.map("csv?normals=true", path).body.decode())))
        self.assertEqual(list(rows[0]), ["x", "y", "z", "distance", "nx", "ny", "nz", "no_sides"])
        self.assertEqual([row["no_sides"] for row in rows], [why] + [""] * (len(rows) - 1))

    def test_normals(self):
        flags = ("--max-distance", "0.05 mm", "--fast", "--map-normals")
        for suffix in KINDS:
            answer = self.map(suffix + "?normals=true").body
            self.assertEqual(answer, self.written_by("." + suffix, "check", *flags), suffix)
            self.assertNotEqual(answer, self.map(suffix).body)
        lines = self.map("csv?normals=true").body.decode().splitlines()
        self.assertEqual(lines[0], "x,y,z,distance,nx,ny,nz")
        for line in lines[1:]:
            normal = [float(number) for number in line.split(",")[4:]]
            self.assertAlmostEqual(sum(x * x for x in normal), 1)
            self.assertGreater(normal[2], 0)

    def test_ply(self):
        comments, distances, faces = ply_of(self.map("ply").body)
        self.assertEqual((len(distances), faces), (61 * 61, 7200))
        self.assertEqual([round(d, 9) for d in distances], [round(abs(z), 9) for _, _, z in positions_of(WAVY)])
        self.assertIn("unit mm", comments)
        self.assertIn("limit 0.05", comments)

    def test_glb(self):
        glb = Glb(self.map("glb").body)
        extras = glb.extras
        self.assertEqual((extras["units"], extras["limit"]), ("mm", 0.05))
        self.assertEqual({"lower": extras["lower"], "upper": extras["upper"]}, self.result["distance"])
        witness = self.result["a_to_b"]["witness"]
        self.assertEqual(extras["witness"], {"from_candidate": True, "from": witness["point_a"], "to": witness["point_b"],
                                             "from_triangle": witness["triangle_a"], "to_triangle": witness["triangle_b"]})
        self.assertEqual(extras["direction"]["upper"], self.result["a_to_b"]["upper"])
        self.assertEqual(extras["display"], {"form": "refined", "triangles": 7200, "vertices": 3721})
        self.assertGreater(glb.triangles, 7200)
        self.assertEqual(glb.numbers("POSITION", "f", 3)[:3721], [as_floats(p) for p in positions_of(WAVY)])

    def test_the_other_mesh(self):
        path, result = compared(self.server, options={})
        _, distances, faces = ply_of(self.map("ply?of=b", path).body)
        self.assertEqual((len(distances), faces), (51 * 51, 5000))
        extras = Glb(self.map("glb?of=b", path).body).extras
        self.assertEqual(extras["display"]["vertices"], 51 * 51)
        witness = result["b_to_a"]["witness"]
        self.assertEqual((extras["direction"]["witness"]["from"], extras["direction"]["witness"]["from_candidate"]),
                         (witness["point_a"], True))
        self.assertFalse(extras["witness"]["from_candidate"])  # the distance is attained on the other mesh
        self.assertLessEqual(max(distances), result["b_to_a"]["upper"])

    def test_a_direction_that_was_not_asked_for_is_not_certified(self):
        path, result = compared(self.server, options={"direction": "a_to_b"})
        extras = Glb(self.map("glb?of=b", path).body).extras
        self.assertNotIn("direction", extras)
        self.assertEqual(extras["upper"], result["distance"]["upper"])
        self.assertEqual(extras["witness"]["from"], result["a_to_b"]["witness"]["point_a"])
        _, distances, _ = ply_of(self.map("ply?of=b", path).body)
        self.assertEqual(extras["largest"], max(distances))

    def test_without_a_gate_the_colours_end_at_the_largest_distance(self):
        path, _ = compared(self.server, options={})
        _, distances, _ = ply_of(self.map("ply", path).body)
        for name in ("glb", "glb?max_triangles=500"):
            extras = Glb(self.map(name, path).body).extras
            self.assertEqual(extras["largest"], max(distances), name)
            self.assertNotIn("limit", extras)

    def test_a_small_mesh_is_refined(self):
        path, _ = compared(self.server, SQUARE, RAISED)
        extras = Glb(self.map("glb", path).body).extras
        self.assertEqual(extras["display"], {"form": "refined", "triangles": 2, "vertices": 4})
        few = Glb(self.map("glb?max_triangles=100", path).body)
        self.assertEqual(few.extras["display"]["form"], "refined")
        self.assertLessEqual(few.triangles, 100)
        self.assertEqual(Glb(self.map("glb?max_triangles=2", path).body).extras["display"]["form"], "as_is")

    def test_a_large_mesh_is_shown_by_some_of_its_vertices(self):
        path, _ = compared(self.server, options={})
        positions = [as_floats(p) for p in positions_of(WAVY)]
        distances = ply_of(self.map("ply", path).body)[1]
        known = {(p, struct.unpack("<f", struct.pack("<f", d))[0]) for p, d in zip(positions, distances)}
        for most in (1, 2, 50):
            self.assertTrue(1 <= Glb(self.map("glb?max_triangles=%d" % most, path).body).triangles <= most)
        for most in (1000, 5000):
            glb = Glb(self.map("glb?max_triangles=%d" % most, path).body)
            self.assertEqual(glb.extras["display"], {"form": "decimated", "triangles": 7200, "vertices": 3721})
            self.assertTrue(0.6 * most <= glb.triangles <= most)
            shown = [d for d, in glb.numbers("_DISTANCE", "f", 1)]
            self.assertEqual(max(shown), struct.unpack("<f", struct.pack("<f", max(distances)))[0])
            self.assertNotIn("translation", glb.node)
            for point, (distance,) in zip(glb.numbers("POSITION", "f", 3), glb.numbers("_DISTANCE", "f", 1)):
                self.assertIn((point, distance), known)

    def test_what_a_float_cannot_hold(self):
        path, _ = compared(self.server, SQUARE.replace(b"v 1 1 0", b"v 1e39 1 0"), SQUARE, {})
        self.assertIn("write a .ply", self.refused(self.server.get(path + "/deviation.glb"), 413, "too-large")["detail"])
        self.map("ply", path)


class Refusals(ServerCase):
    flags = ("--workers", "1", "--queue", "1")

    def test_wrong_queries_are_refused_in_words(self):
        path, _ = compared(self.server)
        for query, words in (("x=1", "unknown query parameter 'x'; known: of"), ("of=c", "'of' must be a or b, not 'c'"),
                             ("of", "must be a or b, not ''"), ("of=a&of=a", "'of' stands there twice"), ("&", "unknown"),
                             ("max_triangles=5", "'max_triangles' is for .glb"), ("of=%61", "must be a or b")):
            for name in ("ply", "vtp", "csv"):
                self.assertIn(words, self.refused(self.server.get("%s/deviation.%s?%s" % (path, name, query)), 400, "malformed-request")["detail"])
        self.refused(self.server.get(path + "/deviation.glb?normals=yes"), 400, "malformed-request")
        for value in ("0", "-1", "1.5", "1e3", "", "+1", "0x10", "1073741825", "9" * 40, "1&max_triangles=1"):
            self.refused(self.server.get(path + "/deviation.glb?max_triangles=" + value), 400, "malformed-request")

    def test_what_is_not_there(self):
        for name in KINDS:
            self.refused(self.server.get("/v1/comparisons/%s/deviation.%s" % ("0" * 32, name)), 404, "not-found")
            self.refused(self.server.send("DELETE", "/v1/comparisons/%s/deviation.%s" % ("0" * 32, name)), 405, "method-not-allowed")
        self.refused(self.server.get("/v1/comparisons/%s/deviation.obj" % ("0" * 32)), 404, "not-found")

    def test_what_has_not_ended_or_failed(self):
        failed = self.server.compare(a=b"v 0 0 nan\n").headers["x-request-id"]
        running = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        for name in KINDS:
            problem = self.refused(self.server.get("%s/deviation.%s" % (running, name)), 409, "no-interval")
            self.assertIn("has not ended", problem["detail"])
            problem = self.refused(self.server.get("/v1/comparisons/%s/deviation.%s" % (failed, name)), 409, "no-interval")
            self.assertIn("without an interval", problem["detail"])
        self.server.send("DELETE", running)

    def test_a_mesh_that_is_not_kept_is_named_and_may_be_sent_again(self):
        a, b = (mesh + b"# not stored by others\n" for mesh in (SQUARE, RAISED))
        path = "/v1/comparisons/" + self.server.compare(a=a, b=b).headers["x-request-id"]
        for name in KINDS:
            for method in ("GET", "HEAD"):
                self.assertEqual(self.server.get("%s/deviation.%s" % (path, name), method).status, 410)
            problem = self.refused(self.server.get("%s/deviation.%s" % (path, name)), 410, "mesh-gone")
            self.assertEqual(problem["errors"][0]["part"], "a")
        for mesh in (a, b):
            where = re.search("PUT (/v1/meshes/[0-9a-f]{64})", self.server.get(path + "/deviation.ply").json()["detail"])[1]
            self.assertEqual(where, "/v1/meshes/" + hashlib.sha256(mesh).hexdigest())
            self.assertEqual(self.server.send("PUT", where, mesh).status, 201)
        self.assertEqual(ply_of(self.server.get(path + "/deviation.ply").body)[1], [2] * 4)

    def test_what_came_with_a_durable_comparison_goes_with_its_end(self):
        path = self.server.compare(a=WAVY, b=SQUARE, extra="Prefer: wait=60\r\n").headers["location"]
        until(lambda: self.server.get(path + "/deviation.glb", "HEAD").status == 410)  # soon after
        self.refused(self.server.get(path + "/deviation.glb"), 410, "mesh-gone")

    def test_a_full_queue(self):
        path, _ = compared(self.server)
        with self.server.connect() as one, self.server.connect() as other:
            for connection in (one, other):
                connection.sendall(b"POST /v1/comparisons HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n"
                                   b"Content-Type: application/json\r\n\r\n")
            until(lambda: self.server.get("/readyz").status == 503)
            for name in KINDS:
                answer = self.server.get("%s/deviation.%s?of=b" % (path, name))
                self.refused(answer, 503, "overloaded")
                self.assertIn("retry-after", answer.headers)
        until(lambda: self.server.get("/readyz").status == 200)
        self.assertEqual(self.server.get(path + "/deviation.ply?of=b").status, 200)

    def test_out_of_time(self):
        """The time is that of the comparison, and runs while the map waits for a worker."""
        path, _ = compared(self.server, options={"timeout_ms": 2000})
        running = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        until(lambda: self.server.get(running).json()["state"] == "running")
        with occupy_guests(self.server, 2):
            problem = self.refused(self.server.get(path + "/deviation.glb"), 503, "out-of-time")
        self.server.send("DELETE", running)
        self.assertRegex(problem["detail"], "no worker made the map within 2000 ms|timed out before")


if __name__ == "__main__":
    unittest.main()
