"""Attacks on the service by many connections at once, and what becomes of honest clients; docs/http_edge.md."""

import contextlib
import ctypes
import errno
import os
import pathlib
import resource
import select
import signal
import socket
import stat
import statistics
import tempfile
import threading
import time
import unittest

from harness import ASYNC, BINARY, SLOW, SLOW_OPTIONS, Server, begin_slow, comparison, occupy_guests, post_head, read_answer, until, until_computing
from keys import bearer, new_key, write_keys
from test_sandbox import workers

MOST_DELAY = 0.1  # seconds that eight dribbling clients may cost an honest one
ATTACKER = "127.0.0.2"  # honest clients call from 127.0.0.1
SLOW_HEAD = b"GET /healthz HTTP/1.1\r\nX: "
SLOW_BODY = post_head(100_000) + comparison()[:120]


class Dribblers(contextlib.AbstractContextManager):
    """`count` connections that send `start`, then one byte each 20 ms for as long as they may."""

    def __init__(self, server, count, start, sources=("127.0.0.1",)):
        self.connections = [server.connect(source=sources[i % len(sources)]) for i in range(count)]
        for connection in self.connections:
            connection.sendall(start)
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self._dribble)
        self.thread.start()

    def _dribble(self):
        while not self.ended.wait(0.02):
            for connection in self.connections:
                with contextlib.suppress(OSError):
                    connection.send(b"x")

    def answered(self):
        """The connections that have an answer already, or are closed."""
        return select.select(self.connections, [], [], 0)[0]

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()
        for connection in self.connections:
            connection.close()


class Slow(unittest.TestCase):
    def start(self, *flags):
        server = Server(*flags)
        self.addCleanup(server.stop)
        return server

    def median_seconds(self, server, requests=25):
        """The median time of a small comparison, its connection included."""
        times = []
        for _ in range(requests):
            start = time.monotonic()
            self.assertEqual(server.compare().status, 200)
            times.append(time.monotonic() - start)
        return statistics.median(times)

    def assert_not_delayed(self, server, attack):
        """Asserts it of one of five rounds: other work of the machine may delay any, and an attack that works delays all."""
        self.median_seconds(server, 5)
        for _ in range(5):
            quiet, attacked = self.round(server, attack)
            print("%s: %.1f ms while attacked, %.1f ms else" % (self._testMethodName, 1000 * attacked, 1000 * quiet))
            if attacked <= quiet + MOST_DELAY:
                return
        self.fail("honest clients are delayed")

    def round(self, server, attack):
        """The medians of quiet times before and after an attack, the larger one, and of the attack."""
        quiet = self.median_seconds(server)
        with attack() as dribblers:
            still = dribblers()
            attacked = self.median_seconds(server)
            self.assertEqual(dribblers(), still)  # they were there all the while
        return max(quiet, self.median_seconds(server)), attacked

    def eight(self, server, start):
        @contextlib.contextmanager
        def attack():
            with Dribblers(server, 8, start) as dribblers:
                time.sleep(0.3)
                self.assertEqual(dribblers.answered(), [])
                yield dribblers.answered
        return attack

    def test_eight_that_dribble_a_head(self):
        server = self.start("--head-timeout-ms", "600000")
        self.assert_not_delayed(server, self.eight(server, SLOW_HEAD))

    def test_eight_that_dribble_a_body(self):
        server = self.start("--body-timeout-ms", "600000")
        self.assert_not_delayed(server, self.eight(server, SLOW_BODY))

    def test_a_hundred_of_one_address_are_refused_beyond_its_limit(self):
        for start, refusals in ((SLOW_HEAD, {429}), (SLOW_BODY, {429, 503})):
            server = self.start("--head-timeout-ms", "600000", "--body-timeout-ms", "600000", "--max-arriving-per-peer", "32", "--workers", "2", "--queue", "64")

            @contextlib.contextmanager
            def attack():
                with Dribblers(server, 100, start, (ATTACKER,)) as dribblers:
                    until(lambda: len(dribblers.answered()) == 68)
                    yield dribblers.answered
                    self.assertLessEqual(self.statuses(dribblers.answered()), refusals)
            self.assert_not_delayed(server, attack)

    def statuses(self, connections):
        """The statuses of answers that can still be read: a client's last bytes may have reset its connection."""
        found = set()
        for connection in connections:
            with contextlib.suppress(OSError):
                if answer := read_answer(connection.makefile("rb")):
                    found.add(answer.status)
        self.assertTrue(found)
        return found

    def test_dribblers_of_many_addresses_are_bounded_by_the_deadline(self):
        server = self.start("--head-timeout-ms", "1000", "--io-threads", "2")
        with Dribblers(server, 150, SLOW_HEAD, ["127.0.0.%d" % i for i in range(2, 12)]) as dribblers:
            self.assertEqual(server.compare().status, 200)
            until(lambda: len(dribblers.answered()) == 150)

    def test_slow_uploads_hold_their_places_until_the_deadline(self):
        """A request that finds no place meanwhile is refused at once, and health is answered."""
        server = self.start("--workers", "1", "--queue", "1", "--io-threads", "1", "--body-timeout-ms", "60000")
        with contextlib.ExitStack() as stack:
            streams = []
            for _ in range(2):
                connection = stack.enter_context(server.connect(source=ATTACKER))
                connection.sendall(post_head(100_000, "Expect: 100-continue\r\n"))
                streams.append(connection.makefile("rb"))
                self.assertEqual(streams[-1].readline(), b"HTTP/1.1 100 Continue\r\n")  # it has its place
                streams[-1].readline()
                connection.sendall(comparison()[:120])
            self.assertEqual(server.compare().status, 503)
            self.assertEqual(server.get("/healthz").status, 200)
            self.assertEqual([read_answer(stream).status for stream in streams], [408, 408])
            self.assertEqual(server.compare().status, 200)


