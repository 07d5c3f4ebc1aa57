"""The service on disks that are full or read-only: what it refuses, what it still does, and that it recovers by itself.

A real small disk where this process may mount one; and everywhere a disk that fails by order (failing_disk.cpp), since
one that is in use cannot be made read-only from outside.
"""

import contextlib
import ctypes
import errno
import hashlib
import http.client
import json
import mmap
import os
import re
import signal
import struct
import tempfile
import threading
import unittest
from pathlib import Path

import victim
from victim import ASYNC, ENDLESS, FORM, JSON, Victim, ask, multipart, square, until

SHIM = os.environ.get("MESHGAUGE_FAILING_DISK_LIBRARY", str(victim.ROOT / "build/tests/chaos/libfailing_disk.so"))
MS_REC, MS_PRIVATE, CLONE_NEWNS, MNT_DETACH = 0x4000, 1 << 18, 0x20000, 2
DISK_BYTES = 16 << 20

libc = ctypes.CDLL(None, use_errno=True)


def in_own_mounts():
    """Whether this process may mount, for itself alone."""
    if os.geteuid() != 0 or libc.unshare(CLONE_NEWNS) != 0:
        return False
    return libc.mount(None, b"/", None, ctypes.c_ulong(MS_REC | MS_PRIVATE), None) == 0


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="meshgauge-disk-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.disk, self.elsewhere = self.folder / "disk", self.folder / "elsewhere"
        self.disk.mkdir()
        self.elsewhere.mkdir()

    def serve(self, temp_dir, *flags):
        server = Victim("--data-dir", str(self.disk / "data"), "--temp-dir", str(temp_dir), "--workers", "2", *flags)
        self.addCleanup(lambda: server.process.poll() is None and server.kill())
        self.port = server.port
        return server

    def ask(self, method, path, body=None, headers=None):
        return ask(self.port, method, path, body, headers)

    def compare(self, distance=2, n=1, **headers):
        body = multipart(square(0, n, os.urandom(8).hex()), square(distance, n), {})
        return self.ask("POST", "/v1/comparisons", body, {**FORM, **headers})

    def measured(self, answer, distance=2):
        """Checks the interval; returns the comparison's path."""
        self.assertEqual(answer.status, 200, answer.body)
        interval = answer.json()["distance"]
        self.assertLessEqual(interval["lower"], distance)
        self.assertGreaterEqual(interval["upper"], distance)
        return "/v1/comparisons/" + answer.json()["id"]

    def refused(self, answer, status, slug):
        self.assertEqual((answer.status, answer.problem), (status, slug), answer.body)
        self.assertNotIn(bytes(self.folder), answer.body)
        self.assertEqual(answer.headers["content-type"], "application/problem+json")

    def store(self, mesh):
        return self.ask("PUT", "/v1/meshes/" + hashlib.sha256(mesh).hexdigest(), mesh)

    def by_id(self, a, b, headers=()):
        ids = {name: hashlib.sha256(mesh).hexdigest() for name, mesh in (("a", a), ("b", b))}
        return self.ask("POST", "/v1/comparisons", json.dumps(ids).encode(), {**JSON, **dict(headers)})

    def state(self, path):
        return self.ask("GET", path).json()["state"]

    def begin(self, milliseconds):
        """Begins a job that runs for so long; returns its path."""
        body = multipart(square(1, 20), square(1, 23), {**ENDLESS, "timeout_ms": milliseconds})
        answer = self.ask("POST", "/v1/comparisons", body, {**FORM, **ASYNC})
        self.assertEqual(answer.status, 202, answer.body)
        path = answer.headers["location"]
        until(lambda: self.state(path) == "running")
        return path

    def what_is_wrong(self):
        """The parts that readiness reports; it looks at the disks once a second."""
        answer = self.ask("GET", "/readyz")
        if answer.status == 200:
            return set()
        self.refused(answer, 503, "not-ready")
        self.assertIn("retry-after", answer.headers)
        return {item["part"] for item in answer.json()["errors"]}

    def all_is_well(self):
        until(lambda: self.what_is_wrong() == set())
        self.assertIn(self.store(square(9, 1, "afterwards")).status, (200, 201))
        answer = self.compare(**{"Prefer": "respond-async"})
        self.assertEqual(answer.status, 202, answer.body)
        until(lambda: self.state(answer.headers["location"]) == "done")


