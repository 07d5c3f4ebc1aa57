"""Deviation maps of comparisons: what is in them, who gets them, and what is kept of them."""

import errno
import hashlib
import json
import mmap
import os
import re
import struct
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

from harness import (BINARY, ENVIRONMENT, RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, flat_grid, read_answer,
                     until, wavy_grid)
from keys import bearer, new_key, write_keys

FAILING_DISK = os.environ.get("MESHGAUGE_FAILING_DISK_LIBRARY", "")
WAVY, FLAT = wavy_grid(60, 0.1), flat_grid(50)  # 7200 and 5000 triangles
GATE = {"gate": {"max_distance": 0.05, "units": "mm"}, "tolerance": {"diagonal": 1e-9}, "threads": 1}


def store(server, mesh, extra=""):
    answer = server.send("POST", "/v1/meshes", mesh, extra)
    assert answer.status in (200, 201), answer.body
    return answer.json()["id"]


def compared(server, a=WAVY, b=FLAT, options=None, extra=""):
    """The path of a comparison of stored meshes, and its result."""
    body = json.dumps({"a": store(server, a, extra), "b": store(server, b, extra), "options": options or GATE}).encode()
    answer = server.send("POST", "/v1/comparisons", body, extra + "Content-Type: application/json\r\n")
    assert answer.status == 200, answer.body
    return "/v1/comparisons/" + answer.json()["id"], answer.json()


def ply_of(data):
    """Comments, and the distance of each vertex."""
    head, data = data.split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    count = next(int(line.split()[-1]) for line in lines if line.startswith("element vertex"))
    faces = next(int(line.split()[-1]) for line in lines if line.startswith("element face"))
    size = 3 * (8 if "property double x" in lines else 4) + 3 + 4 + 8
    assert len(data) == count * size + faces * 13
    distances = [struct.unpack_from("<d", data, (v + 1) * size - 8)[0] for v in range(count)]
    return [line.removeprefix("comment ") for line in lines if line.startswith("comment ")], distances, faces


class Glb:
    def __init__(self, data):
        magic, version, length, size = struct.unpack_from("<4sIII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        self.document = json.loads(data[20:20 + size])
        self.bytes = data[28 + size:]
        self.node = self.document["nodes"][0]
        self.extras = self.node["extras"]
        self.primitive = self.document["meshes"][self.node["mesh"]]["primitives"][0]

    def accessor(self, name):
        at = self.primitive["indices"] if name == "indices" else self.primitive["attributes"][name]
        return self.document["accessors"][at]

    def numbers(self, name, code, width):
        accessor = self.accessor(name)
        view = self.document["bufferViews"][accessor["bufferView"]]
        found = struct.unpack_from("<%d%s" % (accessor["count"] * width, code), self.bytes, view.get("byteOffset", 0))
        return [found[i:i + width] for i in range(0, len(found), width)]

    @property
    def triangles(self):
        return self.accessor("indices")["count"] // 3


def positions_of(obj):
    return [tuple(map(float, line.split()[1:4])) for line in obj.decode().splitlines() if line.startswith("v ")]


def as_floats(point):
    return struct.unpack("<fff", struct.pack("<fff", *point))


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

    def written_by_check(self, suffix):
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / name for name in ("a.obj", "b.obj", "map" + suffix)]
            files[0].write_bytes(WAVY)
            files[1].write_bytes(FLAT)
            done = subprocess.run([BINARY, "check", *map(str, files[:2]), "--max-distance", "0.05 mm", "--threads", "1",
                                   "--deviation", str(files[2])], env=ENVIRONMENT, capture_output=True, timeout=60)
            self.assertEqual(done.returncode, 1, done.stderr)  # the gate fails
            return files[2].read_bytes()

    def test_the_files_are_those_of_check(self):
        for suffix, media_type in ((".ply", "model/ply"), (".glb", "model/gltf-binary")):
            answer = self.map(suffix[1:])
            self.assertEqual(answer.headers["content-type"], media_type)
            self.assertEqual(answer.body, self.written_by_check(suffix), suffix)

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
        self.assertEqual(extras["display"], {"form": "as_is", "triangles": 7200, "vertices": 3721})
        self.assertEqual(glb.triangles, 7200)

    def test_the_other_mesh(self):
        _, distances, faces = ply_of(self.map("ply?of=b").body)
        self.assertEqual((len(distances), faces), (51 * 51, 5000))
        extras = Glb(self.map("glb?of=b").body).extras
        self.assertEqual(extras["display"]["vertices"], 51 * 51)
        witness = self.result["b_to_a"]["witness"]
        self.assertEqual((extras["direction"]["witness"]["from"], extras["direction"]["witness"]["from_candidate"]),
                         (witness["point_a"], True))
        self.assertFalse(extras["witness"]["from_candidate"])  # the distance is attained on the other mesh
        self.assertLessEqual(max(distances), self.result["b_to_a"]["upper"])

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
        for most in (1, 2, 50, 1000, 5000):
            glb = Glb(self.map("glb?max_triangles=%d" % most, path).body)
            self.assertEqual(glb.extras["display"], {"form": "decimated", "triangles": 7200, "vertices": 3721})
            self.assertTrue(1 <= glb.triangles <= most)
            if most >= 1000:
                self.assertGreaterEqual(glb.triangles, 0.6 * most)
                shown = [d for d, in glb.numbers("_DISTANCE", "f", 1)]
                self.assertEqual(max(shown), struct.unpack("<f", struct.pack("<f", max(distances)))[0])
            self.assertNotIn("translation", glb.node)
            for point, (distance,) in zip(glb.numbers("POSITION", "f", 3), glb.numbers("_DISTANCE", "f", 1)):
                self.assertIn((point, distance), known)

    def test_what_a_float_cannot_hold(self):
        path, _ = compared(self.server, SQUARE.replace(b"v 1 1 0", b"v 1e39 1 0"), SQUARE, {})
        self.assertIn("write a .ply", self.refused(self.server.get(path + "/deviation.glb"), 413, "too-large")["detail"])
        self.map("ply", path)

    def test_names_of_files_decide_the_format_again(self):
        a = store(self.server, SQUARE, 'Content-Disposition: attachment; filename="a.obj"\r\n')
        body = json.dumps({"a": a, "b": a}).encode()
        answer = self.server.send("POST", "/v1/comparisons", body, "Content-Type: application/json\r\n")
        _, distances, _ = ply_of(self.map("ply", "/v1/comparisons/" + answer.json()["id"]).body)
        self.assertEqual(distances, [0] * 4)