class Thousands(unittest.TestCase):
    """Connections of a hundred addresses that send slowly, are idle or listen, while others are served.

    MESHGAUGE_CROWD=10000 makes so many of them, and health checks must be answered in time then.
    """
    MOST_HEALTH = 0.05  # seconds, in 99 of 100 checks
    greedy = modest = ""  # header fields of the crowd and of the others

    def setUp(self):
        most = int(os.environ.get("MESHGAUGE_CROWD", 1600))
        self.streams = min(2000, most // 4)  # one key may have half of 4096
        self.each = (most - self.streams) // 3
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, max(soft, 2 * most)), hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        self.server = Server("--workers", "1", "--max-event-streams", str(2 * self.streams + 1), "--keep-alive-ms", "600000",
                             "--head-timeout-ms", "3600000", "--body-timeout-ms", "3600000", *self.flags())
        self.addCleanup(self.server.stop)
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        busy, = self.crowd(1, post_head(len(body), ASYNC + self.greedy) + body)
        self.busy = read_answer(busy.makefile("rb")).headers["location"]

    def flags(self):
        return ()

    def crowd(self, count, sent, came=None):
        """So many connections, by the hundred: `came` waits for what the service does with each."""
        connections = []
        for i in range(count):
            connections.append(self.stack.enter_context(self.server.connect(120, "127.0.0.%d" % (2 + i % 100))))
            connections[-1].sendall(sent)
            if came and (i % 100 == 99 or i + 1 == count):
                for connection in connections[i - i % 100:]:
                    came(connection)
        return connections

    def answered(self, connection):
        self.assertEqual(read_answer(connection.makefile("rb")).status, 200)

    def has_place(self, connection):
        self.assertEqual(connection.recv(25, socket.MSG_WAITALL), b"HTTP/1.1 100 Continue\r\n\r\n")

    def listens(self, connection):
        self.assertEqual(connection.recv(12, socket.MSG_WAITALL | socket.MSG_PEEK), b"HTTP/1.1 200")

    def health(self):
        """Prints and returns how long 99 of 100 health checks take at most, their connections included."""
        times = []
        for _ in range(200):
            start = time.monotonic()
            self.assertEqual(self.server.get("/healthz").status, 200)
            times.append(time.monotonic() - start)
        times.sort()
        connections = self.server.get("/metrics", extra=self.modest).body.split(b"\nmeshgauge_connections ")[1].split()[0]
        print("health beside %d connections: median %.1f ms, p99 %.1f ms" % (int(connections), 1000 * times[99], 1000 * times[197]))
        return times[197]

    def test_health_and_others_are_answered(self):
        self.health()
        head = "Host: localhost\r\n" + self.greedy
        slow = self.crowd(self.each, b"GET /openapi.yaml HTTP/1.1\r\nX: ")
        slow += self.crowd(self.each, ("POST /v1/meshes HTTP/1.1\r\n%sContent-Length: 100\r\nExpect: 100-continue\r\n\r\n" % head).encode(), self.has_place)
        idle = self.crowd(self.each, b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n", self.answered)
        listening = self.crowd(self.streams, ("GET %s/events HTTP/1.1\r\n%s\r\n" % (self.busy, head)).encode(), self.listens)
        until(lambda: b"\nmeshgauge_event_streams %d\n" % self.streams in self.server.get("/metrics", extra=self.modest).body)
        beside = self.health()
        if "MESHGAUGE_CROWD" in os.environ:
            self.assertLess(beside, self.MOST_HEALTH)
        start = time.monotonic()
        for _ in range(20):
            self.assertEqual(self.server.compare(extra=self.modest).status, 200)
        print("a small comparison beside them: %.1f ms" % (50 * (time.monotonic() - start)))
        for connection in idle:
            connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.answered(connection)
        poll = select.poll()
        for connection in slow:
            poll.register(connection, select.POLLIN)
        self.assertEqual(poll.poll(0), [])  # they were there all the while
        self.server.send("DELETE", self.busy, extra=self.greedy)
        for connection in listening:
            self.assertIn(b"event: end", read_answer(connection.makefile("rb")).body)


class ThousandsWithKeys(Thousands):
    def flags(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name) / "keys.json"
        greedy, one = new_key("greedy", requests_per_minute=10_000_000, burst=100_000)
        modest, other = new_key("modest", "--scope", "compare", "--scope", "metrics", requests_per_minute=10_000_000)
        write_keys(path, one, other)
        self.greedy, self.modest = bearer(greedy), bearer(modest)
        return "--keys-file", str(path)


class Queue(unittest.TestCase):
    """Requests that wait while all threads are busy."""

    def setUp(self):
        self.server = Server("--workers", "1", "--queue", "4")
        self.addCleanup(self.server.stop)
        self.busy, _ = begin_slow(self.server)
        until(lambda: self.server.get(self.busy).json()["progress"])  # before that it may be claimed and not begun
        self.guest = occupy_guests(self.server, 2)

    def tearDown(self):
        self.guest.close()
        self.server.send("DELETE", self.busy)

    def compare_in(self, ms):
        answer = self.server.compare(options={"timeout_ms": ms})
        self.assertEqual(self.server.get(self.busy).json()["state"], "running")
        return answer.status, answer.json()["type"].rpartition("/")[2]

    def test_the_time_in_the_queue_counts(self):
        self.assertEqual(self.compare_in(100), (503, "out-of-time"))

    def test_clients_that_have_left_free_their_places(self):
        body = comparison(options=SLOW_OPTIONS)
        for _ in range(3):
            with contextlib.ExitStack() as stack:
                for i in range(5):  # beside one address alone, others would still find places: it would be ready
                    stack.enter_context(self.server.connect(60, "127.0.0.%d" % (2 + i % 2))).sendall(post_head(len(body)) + body)
                until(lambda: self.server.get("/readyz").status == 503)
            until(lambda: self.server.get("/readyz").status == 200)
        self.assertEqual(self.compare_in(100), (503, "out-of-time"))


class Burst(unittest.TestCase):
    def test_a_burst_waits_in_the_backlog(self):
        count = min(300, int(pathlib.Path("/proc/sys/net/core/somaxconn").read_text()))
        server = Server("--max-pending-connections", str(8 * count))  # of which an eighth may wait however slow the machine is
        self.addCleanup(server.stop)
        server.process.send_signal(signal.SIGSTOP)  # so that nothing is accepted until all are there
        try:
            burst = [server.connect(20) for _ in range(count)]
            for connection in burst:
                connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        finally:
            server.process.send_signal(signal.SIGCONT)
        answers = [read_answer(connection.makefile("rb")) for connection in burst]
        self.assertEqual({answer.status for answer in answers}, {200})
        for connection in burst:
            connection.close()


def socket_of(server, wanted):
    """The first of the server's own sockets that is wanted, shared with this process."""
    libc = ctypes.CDLL(None, use_errno=True)
    process = os.pidfd_open(server.process.pid)
    try:
        for name in os.listdir(f"/proc/{server.process.pid}/fd"):
            fd = libc.syscall(438, process, int(name), 0)  # pidfd_getfd
            if fd < 0 and ctypes.get_errno() in (errno.EPERM, errno.ENOSYS):
                raise unittest.SkipTest("another process's descriptors cannot be had here")
            if fd < 0:
                continue  # closed meanwhile
            if not stat.S_ISSOCK(os.fstat(fd).st_mode):
                os.close(fd)
                continue
            found = socket.socket(fileno=fd)
            if found.family == socket.AF_INET and wanted(found):
                return found
            found.close()
    finally:
        os.close(process)
    raise AssertionError("no such socket")


def listens(one):
    return one.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN) == 1