class Recovery(Case):
    def blob_of(self, mesh):
        return next((self.disk / "data/blobs").glob("*/*/" + hashlib.sha256(mesh).hexdigest()))

    def test_a_blob_that_is_cut_off_while_it_is_compared(self):
        """Other comparisons go on, and the mesh is well again when it is stored again."""
        server = self.serve(self.elsewhere, "--max-cache-bytes", "0")
        a, b = square(0, 200), square(3, 200)
        self.assertEqual([self.store(mesh).status for mesh in (a, b)], [201, 201])
        whole, seen = self.blob_of(a).stat().st_size, set()
        with open(self.blob_of(a), "r+b") as blob:
            for left in [whole // 100 * part for part in range(0, 100, 5)]:
                cut = threading.Thread(target=blob.truncate, args=(left,))
                cut.start()
                answer = self.by_id(a, b)
                cut.join()
                seen.add(answer.status)
                if answer.status != 200:
                    self.assertEqual((answer.status, answer.problem), (500, "internal"), answer.body)
                    self.assertIn("damaged", answer.json()["detail"])
        self.assertIn(500, seen)
        self.measured(self.compare())
        self.assertEqual(self.store(a).status, 200)
        self.measured(self.by_id(a, b), 3)
        server.stop()

    def test_a_database_that_was_lost(self):
        """The meshes stay for a day: the database may be found again."""
        server = self.serve(self.elsewhere)
        meshes = [square(number) for number in range(5)]
        self.assertEqual({self.store(mesh).status for mesh in meshes}, {201})
        server.stop()
        for name in ("jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm"):
            (self.disk / "data" / name).replace(self.elsewhere / name) if (self.disk / "data" / name).exists() else None
        for mesh in meshes:
            os.utime(self.blob_of(mesh), (1, 1))
        server = self.serve(self.elsewhere)
        until(lambda: any("5 stored files are unknown to the database" in line for line in server.log))
        self.assertEqual({self.blob_of(mesh).exists() for mesh in meshes}, {True})
        server.stop()
        (self.elsewhere / "jobs.sqlite").replace(self.disk / "data/jobs.sqlite")
        server = self.serve(self.elsewhere)
        self.measured(self.by_id(meshes[0], meshes[4]), 4)
        server.stop()

    def database(self, end=""):
        return self.disk / ("data/jobs.sqlite" + end)

    def check_takes_nothing(self, server, times):
        """No job is promised that the next start would not find; the log says where, and clients are not told."""
        until(lambda: self.what_is_wrong() == {"store"})
        self.refused(self.compare(Prefer="respond-async"), 503, "storage-unavailable")
        self.refused(self.compare(**{"Idempotency-Key": "lost"}), 503, "storage-unavailable")
        self.measured(self.compare())
        def told():
            return [line for line in server.log if '"readiness"' in line and "store: " in line and "well again" not in line]
        until(lambda: len(told()) >= times)
        self.assertEqual(len(told()), times)
        self.assertIn(str(self.disk), told()[-1])

    def test_a_database_whose_files_are_taken_away(self):
        server = self.serve(self.elsewhere, "--log-requests", "none")
        for number, end in enumerate(("", "-wal", "-shm")):
            self.all_is_well()
            self.database(end).rename(self.disk / "away")
            self.check_takes_nothing(server, number + 1)
            (self.disk / "away").rename(self.database(end))
        self.all_is_well()
        kept = self.measured(self.compare(**{"Idempotency-Key": "kept"}))
        self.database().rename(self.disk / "away")
        self.database().write_bytes((self.disk / "away").read_bytes())  # as one that is restored under a running service
        self.check_takes_nothing(server, 4)
        (self.disk / "away").rename(self.database())
        self.all_is_well()
        server.stop()
        server = self.serve(self.elsewhere)
        self.assertEqual(self.state(kept), "done")
        server.stop()

    def test_a_database_that_is_overwritten(self):
        self.serve(self.elsewhere).stop()  # now its file has what its log had
        server = self.serve(self.elsewhere, "--log-requests", "none")
        self.all_is_well()
        with open(self.database(), "r+b") as file:
            file.write(os.urandom(self.database().stat().st_size))
        self.check_takes_nothing(server, 1)
        server.kill()
        with self.assertRaisesRegex(AssertionError, "is damaged"):
            self.serve(self.elsewhere)

    def test_a_log_that_is_not_read(self):
        server = self.serve(self.elsewhere)
        server.read_on.clear()
        dropped = lambda: float(re.search(rb"^meshgauge_log_lines_dropped_total (\S+)", self.ask("GET", "/metrics").body, re.M)[1])
        until(lambda: self.write_log() or dropped() > 0, 240)
        self.measured(self.compare())
        server.read_on.set()
        until(lambda: any("lines were dropped" in line for line in server.log))
        self.all_is_well()
        server.stop()

    def write_log(self, lines=500):
        """Requests of long lines, on one connection."""
        with contextlib.closing(http.client.HTTPConnection("127.0.0.1", self.port, timeout=victim.ANSWER_SECONDS)) as connection:
            for _ in range(lines):
                connection.request("GET", "/" + 250 * "x")
                connection.getresponse().read()


@unittest.skipUnless(in_own_mounts(), "this process may not mount a disk of its own")
class FullDisk(Case):
    def setUp(self):
        super().setUp()
        size = b"size=%d" % DISK_BYTES
        self.assertEqual(libc.mount(b"none", bytes(self.disk), b"tmpfs", ctypes.c_ulong(0), size), 0)
        self.addCleanup(lambda: libc.umount2(bytes(self.disk), MNT_DETACH))

    def fill(self):
        with open(self.disk / "ballast", "ab", buffering=0) as ballast:
            for size in (65536, 4096, 1):
                try:
                    while ballast.write(b"x" * size) == size:
                        pass
                except OSError as error:
                    self.assertEqual(error.errno, errno.ENOSPC)

    def make_room(self):
        (self.disk / "ballast").unlink()

    def test_full_and_with_room_again(self):
        server = self.serve(self.elsewhere)
        a, b = square(0), square(3)
        self.assertEqual([self.store(mesh).status for mesh in (a, b)], [201, 201])
        path = self.begin(1500)
        self.fill()
        self.refused(self.compare(Prefer="respond-async"), 507, "storage-full")
        self.refused(self.compare(**{"Idempotency-Key": "one"}), 507, "storage-full")
        self.refused(self.store(square(5, 100)), 507, "storage-full")
        self.measured(self.compare())
        self.measured(self.compare(n=100))  # its upload is a file, elsewhere
        self.measured(self.by_id(a, b), 3)
        self.assertEqual(self.ask("GET", "/v1/meshes/" + hashlib.sha256(a).hexdigest()).status, 200)
        until(lambda: self.what_is_wrong() & {"disk", "store"})
        self.assertEqual(self.ask("GET", "/healthz").status, 200)
        self.assertIn(self.state(path), ("running", "done"))
        self.make_room()
        until(lambda: self.state(path) == "done")
        self.assertEqual(list((self.disk / "data/blobs/incoming").iterdir()), [])
        self.assertEqual(self.compare(**{"Idempotency-Key": "one"}).status, 200)
        self.all_is_well()
        server.stop()

    def test_kept_maps_leave_room_for_uploads(self):
        server = self.serve(self.elsewhere)
        a, b = square(0, 60), square(3, 60)
        self.assertEqual([self.store(mesh).status for mesh in (a, b)], [201, 201])
        path, maps = self.measured(self.by_id(a, b), 3), self.disk / "data/maps"
        for of in "ab":
            self.assertEqual(self.ask("GET", path + "/deviation.ply?of=" + of).status, 200)
        self.assertGreater(sum(one.stat().st_size for one in maps.iterdir()), 400000)
        server.process.send_signal(signal.SIGSTOP)  # else what it gives back meanwhile is filled as well
        self.fill()
        server.process.send_signal(signal.SIGCONT)
        until(lambda: not list(maps.iterdir()))
        upload = square(5, 50)
        self.assertGreater(len(upload), 100000)
        self.assertEqual(self.store(upload).status, 201)
        self.assertEqual(self.ask("GET", path + "/deviation.ply").status, 200)  # made, and not kept
        self.assertEqual(list(maps.iterdir()), [])
        self.make_room()
        self.assertEqual(self.ask("GET", path + "/deviation.ply").status, 200)
        self.assertEqual(len(list(maps.iterdir())), 1)
        self.all_is_well()
        server.stop()

    def test_uploads_on_the_same_full_disk(self):
        server = self.serve(self.disk)
        self.fill()
        self.measured(self.compare())  # it stays in memory
        self.refused(self.compare(n=100), 507, "storage-full")
        until(lambda: "disk" in self.what_is_wrong())
        self.make_room()
        self.measured(self.compare(n=100))
        self.all_is_well()
        server.stop()

    def fill_by_requests(self):
        """Stores meshes until there is no room; returns their paths."""
        paths = []
        for number in range(1000):
            for mesh in (square(number, 60), square(number)):
                answer = self.store(mesh)
                if answer.status == 201:
                    paths.append("/v1/meshes/" + hashlib.sha256(mesh).hexdigest())
            if answer.status != 201:
                self.refused(answer, 507, "storage-full")
                return paths
        raise AssertionError("the disk is never full")

    def test_what_filled_the_disk_can_be_deleted(self):
        server = self.serve(self.elsewhere)
        path = self.begin(100000)
        paths = self.fill_by_requests()
        self.fill()  # to the last byte
        self.assertEqual(self.ask("DELETE", path).status, 200)
        for path in paths:
            self.assertEqual(self.ask("DELETE", path).status, 204)
        self.assertEqual(list((self.disk / "data/blobs").glob("*/*/*" + paths[0][-8:])), [])
        self.all_is_well()
        server.stop()

    def test_deletions_leave_their_room_to_deletions(self):
        """With every byte taken again after each deletion, the last one works like the first."""
        server = self.serve(self.elsewhere)
        paths = [self.measured(self.compare(**{"Idempotency-Key": str(number)})) for number in range(40)]
        self.fill()
        for path in paths:
            self.assertEqual(self.ask("DELETE", path).status, 204)
            server.process.send_signal(signal.SIGSTOP)
            self.fill()
            server.process.send_signal(signal.SIGCONT)
        self.refused(self.compare(Prefer="respond-async"), 507, "storage-full")
        self.make_room()
        self.all_is_well()
        server.stop()

    def test_sweeps_on_a_full_disk(self):
        server = self.serve(self.elsewhere, "--mesh-ttl-s", "1", "--result-ttl-s", "1")
        a = square(0, 60)
        self.assertEqual(self.store(a).status, 201)
        path = self.measured(self.compare(**{"Idempotency-Key": "one"}))
        self.fill()
        until(lambda: self.ask("GET", "/v1/meshes/" + hashlib.sha256(a).hexdigest()).status == 404, 100)
        until(lambda: self.ask("GET", path).status == 404, 100)
        until(lambda: not list((self.disk / "data/blobs").glob("*/*/" + hashlib.sha256(a).hexdigest())))
        self.make_room()
        server.stop()

    def test_killed_and_started_on_a_full_disk(self):
        server = self.serve(self.elsewhere)
        path = self.begin(100000)
        self.fill()
        server.kill()
        try:
            server = self.serve(self.elsewhere)
            server.kill()
        except AssertionError as error:  # it says why, and a supervisor tries again
            self.assertIn("does not start", str(error))
            self.assertRegex(str(error), "room|No space")
        self.make_room()
        server = self.serve(self.elsewhere)
        until(lambda: self.state(path) == "running")
        self.assertEqual(self.ask("DELETE", path).status, 200)
        self.all_is_well()
        server.stop()


@unittest.skipIf(os.environ.get("MESHGAUGE_SANITIZED"), "a sanitizer comes before every other library")
class DiskThatFails(Case):
    def setUp(self):
        super().setUp()
        orders = self.folder / "orders"
        orders.write_bytes(bytes(12))
        with open(orders, "r+b") as file:
            self.orders = mmap.mmap(file.fileno(), 12)
        self.addCleanup(self.orders.close)
        victim.ENVIRONMENT.update(LD_PRELOAD=SHIM, MESHGAUGE_FAILING_DISK="%s:%s" % (self.disk, orders))
        self.addCleanup(lambda: [victim.ENVIRONMENT.pop(name) for name in ("LD_PRELOAD", "MESHGAUGE_FAILING_DISK")])

    def fail(self, server, number, clock_is_wrong_by=0):
        self.orders[:] = struct.pack("iii", server.process.pid, number, clock_is_wrong_by)

    def check_trouble(self, number, status, slug):
        server = self.serve(self.elsewhere)
        a, b = square(0), square(3)
        self.assertEqual([self.store(mesh).status for mesh in (a, b)], [201, 201])
        path = self.begin(1500)
        self.fail(server, number)
        until(lambda: self.what_is_wrong() == {"disk", "store"})
        for answer in (self.compare(Prefer="respond-async"), self.compare(Prefer="wait=5"), self.by_id(a, b, ASYNC.items()),
                       self.store(square(5, 100)), self.ask("DELETE", "/v1/meshes/" + hashlib.sha256(a).hexdigest())):
            self.refused(answer, status, slug)
        self.measured(self.compare())
        self.measured(self.compare(n=100))
        other = self.measured(self.by_id(a, b), 3)
        self.assertEqual(self.state(other), "done")
        self.assertEqual(self.ask("GET", "/healthz").status, 200)
        until(lambda: any("wait for the store" in line for line in server.log))  # its end cannot be stored
        self.assertEqual(self.state(path), "running")
        self.fail(server, 0)
        until(lambda: self.state(path) == "done")
        self.all_is_well()
        self.assertLess(sum('"store"' in line for line in server.log), 40)
        server.stop()
        server = self.serve(self.elsewhere)  # and all of it is durable
        self.assertEqual([self.state(one) for one in (path, other)], ["done"] * 2)
        server.stop()

    def test_read_only(self):
        self.check_trouble(errno.EROFS, 503, "storage-unavailable")

    def test_errors_of_the_disk(self):
        self.check_trouble(errno.EIO, 503, "storage-unavailable")

    def test_full(self):
        self.check_trouble(errno.ENOSPC, 507, "storage-full")

    def test_a_clock_that_jumps_removes_nothing(self):
        server = self.serve(self.elsewhere)
        a = square(0)
        self.assertEqual(self.store(a).status, 201)
        path = self.measured(self.compare(**{"Idempotency-Key": "one"}))
        self.fail(server, 0, clock_is_wrong_by=100 * 24 * 3600)
        jumped = re.compile("the clock jumped by 86(40000|39999) s")  # cut off to whole seconds
        until(lambda: any(jumped.search(line) for line in server.log))
        self.assertEqual(self.state(path), "done")
        self.assertEqual(self.ask("GET", "/v1/meshes/" + hashlib.sha256(a).hexdigest()).status, 200)
        self.fail(server, 0)
        until(lambda: any("the clock is right again" in line for line in server.log))
        self.measured(self.by_id(a, a), 0)
        self.all_is_well()
        server.stop()

    def test_ended_while_nothing_can_be_written(self):
        server = self.serve(self.elsewhere, "--grace-ms", "100")
        path = self.begin(100000)
        self.fail(server, errno.EROFS)
        server.stop()
        server = self.serve(self.elsewhere)
        until(lambda: self.state(path) == "running")
        server.kill()


if __name__ == "__main__":
    unittest.main()