class Refusals(ServerCase):
    flags = ("--workers", "1", "--queue", "1")

    def test_wrong_queries_are_refused_in_words(self):
        path, _ = compared(self.server)
        for query, words in (("x=1", "unknown query parameter 'x'; known: of"), ("of=c", "'of' must be a or b, not 'c'"),
                             ("of", "must be a or b, not ''"), ("of=a&of=a", "'of' stands there twice"), ("&", "unknown"),
                             ("max_triangles=5", "'max_triangles' is for .glb"), ("of=%61", "must be a or b")):
            self.assertIn(words, self.refused(self.server.get(path + "/deviation.ply?" + query), 400, "malformed-request")["detail"])
        for value in ("0", "-1", "1.5", "1e3", "", "+1", "0x10", "1073741825", "9" * 40, "1&max_triangles=1"):
            self.refused(self.server.get(path + "/deviation.glb?max_triangles=" + value), 400, "malformed-request")

    def test_what_is_not_there(self):
        for name in ("ply", "glb"):
            self.refused(self.server.get("/v1/comparisons/%s/deviation.%s" % ("0" * 32, name)), 404, "not-found")
            self.refused(self.server.send("DELETE", "/v1/comparisons/%s/deviation.%s" % ("0" * 32, name)), 405, "method-not-allowed")
        self.refused(self.server.get("/v1/comparisons/%s/deviation.obj" % ("0" * 32)), 404, "not-found")

    def test_what_has_not_ended_or_failed(self):
        running = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        failed = self.server.compare(a=b"v 0 0 nan\n").headers["x-request-id"]
        for name in ("ply", "glb"):
            problem = self.refused(self.server.get("%s/deviation.%s" % (running, name)), 409, "no-interval")
            self.assertIn("has not ended", problem["detail"])
            problem = self.refused(self.server.get("/v1/comparisons/%s/deviation.%s" % (failed, name)), 409, "no-interval")
            self.assertIn("without an interval", problem["detail"])
        self.server.send("DELETE", running)

    def test_a_mesh_that_is_not_kept_is_named_and_may_be_sent_again(self):
        a = SQUARE + b"# not stored by others\n"
        path = "/v1/comparisons/" + self.server.compare(a=a).headers["x-request-id"]
        for name in ("ply", "glb"):
            for method in ("GET", "HEAD"):
                self.assertEqual(self.server.get("%s/deviation.%s" % (path, name), method).status, 410)
            problem = self.refused(self.server.get("%s/deviation.%s" % (path, name)), 410, "mesh-gone")
            self.assertEqual(problem["errors"][0]["part"], "a")
        for mesh in (a, RAISED):
            where = re.search("PUT (/v1/meshes/[0-9a-f]{64})", self.server.get(path + "/deviation.ply").json()["detail"])[1]
            self.assertEqual(where, "/v1/meshes/" + hashlib.sha256(mesh).hexdigest())
            self.assertEqual(self.server.send("PUT", where, mesh).status, 201)
        self.assertEqual(ply_of(self.server.get(path + "/deviation.ply").body)[1], [2] * 4)

    def test_what_came_with_a_durable_comparison_is_there(self):
        answer = self.server.compare(a=WAVY, b=SQUARE, extra="Prefer: wait=60\r\n")
        self.assertEqual(self.server.get(answer.headers["location"] + "/deviation.glb").status, 200)

    def test_a_full_queue(self):
        path, _ = compared(self.server)
        with self.server.connect() as one, self.server.connect() as other:
            for connection in (one, other):
                connection.sendall(b"POST /v1/comparisons HTTP/1.1\r\nHost: t\r\nContent-Length: 9\r\n"
                                   b"Content-Type: application/json\r\n\r\n")
            until(lambda: self.server.get("/readyz").status == 503)
            for name in ("ply?of=b", "glb?of=b"):
                answer = self.server.get("%s/deviation.%s" % (path, name))
                self.refused(answer, 503, "overloaded")
                self.assertIn("retry-after", answer.headers)
        until(lambda: self.server.get("/readyz").status == 200)
        self.assertEqual(self.server.get(path + "/deviation.ply?of=b").status, 200)

    def test_out_of_time(self):
        """The time is that of the comparison, and runs while the map waits for a worker."""
        path, _ = compared(self.server, options={"timeout_ms": 2000})
        running = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        until(lambda: self.server.get(running).json()["state"] == "running")
        threading.Timer(2.5, lambda: self.server.send("DELETE", running)).start()
        problem = self.refused(self.server.get(path + "/deviation.glb"), 503, "out-of-time")
        self.assertIn("the time was over before", problem["detail"])