class Accept(unittest.TestCase):
    def descriptors(self, server):
        return len(os.listdir(f"/proc/{server.process.pid}/fd"))

    @unittest.skipIf(os.environ.get("MESHGAUGE_SANITIZED"), "UBSan takes an object for invalid when no descriptor is left")
    def test_no_descriptors_left(self):
        server = Server("--head-timeout-ms", "600000", "--workers", "2", "--parsers", "2")
        self.assertEqual(server.compare().status, 200)
        until(lambda: len(workers(server)) == 2)  # the workers that were used have ended, and each has its successor
        before = self.descriptors(server)
        most = before + 8
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (most, most))
        with contextlib.ExitStack() as stack:
            for _ in range(20):
                stack.enter_context(server.connect()).sendall(SLOW_HEAD)
            until(lambda: self.descriptors(server) >= most)
            time.sleep(0.3)
            self.assertIsNone(server.process.poll())
        until(lambda: self.descriptors(server) <= before)
        self.assertEqual(server.get("/healthz").status, 200)
        self.assertEqual(server.compare().status, 200)
        self.assertEqual(server.stop(), 0)

    def test_all_descriptors_are_taken(self):
        server = Server(program=("prlimit", "--nofile=512:1024", BINARY))
        self.addCleanup(server.stop)
        self.assertEqual(resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE), (1024, 1024))

    def test_silent_clients_are_asked_whether_they_are_there(self):
        """One that vanished without a word never closes its connection: the kernel finds out, and what it waits for ends."""
        server = Server()
        self.addCleanup(server.stop)
        with server.connect() as connection:
            connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertEqual(read_answer(connection.makefile("rb")).status, 200)
            until(lambda: self.timer(server.port, connection.getsockname()[1]) == 2)

    def timer(self, local, remote):
        """Which timer runs for a connection (the kernel's proc_net_tcp.rst); 2: that of keep-alive. None: there is no such one."""
        ports = ["%04X" % local, "%04X" % remote]
        for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
            fields = line.split()
            if [place.split(":")[1] for place in fields[1:3]] == ports:
                return int(fields[5].split(":")[0], 16)
        return None

    def test_answers_are_not_held_back(self):
        """Else each would wait for the client's delayed acknowledgement of the one before."""
        server = Server()
        self.addCleanup(server.stop)
        with server.connect() as connection:
            connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertEqual(read_answer(connection.makefile("rb")).status, 200)
            ours = connection.getsockname()
            with socket_of(server, lambda one: not listens(one) and one.getpeername() == ours) as served:
                self.assertEqual(served.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY), 1)

    def test_a_listening_socket_that_fails_ends_the_service(self):
        """Every request is answered, and the exit code tells a supervisor to start the service again."""
        server = Server("--workers", "1", "--grace-ms", "500")
        steady, busy = server.connect(), server.connect(120)
        stream = steady.makefile("rb")
        steady.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
        self.assertEqual(read_answer(stream).status, 200)
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        busy.sendall(post_head(len(body)) + body)
        until_computing(server.process)
        with socket_of(server, listens) as listener:
            listener.shutdown(socket.SHUT_RDWR)  # accept() says EINVAL from now on
        self.assertEqual(read_answer(busy.makefile("rb")).status, 200)
        self.assertEqual(server.process.wait(60), 3)
        server.reader.join()
        self.assertTrue(any("the listening socket failed" in line for line in server.log))
        for connection in (steady, busy):
            connection.close()
        server.stop()


if __name__ == "__main__":
    unittest.main()
