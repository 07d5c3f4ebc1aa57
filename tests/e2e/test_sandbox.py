"""The processes in which the service reads uploads: what happens to them, and what that costs."""

import hashlib
import os
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

from harness import (
    BINARY, EVERYBODYS, OWN_DATA, RAISED, SQUARE, Server, comparison, post_head, read_answer, until, wavy_grid)

WITHOUT = os.environ.get("MESHGAUGE_WITHOUT")
READER = os.environ.get("MESHGAUGE_READER")
SANITIZED = os.environ.get("MESHGAUGE_SANITIZED") == "1"
NAMESPACES = os.geteuid() == 0 and subprocess.run(
    ["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True, check=False).returncode == 0
# Every file system read-only but for one in memory, $1; then $2 with the rest as its arguments, as the user nobody.
READ_ONLY = (
    "uploads=$1; shift\n"
    "awk '{print $5}' /proc/self/mountinfo | while read -r mount; do\n"
    "  case $mount in /proc*|/sys*|/dev*) ;; *) mount -o remount,bind,ro \"$mount\" ;; esac\n"
    "done\n"
    "mount -t tmpfs -o mode=1777,size=64m tmpfs \"$uploads\"\n"
    "exec setpriv --reuid 65534 --regid 65534 --clear-groups \"$@\"\n")


def processes():
    """{pid: (parent, state, start)} of the whole machine."""
    found = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/stat" % name) as file:
                fields = file.read().rsplit(")", 1)[1].split()
        except OSError:
            continue
        found[int(name)] = (int(fields[1]), fields[0], int(fields[19]))
    return found


def workers(server):
    """The pids of the processes that read, in the order in which they take files."""
    found = processes()
    spawners = [pid for pid, (parent, _, _) in found.items() if parent == server.process.pid]
    return sorted((pid for pid, (parent, state, _) in found.items() if parent in spawners and state != "Z"),
                  key=lambda pid: (found[pid][2], pid))


def family(server):
    """The server, the spawner and the workers."""
    spawners = [pid for pid, (parent, _, _) in processes().items() if parent == server.process.pid]
    return [server.process.pid] + spawners + workers(server)


def program(pid):
    with open("/proc/%d/exe" % pid, "rb") as file:
        return file.read()


def alive(pids):
    found = processes()
    return [pid for pid in pids if pid in found and found[pid][1] != "Z"]


def confined(pid):
    with open("/proc/%d/status" % pid) as file:
        lines = file.read().splitlines()
    rights = ["CapInh", "CapPrm", "CapEff", "CapAmb"]
    return ("NoNewPrivs:\t1" in lines and ("Seccomp:\t2" in lines) != SANITIZED
            and all("%s:\t%016x" % (name, 0) in lines for name in rights))


def open_files(server):
    return len(os.listdir("/proc/%d/fd" % server.process.pid))


def stop(worker):
    os.kill(worker, signal.SIGSTOP)
    until(lambda: processes()[worker][1] == "T")


class Held:
    """A comparison whose first file is held by a worker that was stopped."""

    def __init__(self, server, options=b"{}"):
        until(lambda: len(workers(server)) >= 2)
        before = workers(server)
        self.worker = next(pid for pid in before if processes()[pid][1] != "T")
        stop(self.worker)
        self.connection = server.connect()
        body = comparison(options=options)
        self.connection.sendall(post_head(len(body)) + body)
        until(lambda: len(workers(server)) > len(before))  # one more is made when one is taken

    def answer(self):
        with self.connection:
            return read_answer(self.connection.makefile("rb"))


def writable_mounts(pid):
    with open("/proc/%s/mounts" % pid) as file:
        return {line.split()[1] for line in file if "rw" in line.split()[3].split(",")}


class Workers(unittest.TestCase):
    def server(self, *flags, parsers="2", **more):
        server = Server("--workers", "2", "--parsers", parsers, *flags, **more)
        self.addCleanup(server.stop)
        return server

    def unreadable(self, answer):
        self.assertEqual(answer.status, 422, answer.body)
        problem = answer.json()
        self.assertEqual(problem["type"], "/problems/unreadable-mesh")
        self.assertEqual([error["part"] for error in problem["errors"]], ["a"])
        self.assertIn("ended abnormally", problem["detail"])

    def logged(self, server, what):
        until(lambda: any('"sandbox"' in line and what in line for line in server.log))

    def test_jobs_that_read_two_files_at_once_share_few_readers(self):
        a, b = wavy_grid(60, 0.1), wavy_grid(61, 0.1)
        for parsers in ("1", "2"):
            server = self.server(parsers=parsers)
            with ThreadPoolExecutor(4) as clients:
                answers = list(clients.map(lambda _: server.compare(a, b, {"threads": 2}), range(12)))
            found = [answer.json() for answer in answers]
            self.assertEqual({answer.status for answer in answers}, {200})
            self.assertEqual({(one["meshes"]["a"]["sha256"], one["meshes"]["b"]["sha256"]) for one in found},
                             {(hashlib.sha256(a).hexdigest(), hashlib.sha256(b).hexdigest())})
            for one in found:
                times = one["timings_ms"]
                stages = sum(ms for stage, ms in times.items() if stage != "total")
                self.assertLessEqual(stages, times["total"] * 1.001)

    def test_of_two_wrong_files_read_at_once_the_first_is_told(self):
        server = self.server()
        wrong = [b"v 0 0 0\nv 1 0 nan\nf 1 1 2\n", b"v 0 0\n"]
        for a, b, part in ((*wrong, "a"), (wrong[1], wrong[0], "a"), (SQUARE, wrong[0], "b"), (wrong[0], SQUARE, "a")):
            large = 10_000 * b"# a comment\n"
            after, beside = (server.compare(a + large, b + large, {"threads": threads}).json() for threads in (1, 2))
            self.assertEqual([error["part"] for error in beside["errors"]], [part])
            self.assertEqual({**after, "instance": ""}, {**beside, "instance": ""})

    def test_one_that_crashes_costs_its_request_alone(self):
        server = self.server()
        held = Held(server)
        for _ in range(5):
            self.assertEqual(server.compare().status, 200)
        self.assertEqual(server.get("/healthz").status, 200)
        os.kill(held.worker, signal.SIGSEGV)
        os.kill(held.worker, signal.SIGCONT)
        self.unreadable(held.answer())
        self.assertEqual(server.compare().status, 200)
        self.logged(server, "ended with" if SANITIZED else "signal 11")

    def test_one_that_is_killed_is_replaced(self):
        server = self.server()
        held = Held(server)
        os.kill(held.worker, signal.SIGKILL)
        self.assertEqual(held.answer().status, 200)
        self.logged(server, "signal 9")

    def test_two_that_are_killed_are_a_failure_of_the_service(self):
        server = self.server()
        until(lambda: len(workers(server)) == 2)
        second = workers(server)[1]
        stop(second)
        held = Held(server)
        os.kill(held.worker, signal.SIGKILL)
        until(lambda: held.worker not in workers(server) and len(workers(server)) == 3)  # the second was taken
        os.kill(second, signal.SIGKILL)
        answer = held.answer()
        self.assertEqual(answer.status, 500, answer.body)
        self.assertEqual(answer.json()["type"], "/problems/internal")
        self.assertEqual(answer.json()["errors"], [])
        self.assertEqual(server.compare().status, 200)

    def test_a_spawner_that_is_killed_is_started_anew(self):
        server = self.server()
        pids = family(server)
        os.kill(pids[1], signal.SIGKILL)
        self.assertEqual(server.compare().status, 200)
        until(lambda: alive(pids) == [server.process.pid])

    def test_a_spawner_that_stands_still_is_not_ready(self):
        """The spawner lives and its workers wait for files, but there will be no more workers."""
        server = self.server()
        until(lambda: len(workers(server)) == 2)
        self.assertEqual(server.get("/readyz").status, 200)
        spawner = family(server)[1]
        stop(spawner)
        try:
            until(lambda: server.get("/readyz").status == 503)
            asked = []
            for _ in range(2):
                time.sleep(1)  # what was seen counts no more
                with ThreadPoolExecutor(8) as askers:
                    asked += askers.map(lambda _: server.get("/readyz"), range(8))
            self.assertEqual({answer.status for answer in asked}, {503})
            self.assertEqual([error["part"] for error in asked[-1].json()["errors"]], ["sandbox"])
            self.assertIn("a reader of uploads", asked[-1].json()["detail"])
        finally:
            os.kill(spawner, signal.SIGCONT)
        until(lambda: server.get("/readyz").status == 200)
        self.assertEqual(server.compare().status, 200)
        self.assertEqual(family(server)[1], spawner)
        until(lambda: len(workers(server)) == 2)  # what was ordered in vain is gone

    def test_one_that_is_too_slow_is_killed_at_the_deadline(self):
        server = self.server()
        held = Held(server, {"timeout_ms": 700})
        answer = held.answer()
        self.assertEqual(answer.status, 503)
        self.assertEqual(answer.json()["type"], "/problems/out-of-time")
        until(lambda: not alive([held.worker]))
        self.assertEqual(server.compare().status, 200)

    def test_one_whose_client_leaves_is_killed(self):
        server = self.server("--queue", "0")
        held = [Held(server), Held(server)]
        self.assertEqual(server.compare().status, 503)
        for one in held:
            one.connection.close()
        until(lambda: not alive([one.worker for one in held]))
        until(lambda: server.compare().status == 200)

    def test_sigterm_ends_them_all(self):
        server = self.server("--grace-ms", "300")
        held = Held(server)
        pids = family(server)
        self.assertEqual(server.stop(), 0)
        self.assertEqual(held.answer().json()["type"], "/problems/shutting-down")
        until(lambda: not alive(pids))

    def test_a_signal_to_all_is_the_server_s_to_answer(self):
        """A supervisor may send SIGTERM to every process: files that are being read are still read."""
        server = self.server("--grace-ms", "100000")
        held = Held(server)
        pids = family(server)
        for pid in pids:
            os.kill(pid, signal.SIGTERM)
        until(lambda: any('"stopping"' in line for line in list(server.log)))
        os.kill(held.worker, signal.SIGCONT)
        self.assertEqual(held.answer().status, 200)
        self.assertEqual(server.stop(), 0)
        self.assertEqual(alive(pids), [])

    def test_none_outlives_a_server_that_is_killed(self):
        server = self.server()
        held = Held(server)
        pids = family(server)
        self.assertGreaterEqual(len(pids), 5)
        self.assertEqual(server.stop(signal.SIGKILL), -signal.SIGKILL)
        until(lambda: not alive(pids))
        held.connection.close()

    def test_they_are_one_use_and_leave_nothing_behind(self):
        server = self.server()
        large = SQUARE + b"#" * 1_000_000
        self.assertEqual(server.compare(large, large).status, 200)
        until(lambda: len(workers(server)) == 2)
        self.assertEqual(server.get("/v1/comparisons/" + "0" * 32).status, 404)  # the store has opened what it reads by
        first, files = workers(server), open_files(server)
        for i in range(10):
            self.assertEqual(server.compare(large if i % 2 else SQUARE).status, 200)
            self.assertEqual(server.compare(b=b"v 0 0 nan\n").status, 422)
        # The first look may have counted a connection that was just closing: fewer is no leak, one more is.
        until(lambda: len(workers(server)) == 2 and open_files(server) <= files)
        self.assertEqual(set(first) & set(workers(server)), set())
        until(lambda: not any(state == "Z" and parent in family(server) for parent, state, _ in processes().values()))
        self.assertEqual(server.stop(), 0)
        self.assertTrue(any("; 42 read, 0 out of memory, 0 crashed, " in line for line in server.log), server.log)

    @unittest.skipIf(SANITIZED, "a sanitizer needs more memory than any limit")
    def test_memory_is_limited(self):
        server = self.server("--parser-memory-bytes", str(48 << 20))
        self.assertEqual(server.compare().status, 200)
        triangles = 800_000  # 40 MB of file, and arrays with room for 67 MB
        stl = b"\0" * 80 + struct.pack("<I", triangles) + struct.pack("<12fH", *range(12), 0) * triangles
        answer = server.compare(a=stl)
        self.assertEqual(answer.status, 413, answer.body)
        self.assertEqual(answer.json()["errors"][0]["part"], "a")
        self.assertEqual(server.compare().status, 200)

    @unittest.skipIf(os.geteuid() != 0, "only root can become another user")
    def test_a_user_without_rights(self):
        folder = tempfile.TemporaryDirectory(dir=EVERYBODYS)  # the one of the build may be closed to others
        self.addCleanup(folder.cleanup)
        os.chmod(folder.name, 0o755)
        server = self.server(program=[shutil.copy(BINARY, folder.name)], user=65534)
        self.assertEqual(server.compare(SQUARE + b"#" * 1_000_000, RAISED).status, 200)
        until(lambda: all(map(confined, workers(server))))

    @unittest.skipUnless(NAMESPACES, "only root can mount")
    def test_a_user_without_rights_where_nothing_can_be_written_but_uploads(self):
        folder = tempfile.TemporaryDirectory(dir=EVERYBODYS)
        self.addCleanup(folder.cleanup)
        os.chmod(folder.name, 0o755)
        binary = shutil.copy(BINARY, folder.name)
        uploads = os.path.join(folder.name, "uploads")
        os.mkdir(uploads)
        server = self.server("--temp-dir", uploads, "--data-dir", os.path.join(uploads, "kept"),
                             program=["unshare", "--mount", "sh", "-ec", READ_ONLY, "sh", uploads, binary])
        with open("/proc/%d/status" % server.process.pid) as file:
            self.assertIn("Uid:\t65534\t65534\t65534\t65534\n", file.read())
        writable, elsewhere = writable_mounts(server.process.pid), writable_mounts("self") - {"/"}
        self.assertEqual({path for path in writable - elsewhere if path == uploads or not path.startswith(("/proc", "/sys", "/dev"))}, {uploads})
        self.assertEqual(server.compare(SQUARE + b"#" * 1_000_000, RAISED).status, 200)
        self.assertEqual(server.compare(a=b"v 0 0 nan\n").status, 422)
        until(lambda: all(map(confined, workers(server))))


@unittest.skipUnless(WITHOUT, "MESHGAUGE_WITHOUT names no program")
class Lacks(unittest.TestCase):
    """On machines that lack a part of the confinement the service logs it, and serves."""

    def lacking(self, what):
        server = Server(program=[WITHOUT, what, BINARY])
        self.addCleanup(server.stop)
        self.assertEqual(server.compare(SQUARE + b"#" * 1_000_000, RAISED).status, 200)
        self.assertEqual(server.compare(a=b"v 0 0 nan\n").status, 422)
        return server

    def test_no_seccomp(self):
        server = self.lacking("seccomp")
        until(lambda: any("seccomp is not in force" in line for line in server.log))

    def test_no_seals(self):
        server = self.lacking("seals")
        until(lambda: any("files in memory cannot be sealed" in line for line in server.log))


    def test_a_service_that_must_have_it_does_not_start(self):
        for what in ("seccomp", "seals"):
            done = subprocess.run([WITHOUT, what, BINARY, "serve", "--port", "0", "--require-sandbox"], capture_output=True,
                                  text=True, timeout=60, env=OWN_DATA)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("--require-sandbox: ", done.stderr)
        if not SANITIZED:
            server = Server("--require-sandbox")
            self.addCleanup(server.stop)
            self.assertEqual(server.compare().status, 200)

    @unittest.skipUnless(READER, "this build has no program for the spawner")
    def test_no_programs_in_memory(self):
        server = self.lacking("programs")
        until(lambda: any("no program in memory can be executed: Permission denied; uploads are read as safely" in line
                          for line in server.log))
        with open(BINARY, "rb") as file:
            self.assertEqual(program(family(server)[1]), file.read())
        until(lambda: all(map(confined, workers(server))))


class Program(unittest.TestCase):
    """The properties of the spawner and its workers."""

    def setUp(self):
        self.server = Server("--workers", "2", "--parsers", "2")
        self.addCleanup(self.server.stop)
        until(lambda: len(workers(self.server)) == 2)
        self.spawner = family(self.server)[1]

    @unittest.skipUnless(READER, "this build has no program for the spawner")
    def test_the_small_program_of_the_same_build(self):
        with open(READER, "rb") as file:
            self.assertEqual(program(self.spawner), file.read())
        with open("/proc/%d/maps" % self.spawner) as maps:
            self.assertFalse([line for line in maps if ".so" in line])
        self.assertFalse([line for line in self.server.log if "program" in line])

    def test_it_holds_what_it_needs_alone(self):
        """The spawner has null devices, its channel, a descriptor for ended workers, and one for each worker that may be cancelled."""
        folder = "/proc/%d/fd" % self.spawner
        until(lambda: len(os.listdir(folder)) == 7)  # the workers' own are closed here
        found = {int(fd): os.readlink(os.path.join(folder, fd)) for fd in os.listdir(folder)}
        self.assertEqual([found[0], found[1]], ["/dev/null", "/dev/null"])
        kinds = sorted(name.split(":")[0] for fd, name in found.items() if fd > 2)
        self.assertEqual(kinds, ["anon_inode", "socket", "socket", "socket"])


class ByHand(unittest.TestCase):
    def test_the_command_is_not_for_people(self):
        done = subprocess.run([BINARY, "sandbox"], stdin=subprocess.DEVNULL, capture_output=True, check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn(b"the server's own", done.stderr)
        listed = subprocess.run([BINARY, "--help"], capture_output=True, check=True).stdout
        self.assertNotIn(b"sandbox", listed)


if __name__ == "__main__":
    unittest.main()
