"""Services that cannot be reached, break, stall, or are something else altogether: a clear error or, where it passes, a
verdict; never a crash."""

import email.utils
import itertools
import json
import shlex
import subprocess
import tempfile
import threading
import time
import unittest
import unittest.mock
from pathlib import Path

import gates
from gates import MEGABYTE, FlakyProxy, Relay, Run, Stub, gate, measure, requests, url_of, without_chance
from harness import RAISED, SQUARE, Server, ServerCase, until, wavy_grid
from test_tls import make_certificate

SHORT = {"retry_ms": 1500, "first_contact_ms": 300, "connect_timeout_ms": 60_000}  # an answer that comes is waited for


class Trouble(ServerCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.gates = [self.gate(i) for i in range(4)]

    def gate(self, i):
        for name, data in (("%d.obj" % i, RAISED), ("base%d.obj" % i, SQUARE)):
            (self.folder / name).write_bytes(b"# %s %d\n" % (self.id().encode(), i) + data)
        return gate("gate %d" % i, self.folder / ("%d.obj" % i), self.folder / ("base%d.obj" % i))

    def assert_decided(self, outcomes):
        self.assertEqual({(o["verdict"], o["error"]) for o in outcomes.values()}, {("fail", None)})

    def errors(self, url, environment=None, **service):
        """Asserts that every gate has an error, in one line of a bounded length."""
        run = Run(self.gates, {**SHORT, "url": url, **service}, environment)
        outcomes = run.ended()
        self.assertEqual({o["verdict"] for o in outcomes}, {"error"}, outcomes)
        for outcome in outcomes:
            self.assertLess(len(outcome["error"]), 1000)
            self.assertTrue(outcome["error"].isprintable(), outcome["error"])
        self.assertTrue(run.takes_little(), run.peak)
        return [o["error"] for o in outcomes]

    def assert_errors(self, text, url, **service):
        for error in self.errors(url, **service):
            self.assertIn(text, error)


class Addresses(Trouble):
    flags = ("--allowed-hosts", "service.invalid")  # behind a proxy, a name that this machine does not know

    def test_an_address_that_does_not_listen(self):
        with Stub(list) as stub:
            pass
        self.assert_errors("cannot be reached: ", url_of(stub))

    def test_no_such_host(self):
        self.assert_errors("cannot be reached: ", "http://nowhere.invalid", connect_timeout_ms=1000)

    def test_not_an_address(self):
        for url in ("localhost:8080", "ftp://localhost", "http://user:sesame@localhost", "http://"):
            with self.subTest(url):
                refused = Run(self.gates, {"url": url}).ended()
                self.assertIn("--server", refused)
                self.assertNotIn("sesame", refused)

    def test_a_path_in_front(self):
        def strip(handler, seen):
            self.assertTrue(handler.path.startswith("/prefix/v1/"), handler.path)
            handler.path = handler.path.removeprefix("/prefix")
            return False
        with Relay(self.server.port, strip) as relay:
            self.assert_decided(measure(self.gates, {"url": url_of(relay) + "/prefix/"}))

    def test_a_proxy_of_the_environment(self):
        with Relay(self.server.port) as relay:
            outcomes = measure(self.gates, {"url": "http://service.invalid"}, {"http_proxy": url_of(relay)})
            self.assert_decided(outcomes)
            self.assertEqual(relay.seen[("POST", "/v1/batches")], 1)

    def test_a_key_to_this_machine_passes_no_proxy(self):
        with Relay(self.server.port) as relay:
            proxy = {"http_proxy": url_of(relay), "no_proxy": ""}
            self.assert_decided(measure(self.gates, {"url": url_of(self.server)}, {**proxy, "MESHGAUGE_KEY": "mg_key"}))
            self.assertEqual(relay.seen, {})
            self.assert_decided(measure(self.gates, {"url": url_of(self.server)}, proxy))
            self.assertNotEqual(relay.seen, {})

    def test_a_key_in_clear_to_another_machine(self):
        refused = Run(self.gates, {"url": "http://service.invalid"}, {"MESHGAUGE_KEY": "mg_key"}).ended()
        self.assertIn("--key-in-clear", refused)

    def test_a_comparison_that_was_out_of_time_is_not_asked_for_again(self):
        problem = {"type": "/problems/out-of-time", "title": "t", "status": 503,
                   "detail": "timed out before 'a' was read", "errors": []}
        with Relay(self.server.port) as relay:
            relay.change_results(lambda line: {**line, "state": "failed", "result": None, "problem": problem})
            for outcome in measure(self.gates, {**SHORT, "url": url_of(relay)}).values():
                self.assertEqual(outcome["verdict"], "undecided", outcome)
            self.assertEqual(relay.seen[("POST", "/v1/batches")], 1)


class Retries(Trouble):
    def once(self, status, headers=None, method="POST"):
        """The first request of this method is refused, with headers of that moment; how much later the next one came."""
        times = []

        def refuse(handler, seen):
            if handler.command != method or seen > 1:
                return False
            times.append(time.monotonic())
            if seen == 0:
                handler.answer(status, headers() if headers else {}, b"")
            return seen == 0
        with Relay(self.server.port, refuse) as relay:
            self.assert_decided(measure(self.gates[:1], {"url": url_of(relay)}))
        return times[1] - times[0]

    def test_statuses(self):
        cases = [(status, "POST") for status in (408, 429, 500, 502, 503, 504, 507)] + [(503, "HEAD"), (503, "PUT")]
        for status, method in cases:
            with self.subTest(status=status, method=method):
                self.gates = [self.gate(status * 10 + len(method))]
                self.once(status, method=method)

    def test_retry_after_in_seconds(self):
        self.assertGreaterEqual(self.once(503, lambda: {"Retry-After": "2"}), 2)

    def test_retry_after_as_a_date(self):
        self.assertGreaterEqual(self.once(429, lambda: {"Retry-After": email.utils.formatdate(time.time() + 3, usegmt=True)}), 1)

    def test_a_service_that_wants_to_be_left_alone_for_a_day(self):
        def refuse(handler, seen):
            handler.answer(503, {"Retry-After": "86400"}, b"")
            return True
        with Relay(self.server.port, refuse) as relay:
            self.assert_errors("it answers 503", url_of(relay))

    def test_patience_ends(self):
        def refuse(handler, seen):
            handler.answer(503, {}, b"")
            return True
        with Relay(self.server.port, refuse) as relay:
            self.assert_errors("it answers 503", url_of(relay), retry_ms=3000)
            self.assertGreater(relay.seen[("PUT", "/v1/meshes")], 4)

    def test_a_gates_timeout_bounds_all_tries(self):
        def refuse(handler, seen):
            handler.answer(503, {}, b"")
            return True
        for each in self.gates:
            each["options"]["timeout_ms"] = 3000
        with Relay(self.server.port, refuse) as relay:
            self.errors(url_of(relay), retry_ms=300_000, patience_ms=0)
            # The first pause is 100 ms at least, and each twice as long as the one before.
            self.assertLessEqual(max(relay.seen.values()), 5 * len(self.gates))

    def test_what_does_not_pass_is_not_tried_again(self):
        def refuse(handler, seen):
            handler.answer(400, {}, b"")
            return True
        with Relay(self.server.port, refuse) as relay:
            self.assert_errors("it answers 400", url_of(relay))
            self.assertEqual(relay.seen, {("HEAD", "/v1/meshes"): 4, ("PUT", "/v1/meshes"): 4})

    def test_an_answer_that_is_lost_is_not_computed_again(self):
        for measured in (self.gates, [self.gate(9)]):
            with self.subTest(len(measured)):
                self.lose_answers(measured)

    def lose_answers(self, measured):
        lost = []

        def lose(handler, seen):
            if handler.command != "POST" or seen % 2:
                return False
            self.relay.forward(handler)
            lost.append(handler.headers["Idempotency-Key"])
            handler.drop()
            return True
        before = self.jobs()
        with Relay(self.server.port, lose) as self.relay:
            self.assert_decided(measure(measured, {"url": url_of(self.relay)}))
            keys = [h["Idempotency-Key"] for m, p, h in self.relay.headers if m == "POST" and p == "/v1/batches"]
        self.assertGreater(len(lost), 0)
        self.assertEqual(len(set(keys)), 1)
        until(lambda: self.jobs() - before >= len(measured))
        self.assertEqual(self.jobs() - before, len(measured))

    def jobs(self):
        lines = self.server.get("/metrics").body.decode().splitlines()
        return sum(float(line.rsplit(" ", 1)[1]) for line in lines if line.startswith("meshgauge_jobs_total"))


class Broken(Trouble):
    def test_connections_that_break_and_stall(self):
        gates = [self.gate(i) for i in range(12)]
        (self.folder / "wave.obj").write_bytes(wavy_grid(40, 0.1))
        gates.append(gate("larger", self.folder / "wave.obj", self.folder / "base0.obj", max_distance=0.01))
        here = measure(gates)
        for seed in (1, 2):
            with self.subTest(seed), FlakyProxy(self.server.port, seed) as proxy:
                there = measure(gates, {"url": url_of(proxy), "stall_s": 1, "patience_ms": 300_000})
                self.assertGreater(proxy.broken, 0)
                for name, outcome in here.items():
                    self.assertIsNone(there[name]["error"])
                    self.assertEqual(without_chance(there[name]["document"]), without_chance(outcome["document"]))

    def test_an_answer_for_something_else(self):
        answer = self.server.compare(SQUARE, RAISED).body

        def confuse(handler, seen):
            if handler.command == "POST":
                handler.answer(200, {"Content-Type": "application/json"}, answer)
            return handler.command == "POST"
        with Relay(self.server.port, confuse) as relay:
            self.assert_errors("its answer is not that to this batch", url_of(relay))


class Strangers(Trouble):
    """What may listen at an address instead of a service."""

    def stub(self, text, piece=b"", times=1, pause=0.0):
        def answer():
            yield text.encode()
            yield from itertools.repeat(piece, times)
        with Stub(answer, pause) as stub:
            return self.errors(url_of(stub), **({"stall_s": 1} if pause else {}))

    def test_not_http(self):
        for error in self.stub("SSH-2.0-OpenSSH_9.2\r\n"):
            self.assertIn("does not answer: ", error)

    def test_a_web_page(self):
        page = "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nContent-Length: 6\r\nConnection: close\r\n\r\n<html>"
        for error in self.stub(page):
            self.assertIn("does not answer as a meshgauge service", error)

    def test_a_redirection_for_ever(self):
        def redirect(handler, seen):
            handler.answer(308, {"Location": "http://127.0.0.1:%d%s" % (relay.port, handler.path)}, b"")
            return True
        with Relay(self.server.port, redirect) as relay:
            self.assert_errors("it redirects to http://127.0.0.1:%d/v1/" % relay.port, url_of(relay))
            self.assertEqual(relay.seen[("PUT", "/v1/meshes")], 4)

    def test_an_endless_body(self):
        head = "HTTP/1.1 404 Not Found\r\nContent-Type: text/html\r\nConnection: close\r\n\r\n"
        for error in self.stub(head, b"x" * MEGABYTE, 300):
            self.assertIn("larger than 4194304 bytes", error)

    def test_a_length_beyond_the_limit(self):
        """Refused from the head alone: the body never comes."""
        head = "HTTP/1.1 404 Not Found\r\nContent-Type: text/html\r\nContent-Length: 5000000000\r\n\r\n"
        for error in self.stub(head, b"x", 1, pause=20):
            self.assertIn("larger than 4194304 bytes", error)

    def test_an_endless_head(self):
        self.stub("HTTP/1.1 200 OK\r\n", b"X: %s\r\n" % (b"y" * 1000), 300_000)

    def test_a_header_line_without_an_end(self):
        self.stub("HTTP/1.1 200 OK\r\nX: ", b"y" * MEGABYTE, 300)

    def test_interim_answers_for_ever(self):
        self.stub("", b"HTTP/1.1 102 Processing\r\n\r\n" * 100, 10_000)

    def test_a_byte_now_and_then(self):
        head = "HTTP/1.1 200 OK\r\nContent-Length: 1000\r\nConnection: close\r\n\r\n"
        for error in self.stub(head, b"x", 1000, pause=0.1):
            self.assertIn("does not answer: ", error)

    def test_silence(self):
        for error in self.stub("", pause=20):
            self.assertIn("does not answer: ", error)

    def test_a_connection_that_is_closed_at_once(self):
        for error in self.stub(""):
            self.assertIn("does not answer: ", error)

    def answers(self, status, body, kind="application/json"):
        """Answers every request for a batch like this, after the files were taken."""
        def answer(handler, seen):
            if handler.command in ("POST", "GET", "DELETE"):
                handler.answer(status, {"Content-Type": kind}, body)
            return handler.command in ("POST", "GET", "DELETE")
        with Relay(self.server.port, answer) as relay:
            return self.errors(url_of(relay))

    def test_answers_that_are_none(self):
        deep = b"[" * 100_000 + b"]" * 100_000
        comparison = json.loads(self.server.compare(SQUARE, RAISED).body)
        counts = {"total": 1, "queued": 1, "running": 0}
        bodies = [b"", b"null", b"{}", b"\xff\xfe", b'{"id": 7}', deep, b'{"result": ' + deep + b"}", b"1e99999",
                  json.dumps({**comparison, "status": "\x1b[31mconverged"}).encode(),
                  json.dumps({"id": comparison["id"], "state": "\x1b[31mdone", "counts": counts}).encode(),
                  json.dumps({"id": comparison["id"], "state": "finished", "counts": counts}).encode(),
                  json.dumps({"id": "../../etc/passwd", "state": "running", "counts": counts}).encode()]
        self.gates = self.gates[:1]
        for status, body in [(204, b""), (304, b""), *itertools.product((200, 202), bodies)]:
            with self.subTest(status=status, body=body[:40]):
                for error in self.answers(status, body):
                    self.assertIn("does not answer as a meshgauge service", error)

    def test_words_that_a_terminal_or_a_log_would_obey(self):
        problem = {"type": "/problems/forbidden", "detail": "\x1b]0;x\x07\n::error::" + "x" * 100_000,
                   "errors": [{"part": "\x1b[31m", "where": 7}]}
        for error in self.answers(403, json.dumps(problem).encode(), "application/problem+json"):
            self.assertIn("::error::xxx", error)


class Certificates(Trouble):
    @classmethod
    def setUpClass(cls):
        cls.certificates = tempfile.TemporaryDirectory()
        cls.ca = Path(cls.certificates.name) / "c.pem"
        make_certificate(Path(cls.certificates.name))
        super().setUpClass()
        cls.tls = Server("--tls-certificate", str(cls.ca), "--tls-key", str(Path(cls.certificates.name) / "k.pem"))

    @classmethod
    def tearDownClass(cls):
        cls.tls.stop()
        super().tearDownClass()
        cls.certificates.cleanup()

    def test_one_that_is_trusted(self):
        self.assert_decided(measure(self.gates, {"url": url_of(self.tls, "localhost", "https"), "ca_file": str(self.ca)}))

    def test_one_that_is_not(self):
        self.assert_errors("does not answer: SSL certificate problem", url_of(self.tls, "localhost", "https"))

    def measure_where_all_trust_it(self):
        """A program that measures where the machine's own certificates are the service's alone."""
        trusted = self.folder / "trusted"
        trusted.mkdir()
        shown = subprocess.run(["openssl", "x509", "-hash", "-noout", "-in", self.ca], check=True, capture_output=True)
        for name in ("ca-certificates.crt", shown.stdout.decode().strip() + ".0"):
            (trusted / name).write_bytes(self.ca.read_bytes())
        inside = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c",
                  'mount --bind "$1" /etc/ssl/certs && shift && exec "$@"', "sh", str(trusted)]
        try:
            subprocess.run([*inside, "true"], check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            self.skipTest("no name space of its own is to be had here")
        program = self.folder / "measure"
        program.write_text("#!/bin/sh\nexec %s\n" % shlex.join([*inside, gates.MEASURE]))
        program.chmod(0o755)
        return str(program)

    def test_a_file_of_certificates_is_in_place_of_the_machines(self):
        other = self.folder / "other"
        other.mkdir()
        make_certificate(other)
        url = url_of(self.tls, "localhost", "https")
        with unittest.mock.patch("gates.MEASURE", self.measure_where_all_trust_it()):
            self.assert_decided(measure(self.gates, {"url": url}))
            self.assert_errors("SSL certificate problem", url, ca_file=str(other / "c.pem"))

    def test_one_for_another_name(self):
        self.assert_errors("does not answer: SSL: ", url_of(self.tls, "127.0.0.1", "https"), ca_file=str(self.ca))

    def test_a_file_of_certificates_that_is_none(self):
        (self.folder / "no.pem").write_text("no")
        for name in ("no.pem", "nowhere.pem"):
            self.assert_errors("--ca-file", url_of(self.tls, "localhost", "https"), ca_file=str(self.folder / name))

    def test_where_none_is_spoken(self):
        self.assert_errors("wrong version number", url_of(self.server, "localhost", "https"))

    def test_where_it_is_not_expected(self):
        self.assert_errors("this port speaks TLS: use https", url_of(self.tls, "localhost"))


if __name__ == "__main__":
    unittest.main()
