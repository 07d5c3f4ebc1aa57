"""Deviation maps: how they are kept, which keys get them, and how making one ends."""

import errno
import hashlib
import mmap
import os
import re
import struct
import tempfile
import threading
import unittest
from pathlib import Path

from harness import SLOW, SLOW_OPTIONS, Server, flat_grid, occupy_guests, read_answer, until, wavy_grid
from keys import bearer, new_key, write_keys
from maps import FLAT, KINDS, WAVY, compared

FAILING_DISK = os.environ.get("MESHGAUGE_FAILING_DISK_LIBRARY", "")


class Cached(unittest.TestCase):
    def start(self, *flags, workers=2, environment=None):
        server = Server("--workers", str(workers), *flags, environment=environment)
        self.addCleanup(server.stop)
        return server

    def folder(self, server):
        return Path(server.data_dir.name) / "data" / "maps"

    def value(self, server, sample):
        return float(re.search("^%s (.*)$" % re.escape(sample), server.get("/metrics").body.decode(), re.M)[1])

    def counted(self, server, outcome, count):
        """Waits until so many maps are counted, and checks that there are no more: an answer may come before its count."""
        sample = 'meshgauge_maps_total{outcome="%s"}' % outcome
        until(lambda: self.value(server, sample) >= count)
        self.assertEqual(self.value(server, sample), count)

    def test_the_second_time_it_is_there(self):
        server = self.start()
        path, _ = compared(server)
        first, second = (server.get(path + "/deviation.ply") for _ in range(2))
        self.assertRegex(first.headers["server-timing"], "^queue;dur=.*read;dur=.*measure;dur=.*write;dur=.*total;dur=")
        self.assertEqual(second.headers["server-timing"], "cached")
        self.assertEqual(first.body, second.body)
        self.assertEqual(len(list(self.folder(server).iterdir())), 1)
        for outcome, count in (("made", 1), ("cached", 1), ("failed", 0)):
            self.counted(server, outcome, count)
        self.assertEqual(self.value(server, 'meshgauge_map_seconds_count{format="ply"}'), 1)
        self.assertEqual(self.value(server, 'meshgauge_map_seconds_count{format="csv"}'), 0)
        self.assertEqual(self.value(server, "meshgauge_map_cache_bytes"), len(first.body))
        self.assertEqual(self.value(server, "meshgauge_map_cache_files"), 1)
        for other in ("ply?of=b", "glb", "glb?max_triangles=100", "glb?max_triangles=101"):
            self.assertIn("total", server.get("%s/deviation.%s" % (path, other)).headers["server-timing"])

    def test_heads_and_tags(self):
        server = self.start()
        path, _ = compared(server)
        for name in ("deviation.ply?of=b", "deviation.glb", "deviation.vtp", "deviation.csv"):
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
                for name in (*KINDS, "ply?of=b", "glb?of=b", "glb?max_triangles=7")}
        self.assertEqual(len(tags), 7)

    def test_a_connection_goes_on_after_a_map(self):
        server = self.start()
        path, _ = compared(server)
        with server.connect() as connection:
            stream = connection.makefile("rb")
            for request in ("GET %s/deviation.ply" % path, "HEAD %s/deviation.ply" % path, "GET /healthz",
                            "GET %s/deviation.glb" % path, "GET /healthz"):
                connection.sendall((request + " HTTP/1.1\r\nHost: localhost\r\n\r\n").encode())
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
        self.counted(server, "made", 1)

    def test_a_client_that_disconnects_ends_it(self):
        server = self.start(workers=1)
        path, _ = compared(server, options={"timeout_ms": 100000})
        running = server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        until(lambda: server.get(running).json()["state"] == "running")
        with occupy_guests(server, 2), server.connect() as connection:
            connection.sendall(("GET %s/deviation.ply HTTP/1.1\r\nHost: localhost\r\n\r\n" % path).encode())
            until(lambda: self.value(server, "meshgauge_queue_depth") == 1)
        until(lambda: self.value(server, "meshgauge_queue_depth") == 0)
        server.send("DELETE", running)
        self.counted(server, "made", 0)

    def test_an_end_of_the_service_is_an_answer(self):
        server = self.start("--grace-ms", "500", workers=1)
        # A map that is large enough to be interrupted: a small one may be made before it is noticed that the service ends.
        path, _ = compared(server, wavy_grid(150, 0.1), flat_grid(140), {"tolerance": {"relative": 1}, "timeout_ms": 100000})
        running = server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n").headers["location"]
        until(lambda: server.get(running).json()["state"] == "running")
        with occupy_guests(server, 2), server.connect() as connection:
            connection.sendall(("GET %s/deviation.ply HTTP/1.1\r\nHost: localhost\r\n\r\n" % path).encode())
            until(lambda: self.value(server, "meshgauge_queue_depth") == 1)
            server.process.terminate()
            answer = read_answer(connection.makefile("rb"))
        self.assertEqual((answer.status, answer.json()["type"]), (503, "/problems/shutting-down"))

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
                for name in KINDS:
                    for _ in range(2):
                        self.assertEqual(server.get("%s/deviation.%s" % (path, name)).status, status)
                shared[:] = bytes(8)
                self.assertEqual(server.get(path + "/deviation.ply").status, 200)
                server.stop()


class Slow(unittest.TestCase):
    """Clients that do not read the map that they requested."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server("--workers", "2")
        cls.addClassCleanup(cls.server.stop)
        cls.path = compared(cls.server, wavy_grid(500, 0.1), FLAT, {"tolerance": {"relative": 1}})[0] + "/deviation.ply"
        cls.whole = cls.server.get(cls.path).body  # more than sockets take by themselves
        assert len(cls.whole) > 10 << 20

    def ask(self, source=""):
        connection = self.server.connect(source=source)
        self.addCleanup(connection.close)
        connection.sendall(("GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n" % self.path).encode())
        return connection

    def test_they_do_not_keep_others_from_being_served_and_no_answer_breaks_off(self):
        stalled = [self.ask() for _ in range(60)] + [self.ask("127.0.0.%d" % (2 + i % 2)) for i in range(20)]
        until(lambda: sum('"status":503' in line for line in list(self.server.log)) > 4)
        self.assertEqual(self.server.get("/healthz").status, 200)
        statuses = []
        for connection in stalled:
            answer = read_answer(connection.makefile("rb"))
            statuses.append(answer.status)
            if answer.status == 200:
                self.assertEqual(len(answer.body), len(self.whole))
            else:
                self.assertEqual((answer.status, answer.json()["type"]), (503, "/problems/overloaded"))
                self.assertIn("retry-after", answer.headers)
        self.assertGreater(statuses.count(200), 4)
        self.assertGreater(statuses.count(503), 4)
        self.assertEqual(self.server.get(self.path).body, self.whole)

    def test_a_client_that_never_reads_a_map(self):
        before = len(self.server.log)
        connection = self.ask()
        until(lambda: any('"delivered":false' in line for line in self.server.log[before:]))
        taken = 0
        while piece := connection.recv(1 << 20):
            taken += len(piece)
        self.assertTrue(0 < taken < len(self.whole))


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
            self.assertEqual((answer.status, answer.json()["type"]), (429, "/problems/too-many-requests"))
            self.assertEqual(server.get(path + "/deviation.ply", extra=bearer(one)).status, 200)  # it is there already
            server.send("DELETE", slow.headers["location"], extra=bearer(one))


if __name__ == "__main__":
    unittest.main()