class Cached(unittest.TestCase):
    def start(self, *flags, environment=None):
        server = Server("--workers", "2", *flags, environment=environment)
        self.addCleanup(server.stop)
        return server

    def folder(self, server):
        return Path(server.data_dir.name) / "data" / "maps"

    def value(self, server, sample):
        return float(re.search("^%s (.*)$" % re.escape(sample), server.get("/metrics").body.decode(), re.M)[1])

    def test_the_second_time_it_is_there(self):
        server = self.start()
        path, _ = compared(server)
        first, second = (server.get(path + "/deviation.ply") for _ in range(2))
        self.assertRegex(first.headers["server-timing"], "^queue;dur=.*read;dur=.*measure;dur=.*write;dur=.*total;dur=")
        self.assertEqual(second.headers["server-timing"], "cached")
        self.assertEqual(first.body, second.body)
        self.assertEqual(len(list(self.folder(server).iterdir())), 1)
        for outcome, count in (("made", 1), ("cached", 1), ("failed", 0)):
            self.assertEqual(self.value(server, 'meshgauge_maps_total{outcome="%s"}' % outcome), count)
        self.assertEqual(self.value(server, 'meshgauge_map_seconds_count{format="ply"}'), 1)
        self.assertEqual(self.value(server, "meshgauge_map_cache_bytes"), len(first.body))
        self.assertEqual(self.value(server, "meshgauge_map_cache_files"), 1)
        for other in ("ply?of=b", "glb", "glb?max_triangles=100", "glb?max_triangles=101"):
            self.assertIn("total", server.get("%s/deviation.%s" % (path, other)).headers["server-timing"])

    def test_heads_and_tags(self):
        server = self.start()
        path, _ = compared(server)
        for name in ("deviation.ply?of=b", "deviation.glb"):
            where = path + "/" + name
            early = server.get(where, "HEAD")
            self.assertNotIn("content-length", early.headers)
            whole = server.get(where)
            late = server.get(where, "HEAD")
            self.assertEqual(late.headers["content-length"], str(len(whole.body)))
            self.assertEqual({answer.headers["etag"] for answer in (early, whole, late)}, {whole.headers["etag"]})
            self.assertEqual(whole.headers["cache-control"], "private, no-cache")
            self.assertRegex(whole.headers["content-disposition"], 'filename="deviation-%s-' % ("b" if "ply" in name else "a"))
            for tags in ("%s", 'W/%s', '"other", %s', "*"):
                extra = "If-None-Match: %s\r\n" % (tags.replace("%s", whole.headers["etag"]))
                answer = server.get(where, extra=extra)
                self.assertEqual((answer.status, answer.body, answer.headers["etag"]), (304, b"", whole.headers["etag"]))
                self.assertEqual(server.get(where, "HEAD", extra).status, 304)
            self.assertEqual(server.get(where, extra='If-None-Match: "other"\r\n').status, 200)
        tags = {server.get(path + "/deviation." + name, "HEAD").headers["etag"]
                for name in ("ply", "ply?of=b", "glb", "glb?of=b", "glb?max_triangles=7")}
        self.assertEqual(len(tags), 5)

    def test_a_connection_goes_on_after_a_map(self):
        server = self.start()
        path, _ = compared(server)
        with server.connect() as connection:
            stream = connection.makefile("rb")
            for request in ("GET %s/deviation.ply" % path, "HEAD %s/deviation.ply" % path, "GET /healthz",
                            "GET %s/deviation.glb" % path, "GET /healthz"):
                connection.sendall((request + " HTTP/1.1\r\nHost: t\r\n\r\n").encode())
                answer = read_answer(stream)
                self.assertEqual(answer.status, 200)
                self.assertNotIn("connection", answer.headers)

    def test_what_is_forgotten_is_gone(self):
        server = self.start()
        path, _ = compared(server)
        server.get(path + "/deviation.ply")
        server.get(path + "/deviation.glb")
        self.assertEqual(len(list(self.folder(server).iterdir())), 2)
        self.assertEqual(server.send("DELETE", path).status, 204)
        self.assertEqual(list(self.folder(server).iterdir()), [])
        self.assertEqual(server.get(path + "/deviation.ply").status, 404)
        path, _ = compared(server)
        server.get(path + "/deviation.ply")
        server.send("DELETE", "/v1/meshes/" + hashlib.sha256(WAVY).hexdigest())
        self.assertEqual(list(self.folder(server).iterdir()), [])

    def test_a_restart_begins_with_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            server = self.start("--data-dir", folder)
            path, _ = compared(server)
            whole = server.get(path + "/deviation.glb")
            (Path(folder) / "maps" / "left.part").write_bytes(b"x")
            self.assertEqual(server.stop(), 0)
            server = self.start("--data-dir", folder)
            self.assertEqual(list((Path(folder) / "maps").iterdir()), [])
            again = server.get(path + "/deviation.glb")
            self.assertIn("total", again.headers["server-timing"])
            self.assertEqual((again.body, again.headers["etag"]), (whole.body, whole.headers["etag"]))
            server.stop()

    def test_a_budget_and_none(self):
        server = self.start("--map-cache-bytes", "300000")
        path, _ = compared(server)  # a.ply has 240,000 bytes, b.ply 170,000
        for name in ("ply", "ply?of=b", "ply"):
            self.assertIn("total", server.get("%s/deviation.%s" % (path, name)).headers["server-timing"])
        self.assertLessEqual(self.value(server, "meshgauge_map_cache_bytes"), 300000)
        for limit in ("0", "1000"):
            server = self.start("--map-cache-bytes", limit)
            path, _ = compared(server)
            first, second = (server.get(path + "/deviation.ply") for _ in range(2))
            self.assertIn("total", second.headers["server-timing"])
            self.assertEqual(first.body, second.body)
            self.assertEqual(self.folder(server).exists() and list(self.folder(server).iterdir()), limit == "1000" and [])

    def test_many_at_once_are_made_once(self):
        server = self.start("--queue", "16")
        path, _ = compared(server, wavy_grid(150, 0.1), flat_grid(140), {"tolerance": {"relative": 1}})
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(server.get(path + "/deviation.ply"))) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({answer.status for answer in answers}, {200})
        self.assertEqual(len({answer.body for answer in answers}), 1)
        self.assertEqual(self.value(server, 'meshgauge_maps_total{outcome="made"}'), 1)

    def test_who_goes_away_ends_it(self):
        server = self.start("--workers", "1")
        path, _ = compared(server, options={"timeout_ms": 100000})
        running = server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        until(lambda: server.get(running).json()["state"] == "running")
        with server.connect() as connection:
            connection.sendall(("GET %s/deviation.ply HTTP/1.1\r\nHost: t\r\n\r\n" % path).encode())
            until(lambda: self.value(server, "meshgauge_queue_depth") == 1)
        until(lambda: self.value(server, "meshgauge_queue_depth") == 0)
        server.send("DELETE", running)
        self.assertEqual(self.value(server, 'meshgauge_maps_total{outcome="made"}'), 0)

    def test_an_end_of_the_service_is_told(self):
        server = self.start("--workers", "1", "--grace-ms", "500")
        path, _ = compared(server, options={"timeout_ms": 100000})
        running = server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        until(lambda: server.get(running).json()["state"] == "running")
        with server.connect() as connection:
            connection.sendall(("GET %s/deviation.ply HTTP/1.1\r\nHost: t\r\n\r\n" % path).encode())
            until(lambda: self.value(server, "meshgauge_queue_depth") == 1)
            server.process.terminate()
            answer = read_answer(connection.makefile("rb"))
        self.assertEqual((answer.status, answer.json()["type"]), (503, "urn:meshgauge:problem:shutting-down"))

    @unittest.skipUnless(FAILING_DISK and not os.environ.get("MESHGAUGE_SANITIZED"), "a sanitizer comes before every other library")
    def test_a_full_disk(self):
        with tempfile.TemporaryDirectory() as folder:
            orders, disk = Path(folder) / "orders", Path(folder) / "disk"
            orders.write_bytes(bytes(8))
            disk.mkdir()
            (disk / "temp").mkdir()
            with open(orders, "r+b") as file:
                shared = mmap.mmap(file.fileno(), 8)
            self.addCleanup(shared.close)
            for temp, status in ((folder, 200), (disk / "temp", 507)):
                server = self.start("--data-dir", str(disk / "data"), "--temp-dir", str(temp), environment={
                    "LD_PRELOAD": FAILING_DISK, "MESHGAUGE_FAILING_DISK": "%s:%s" % (disk, orders)})
                path, _ = compared(server)
                shared[:] = struct.pack("ii", server.process.pid, errno.ENOSPC)
                for name in ("ply", "glb"):
                    for _ in range(2):
                        self.assertEqual(server.get("%s/deviation.%s" % (path, name)).status, status)
                shared[:] = bytes(8)
                self.assertEqual(server.get(path + "/deviation.ply").status, 200)
                server.stop()


