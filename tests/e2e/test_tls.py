"""TLS by the service itself."""

import contextlib
import json
import os
import re
import resource
import signal
import socket
import ssl
import subprocess
import tempfile
import time
import unittest
import warnings
from pathlib import Path

import wire
from harness import (BINARY, ENVIRONMENT, OWN_DATA, SLOW, SLOW_OPTIONS, SQUARE, Server, comparison, flat_grid, holding_the_worker, post_head,
                     read_answer, until, until_computing)


def make_certificate(folder, name="localhost"):
    """Writes folder/c.pem and folder/k.pem; gives the certificate as bytes."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                    "-subj", "/CN=" + name, "-addext", "subjectAltName=DNS:" + name, "-keyout", folder / "k.pem",
                    "-out", folder / "c.pem"], check=True, capture_output=True)
    return ssl.PEM_cert_to_DER_cert((folder / "c.pem").read_text())


def client(**changes):
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.sslsocket_class = wire.TlsSocket
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    for name, value in changes.items():
        setattr(context, name, value)
    return context


class TlsServer(Server):
    context = client()

    def plain(self, timeout=60, source=""):
        return super().connect(timeout, source)

    def connect(self, timeout=60, context=None):
        return (context or self.context).wrap_socket(self.plain(timeout), server_hostname="localhost")


def recorded_hello():
    """What a client sends first: to send it again costs nothing."""
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    with contextlib.suppress(ssl.SSLWantReadError):
        client().wrap_bio(incoming, outgoing).do_handshake()
    return outgoing.read()


class Steady:
    """A connection that stays open: what is asked on it costs no handshake."""

    def __init__(self, server):
        self.connection = server.connect()
        self.stream = self.connection.makefile("rb")

    def get(self, path):
        self.connection.sendall(("GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n" % path).encode())
        return read_answer(self.stream)

    def counts(self):
        """How many handshakes were begun, refused and abandoned, and how many connections were dropped."""
        text = self.get("/metrics").body.decode()
        return [int(float(re.search(r"^meshgauge_%s_total (\S+)$" % name, text, re.M)[1]))
                for name in ("tls_handshakes", "tls_handshakes_refused", "tls_handshakes_abandoned", "connections_dropped")]

    def close(self):
        self.stream.close()
        self.connection.close()


class Pipe:
    """TLS over a socket; the test controls each record."""

    def __init__(self, server):
        self.socket = server.plain()
        self.incoming, self.outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        self.tls = client().wrap_bio(self.incoming, self.outgoing)
        self.run(self.tls.do_handshake)

    def flush(self):
        if self.outgoing.pending:
            self.socket.sendall(self.outgoing.read())

    def run(self, step):
        while True:
            try:
                result = step()
                self.flush()
                return result
            except ssl.SSLWantReadError:
                self.flush()
                data = self.socket.recv(65536)
                self.incoming.write(data) if data else self.incoming.write_eof()

    def say_goodbye(self):
        """Sends TLS's end of data; the socket stays open."""
        try:
            self.tls.unwrap()
        except ssl.SSLWantReadError:
            self.flush()

    def rest(self):
        text = b""
        while True:
            try:
                data = self.run(lambda: self.tls.read(65536))
            except ssl.SSLError:
                return text
            if not data:
                return text
            text += data


class Tls(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.holder.name)
        cls.certificate = make_certificate(cls.folder)
        cls.server = cls.start()

    @classmethod
    def tearDownClass(cls):
        code = cls.server.stop()
        cls.holder.cleanup()
        assert code == 0, "exit %d\n%s" % (code, "".join(cls.server.log))

    @classmethod
    def start(cls, *flags, folder=None):
        folder = folder or cls.folder
        return TlsServer("--tls-certificate", str(folder / "c.pem"), "--tls-key", str(folder / "k.pem"), *flags)

    def own(self, *flags, folder=None):
        server = self.start(*flags, folder=folder)
        self.addCleanup(server.stop)
        return server

    def tearDown(self):
        self.assertEqual(self.server.get("/healthz").status, 200)

    def test_a_comparison_with_a_certificate_that_is_checked(self):
        context = ssl.create_default_context(cafile=str(self.folder / "c.pem"))
        context.sslsocket_class = wire.TlsSocket
        body = comparison()
        with self.server.connect(context=context) as connection:
            stream = connection.makefile("rb")
            for _ in range(3):
                connection.sendall(post_head(len(body)) + body)
                self.assertEqual(read_answer(stream).status, 200)

    def test_versions(self):
        for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
            with self.server.connect(context=client(minimum_version=version, maximum_version=version)) as connection:
                self.assertEqual(connection.version(), version.name.replace("v1_", "v1."))
        for version in (ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # that these are old is the point
                old = client(minimum_version=version, maximum_version=version)
            old.set_ciphers("DEFAULT:@SECLEVEL=0")
            with self.assertRaisesRegex(ssl.SSLError, "protocol version|ALERT_PROTOCOL_VERSION"):
                self.server.connect(context=old)

    def test_weak_ciphers_are_refused(self):
        for cipher in ("AES128-SHA", "ECDHE-ECDSA-AES128-SHA256", "NULL-SHA256:@SECLEVEL=0"):
            weak = client(maximum_version=ssl.TLSVersion.TLSv1_2)
            weak.set_ciphers(cipher)
            with self.assertRaises(ssl.SSLError):
                self.server.connect(context=weak)

    def test_the_protocol_is_http_1_1(self):
        context = client()
        context.set_alpn_protocols(["h2", "http/1.1"])
        with self.server.connect(context=context) as connection:
            self.assertEqual(connection.selected_alpn_protocol(), "http/1.1")
        context = client()
        context.set_alpn_protocols(["h2"])
        with self.assertRaisesRegex(ssl.SSLError, "(?i)no.application.protocol"):
            self.server.connect(context=context)

    def test_sessions_are_resumed_by_tickets_and_never_renegotiated(self):
        context = client(maximum_version=ssl.TLSVersion.TLSv1_2)
        with self.server.connect(context=context) as connection:
            session = connection.session
        with context.wrap_socket(self.server.plain(), session=session) as connection:
            self.assertTrue(connection.session_reused)
        done = subprocess.run(["openssl", "s_client", "-tls1_2", "-connect", "127.0.0.1:%d" % self.server.port], input=b"R\n",
                              capture_output=True, timeout=60)
        self.assertIn(b"RENEGOTIATING", done.stdout + done.stderr)
        self.assertIn(b"no renegotiation", done.stdout + done.stderr)

    def test_plain_http_is_refused_with_the_reason(self):
        body = comparison()
        for request in (b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n", b"DELETE / HTTP/1.1\r\n\r\n", post_head(len(body)) + body):
            with self.server.plain() as connection:
                connection.sendall(request)
                stream = connection.makefile("rb")
                answer = read_answer(stream)
                self.assertEqual(answer.status, 400)
                self.assertIn("speaks TLS", answer.json()["detail"])
                self.assertEqual(stream.read(), b"")

    def test_what_is_neither_is_closed(self):
        for junk in (b"\x00" * 100, b"\x16\x03\x01\xff\xff" + b"x" * 70000, b"\x80\x2e\x01\x00\x02", bytes(range(128, 256)) * 10):
            with self.server.plain() as connection:
                try:
                    connection.sendall(junk)
                    connection.shutdown(socket.SHUT_WR)
                    connection.makefile("rb").read()
                except OSError:  # reset, or gone already
                    pass

    def test_a_slow_handshake_is_cut(self):
        server = self.own("--head-timeout-ms", "500", "--keep-alive-ms", "400")
        hello = recorded_hello()
        for first in (b"", hello[:1], hello[:100]):
            with server.plain() as connection:
                connection.sendall(first)
                self.assertEqual(connection.recv(100), b"")
        with server.plain() as connection:  # a byte at a time, for longer than it may take
            start = time.monotonic()
            with self.assertRaises((ConnectionResetError, BrokenPipeError)):
                for byte in hello * 100:
                    connection.sendall(bytes([byte]))
                    time.sleep(0.02)
            self.assertGreaterEqual(time.monotonic() - start, 0.4)
        self.assertEqual(server.compare().status, 200)

    def test_large_uploads(self):
        mesh = flat_grid(330)  # about 12 MB
        body = comparison(mesh, SQUARE, {"tolerance": {"absolute": 1e-3}})
        chunks = b"".join(b"%x\r\n%s\r\n" % (len(body[i:i + 100000]), body[i:i + 100000]) for i in range(0, len(body), 100000))
        for request in (post_head(len(body)) + body,
                        post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding: chunked") + chunks + b"0\r\n\r\n"):
            answer = self.server.raw(request)
            self.assertEqual(answer.status, 200)
            self.assertEqual(answer.json()["meshes"]["a"]["bytes"], len(mesh))

    def test_a_large_answer(self):
        description = self.server.get("/openapi.yaml")
        self.assertGreater(len(description.body), 30000)
        self.assertEqual(len(description.body), int(description.headers["content-length"]))

    def cancelled(self, end):
        """Sends what would run for long, ends our side by `end`, and gives the answer."""
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        pipe = Pipe(self.server)
        self.addCleanup(pipe.socket.close)
        pipe.tls.write(post_head(len(body)) + body)
        pipe.flush()
        until_computing(self.server.process)
        end(pipe)
        head, _, document = pipe.rest().partition(b"\r\n\r\n")
        self.assertTrue(head.startswith(b"HTTP/1.1 200 "), head)
        self.assertEqual(json.loads(document)["status"], "cancelled")

    def test_a_client_that_ends_its_half_cancels_its_comparison(self):
        self.cancelled(lambda pipe: pipe.say_goodbye())
        self.cancelled(lambda pipe: pipe.socket.shutdown(socket.SHUT_WR))

    def test_a_client_that_goes_away_frees_its_worker(self):
        server = self.own("--queue", "0", "--workers", "1")
        holding_the_worker(server).close()
        until(lambda: server.compare().status == 200)

    def test_the_end_is_said(self):
        pipe = Pipe(self.server)
        pipe.tls.write(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        pipe.flush()
        text = b""
        while data := pipe.run(lambda: pipe.tls.read(1000)):  # an end that is not said raises SSLEOFError
            text += data
        self.assertTrue(text.startswith(b"HTTP/1.1 200 "))
        pipe.socket.close()

    def test_reload(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            first = make_certificate(folder)
            server = self.own(folder=folder)
            with server.connect() as old:
                self.assertEqual(old.getpeercert(True), first)
                second = make_certificate(folder, "other.example")
                self.reload(server, "certificate valid until")
                with server.connect() as new:
                    self.assertEqual(new.getpeercert(True), second)
                old.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
                self.assertEqual(read_answer(old.makefile("rb")).status, 200)
            good = (folder / "k.pem").read_text()
            for file, text, saying in (("k.pem", "nonsense", "--tls-key"), ("k.pem", (self.folder / "k.pem").read_text(), "key"),
                                       ("c.pem", "", "--tls-certificate")):
                (folder / file).write_text(text)
                self.reload(server, saying)
                with server.connect() as new:
                    self.assertEqual(new.getpeercert(True), second)
                (folder / "k.pem").write_text(good)

    def reload(self, server, saying):
        seen = len(server.log)
        server.process.send_signal(signal.SIGHUP)
        until(lambda: any('"reload"' in line and saying in line for line in server.log[seen:]))

    def test_files_that_cannot_be_used_end_the_start(self):
        def fails(certificate, key, saying):
            done = subprocess.run([BINARY, "serve", "--port", "0", "--tls-certificate", str(certificate), "--tls-key", str(key)],
                                  capture_output=True, text=True, timeout=60, env=OWN_DATA, stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 3)
            self.assertIn(saying, done.stderr)

        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            make_certificate(folder, "other")
            good = self.folder / "c.pem", self.folder / "k.pem"
            fails(folder / "none", good[1], "No such file")
            fails(good[0], folder / "none", "No such file")
            fails(good[1], good[1], "--tls-certificate")
            fails(good[0], folder / "k.pem", "key values mismatch")
            subprocess.run(["openssl", "ec", "-in", folder / "k.pem", "-aes128", "-passout", "pass:x", "-out", folder / "e.pem"],
                           check=True, capture_output=True)
            fails(folder / "c.pem", folder / "e.pem", "--tls-key")

    def test_health(self):
        def health(*flags, environment=None):
            return subprocess.run([BINARY, "health", "--port", str(self.server.port), *flags], stderr=subprocess.DEVNULL,
                                  env={**ENVIRONMENT, **(environment or {})}).returncode

        self.assertEqual(health("--https"), 0)
        self.assertEqual(health(environment={"MESHGAUGE_TLS_CERTIFICATE": str(self.folder / "c.pem")}), 0)
        self.assertEqual(health(), 1)

    def test_slow_clients_hold_no_thread(self):
        server = self.own("--io-threads", "1", "--head-timeout-ms", "600000", "--keep-alive-ms", "600000")
        slow = [server.connect() for _ in range(10)]
        silent = [server.plain() for _ in range(10)]
        greeting = [server.plain() for _ in range(10)]
        for connection in slow:
            connection.sendall(b"GET /openapi.yaml HTTP/1.1\r\n")
        for connection in greeting:
            connection.sendall(b"\x16\x03")
        self.assertEqual(server.get("/openapi.yaml").status, 200)
        for connection in slow:
            connection.sendall(b"Host: localhost\r\n\r\n")
            self.assertEqual(read_answer(connection.makefile("rb")).status, 200)
        for connection in (*slow, *silent, *greeting):
            connection.close()

    def test_the_end_of_the_service_waits_for_no_handshake(self):
        server = self.start("--grace-ms", "300")
        connections = [server.plain(), server.plain(), server.connect()]
        connections[1].sendall(b"\x16\x03")
        until(lambda: b"\nmeshgauge_connections 4\n" in server.get("/metrics").body)  # with this one
        self.assertEqual(server.stop(), 0)
        for connection in connections:
            connection.close()


class Floods(unittest.TestCase):
    """Recorded hellos, at the rate at which this program can send them; what is asserted are counts, not times."""

    ATTACKER = "127.0.0.2"  # honest clients call from 127.0.0.1

    def start(self, *flags):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        make_certificate(Path(folder.name))
        server = TlsServer("--tls-certificate", folder.name + "/c.pem", "--tls-key", folder.name + "/k.pem", "--keep-alive-ms", "600000",
                           "--head-timeout-ms", "600000", "--grace-ms", "300", *flags)
        self.addCleanup(server.stop)
        return server, self.steady(server)

    def steady(self, server):
        steady = Steady(server)
        self.addCleanup(steady.close)
        return steady

    def flood(self, server, source, count, bytes_sent):
        """Connections from this address that have sent this, and stay open."""
        connections = []
        for _ in range(count):
            connections.append(server.plain(source=source))
            self.addCleanup(connections[-1].close)
            with contextlib.suppress(OSError):  # refused already
                connections[-1].sendall(bytes_sent)
        return connections

    def answered(self, connection):
        """Whether the service has sent anything before it closed, or before the client had to finish."""
        try:
            return connection.recv(1) != b""
        except ConnectionResetError:
            return False

    def test_an_address_that_repeats_a_hello_is_refused_beyond_its_rate(self):
        server, steady = self.start("--max-handshakes-per-second-per-peer", "2")
        before, began = steady.counts(), time.monotonic()
        flood = self.flood(server, self.ATTACKER, 300, recorded_hello())

        def passed():
            begun, refused, abandoned, _ = (now - then for now, then in zip(steady.counts(), before))
            self.assertEqual(abandoned, 0)
            return (begun, refused) if begun + refused == len(flood) else None
        begun, refused = until(passed)
        self.assertGreaterEqual(begun, 10)  # five seconds' handshakes at once
        self.assertLessEqual(begun, 10 + 2 * (time.monotonic() - began) + 1)
        self.assertEqual(sum(map(self.answered, flood)), begun)  # the others got no byte
        self.assertEqual(server.get("/healthz").status, 200)  # of another address

    def test_a_client_that_has_gone_costs_nothing(self):
        server, steady = self.start("--max-handshakes-per-second-per-peer", "1000")
        begun, refused, abandoned, _ = steady.counts()
        hello = recorded_hello()
        server.process.send_signal(signal.SIGSTOP)  # so that all have gone before the service looks
        try:
            for _ in range(50):
                with server.plain(source=self.ATTACKER) as connection:
                    connection.sendall(hello)
        finally:
            server.process.send_signal(signal.SIGCONT)
        until(lambda: steady.counts()[2] == abandoned + 50)
        self.assertEqual(steady.counts()[:2], [begun, refused])

    def test_other_addresses_go_before_those_that_flood(self):
        """Of 400 hellos 256 wait, and four a second are taken: behind them an honest client would wait for a minute."""
        server, steady = self.start("--max-handshakes-per-second", "4", "--max-handshakes-per-second-per-peer", "10")
        before, began = steady.counts(), time.monotonic()
        for i in range(8):
            self.flood(server, "127.0.0.%d" % (2 + i), 50, recorded_hello())
        until(lambda: steady.counts()[1] > before[1])  # the places are taken
        waiting = steady.counts()
        self.assertEqual(server.get("/healthz").status, 200)
        begun = steady.counts()[0]
        self.assertLessEqual(begun - before[0], 4 * (time.monotonic() - began) + 2)
        self.assertLess(begun - waiting[0], 128)  # of the 256 that came before it
        self.assertEqual(server.stop(), 0)  # with those that wait

    @unittest.skipIf(os.environ.get("MESHGAUGE_SANITIZED"), "UBSan takes an object for invalid when no descriptor is left")
    def test_unfinished_handshakes_give_way_to_finished_ones(self):
        server, steady = self.start("--workers", "1")
        idle = [self.steady(server) for _ in range(5)]
        for one in idle:
            self.assertEqual(one.get("/healthz").status, 200)
        most = len(os.listdir("/proc/%d/fd" % server.process.pid)) + 8
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (most, most))
        for sent in (b"", recorded_hello()[:1]):
            before = steady.counts()[3]
            self.flood(server, self.ATTACKER, 30, sent)
            until(lambda: steady.counts()[3] >= before + 10)
            for one in idle:
                self.assertEqual(one.get("/healthz").status, 200)


if __name__ == "__main__":
    unittest.main()