class Owners(unittest.TestCase):
    def test_a_map_is_its_owners(self):
        with tempfile.TemporaryDirectory() as folder:
            (one, first), (other, second) = new_key("one", max_jobs=1), new_key("other")
            write_keys(Path(folder) / "keys.json", first, second)
            server = Server("--keys-file", folder + "/keys.json", "--workers", "1")
            self.addCleanup(server.stop)
            path, _ = compared(server, extra=bearer(one))
            answer = server.get(path + "/deviation.ply", extra=bearer(one))
            self.assertEqual(answer.status, 200)
            tag = "If-None-Match: %s\r\n" % answer.headers["etag"]
            self.assertEqual(server.get(path + "/deviation.ply", extra=bearer(one) + tag).status, 304)
            for extra in ("", tag):
                self.assertEqual(server.get(path + "/deviation.ply", extra=bearer(other) + extra).status, 404)
                self.assertEqual(server.get(path + "/deviation.ply", extra=extra).status, 401)
            slow = server.compare(**SLOW, options=SLOW_OPTIONS, extra=bearer(one) + "Prefer: respond-async\r\n")
            answer = server.get(path + "/deviation.glb", extra=bearer(one))
            self.assertEqual((answer.status, answer.json()["type"]), (429, "urn:meshgauge:problem:too-many-requests"))
            self.assertEqual(server.get(path + "/deviation.ply", extra=bearer(one)).status, 200)  # it is there already
            server.send("DELETE", slow.headers["location"], extra=bearer(one))


if __name__ == "__main__":
    unittest.main()
