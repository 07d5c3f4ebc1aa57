"""Attacks on HTTP itself, one connection at a time, by raw sockets; docs/http_edge.md lists them.

After every test the next request is served, and the service has kept no memory of it."""

import contextlib
import gzip
import json
import os
import pathlib
import re
import select
import socket
import unittest

from harness import RAISED, ROOT, SQUARE, ServerCase, comparison, multipart, post_head, read_answer

SANITIZED = os.environ.get("MESHGAUGE_SANITIZED") == "1"
MOST_KB = 64 << 10  # that an attack may cost while it lasts; what it sends is several times that
FLOOD_BYTES = 300_000_000
GET = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"


class EdgeCase(ServerCase):
    flags = ("--head-timeout-ms", "1000", "--body-timeout-ms", "1000", "--grace-ms", "1000",
             "--max-part-bytes", "1000000", "--max-request-bytes", "2000000")

    def memory_kb(self, field):
        return int(re.search(field + r":\s+(\d+)", pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text())[1])

    def setUp(self):
        pathlib.Path(f"/proc/{self.server.process.pid}/clear_refs").write_text("5")  # the peak starts anew
        self.resident_kb = self.memory_kb("VmRSS")

    def tearDown(self):
        super().tearDown()
        if not SANITIZED:  # which keep what was freed
            self.assertLess(self.memory_kb("VmHWM") - self.resident_kb, MOST_KB)

    def flood(self, start, piece, most=FLOOD_BYTES):
        """Sends `start`, then `piece` again and again until there is an answer. The answer, and what the server took."""
        with self.server.connect() as connection:
            connection.sendall(start)
            sent = 0
            while sent < most and not select.select([connection], [], [], 0)[0]:
                sent += connection.send(piece)
            connection.shutdown(socket.SHUT_WR)
            return read_answer(connection.makefile("rb")), sent

    def refused_and_closed(self, data, status, slug):
        """Asserts that all these bytes get one answer, this problem, and that the connection is closed."""
        with self.server.connect() as connection:
            connection.sendall(data)
            stream = connection.makefile("rb")
            answer = read_answer(stream)
            problem = self.refused(answer, status, slug)
            self.assertEqual(answer.headers.get("connection"), "close", data[:200])
            self.assertIsNone(read_answer(stream), data[:200])
            return problem

    def chunked(self, extra=""):
        return post_head(0, extra).replace(b"Content-Length: 0", b"Transfer-Encoding: chunked")


class Heads(EdgeCase):
    def test_a_line_without_end(self):
        for start, status, slug in ((b"", 414, "uri-too-long"), (b"GET /", 414, "uri-too-long"), (GET, 431, "head-too-large"),
                                    (GET + b"X: ", 431, "head-too-large")):
            answer, sent = self.flood(start, b"x" * 65536)
            self.refused(answer, status, slug)
            self.assertLess(sent, FLOOD_BYTES)

    def test_headers_without_end(self):
        answer, _ = self.flood(GET, b"a:b\r\n" * 10_000)
        self.refused(answer, 431, "head-too-large")

    def test_empty_lines_without_end(self):
        answer, _ = self.flood(b"", b"\r\n" * 100, most=10 ** 12)
        self.refused(answer, 408, "request-timeout")

    def test_what_is_not_a_request(self):
        for data in (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(500) + b"\r\n\r\n",  # TLS
                     b"SSH-2.0-OpenSSH_9.2\r\n\r\n", bytes(range(256)) * 4 + b"\r\n\r\n", b"GET /\r\n\r\n",  # HTTP/0.9
                     b"GET\t/\tHTTP/1.1\r\nHost: localhost\r\n\r\n", b"GET / HTTP/1.1\nHost: x\n\n", b"GET /\x00 HTTP/1.1\r\nHost: localhost\r\n\r\n",
                     b"CONNECT example.org:443 HTTP/1.1\r\nHost: localhost\r\n\r\n", b" GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"):
            self.refused_and_closed(data, 400, "malformed-request")
        self.refused_and_closed(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 400, "malformed-request")  # TLS: the end of no head
        preface = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\0\0\0\x04\0\0\0\0\0"  # HTTP/2 by prior knowledge
        self.refused_and_closed(preface, 505, "http-version")
        self.refused_and_closed(b"TRACE / HTTP/1.1\r\nHost: localhost\r\nCookie: secret\r\n\r\n", 501, "not-implemented")

    def test_headers_that_two_parsers_could_read_differently(self):
        for field in (b"Host: y\r\n", b"X: a\r\n folded\r\n", b"X: a\r\n\tfolded\r\n", b"X: a\rHost: y\r\n", b"X: a\nHost: y\r\n",
                      b"X: a\x00b\r\n", b"X\x00: a\r\n", b"X : a\r\n", b": a\r\n", b"X\r\n", b"Expect: 200-ok\r\n",
                      b"Expect: 100-continue\r\nExpect: 100-continue\r\n"):
            self.refused_and_closed(GET + field + b"\r\n", 400, "malformed-request")

    def test_other_forms_of_a_target(self):
        for target in (b"http://other.example/healthz", b"http://[::1]:80/healthz"):
            self.assertEqual(self.server.raw(b"GET " + target + b" HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 200)
        root = self.server.raw(b"GET http://other.example?x=/metrics HTTP/1.1\r\nHost: localhost\r\n\r\n")
        self.assertEqual(root.status, 200)
        self.assertNotIn(b"meshgauge_requests_total", root.body)
        for target in (b"http://user@localhost/healthz", b"http:///healthz", b"/healthz|", b"/%zz", b"/healthz?x=[", b"*"):
            self.refused_and_closed(b"GET " + target + b" HTTP/1.1\r\nHost: localhost\r\n\r\n", 400, "malformed-request")
        for target in (b"/healthz%00", b"/healthz/..", b"/./healthz", b"//healthz", b"/%68ealthz", b"/healthz;a=b"):
            self.refused(self.server.raw(b"GET " + target + b" HTTP/1.1\r\nHost: localhost\r\n\r\n"), 404, "not-found")

    def test_an_older_client_is_answered_once(self):
        with self.server.connect() as connection:
            connection.sendall(b"GET /healthz HTTP/1.0\r\nConnection: keep-alive\r\n\r\n" * 2)
            stream = connection.makefile("rb")
            answer = read_answer(stream)
            self.assertEqual((answer.status, answer.headers.get("connection")), (200, "close"))
            self.assertIsNone(read_answer(stream))

    def test_an_encoded_line_break_stays_encoded(self):
        for head in (b"GET /%0d%0aSet-Cookie:%20x=1 HTTP/1.1\r\nHost: localhost\r\n\r\n", b"GET /?a=%0d%0aX: HTTP/1.1\r\nHost: localhost\r\n\r\n",
                     GET + b"X: %0d%0aSet-Cookie: x=1\r\n\r\n", GET + b"Referer: http://x/%0D%0A%0D%0A{\"event\":\"x\"}\r\n\r\n"):
            with self.server.connect() as connection:
                connection.sendall(head)
                stream = connection.makefile("rb")
                answer = read_answer(stream)
                self.assertNotIn("set-cookie", answer.headers)
                self.assertNotIn("x", answer.headers)
        for line in self.server.log:
            self.assertIn(json.loads(line)["event"], ("descriptors", "memory", "request", "sandbox"))

    def test_overlapping_ranges(self):
        document = (ROOT / "openapi.yaml").read_bytes()
        for ranges in (",".join(["0-"] * 100), ",".join("%d-" % i for i in range(100)), "0-0", "-1", "9-1", "x"):
            answer = self.server.get("/openapi.yaml", extra="Range: bytes=%s\r\n" % ranges)
            self.assertEqual((answer.status, answer.body), (200, document))

    def test_garbage_after_a_request(self):
        with self.server.connect() as connection:
            connection.sendall(GET + b"\r\n" + b"\x00\xff garbage\r\n\r\n" + GET + b"\r\n")
            stream = connection.makefile("rb")
            answers = [read_answer(stream) for _ in range(3)]
            self.assertEqual([answer and answer.status for answer in answers], [200, 400, None])

    def test_a_client_that_never_reads_the_answers(self):
        connection = self.server.connect()
        connection.settimeout(1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        with self.assertRaises(TimeoutError):  # the server does not read on either
            while True:
                connection.sendall(GET.replace(b"/healthz", b"/openapi.yaml") + b"\r\n")
        self.assertEqual(self.server.get("/healthz").status, 200)
        connection.close()

    @unittest.skipIf(os.environ.get("MESHGAUGE_DOCS") == "0", "built without npm")
    def test_clients_that_never_read_a_page_hold_no_copy_of_it(self):
        with contextlib.ExitStack() as stack:
            for _ in range(150):
                connection = stack.enter_context(self.server.connect())
                connection.sendall(GET.replace(b"/healthz", b"/docs/swagger-ui-bundle.js") + b"\r\n")
                self.assertEqual(connection.recv(12, socket.MSG_PEEK | socket.MSG_WAITALL), b"HTTP/1.1 200")


class Bodies(EdgeCase):
    def test_encoded_bodies_are_refused_unread(self):
        bomb = gzip.compress(bytes(20_000_000))
        for coding in ("gzip", "deflate", "br", "zstd", "gzip, identity", "x"):
            head = post_head(len(bomb), "Content-Encoding: %s\r\n" % coding)
            self.refused(self.server.raw(head), 415, "unsupported-media-type")
            self.refused(self.server.raw(head + bomb), 415, "unsupported-media-type")
            chunked = self.chunked("Content-Encoding: %s\r\n" % coding) + b"%x\r\n" % len(bomb) + bomb + b"\r\n0\r\n\r\n"
            self.refused(self.server.raw(chunked), 415, "unsupported-media-type")

    def test_an_announced_flood_is_not_drained(self):
        for length in (2_000_001, 10 ** 12, 10 ** 30):
            answer, sent = self.flood(post_head(length), b"x" * 65536)
            self.refused(answer, 413, "too-large")
            self.assertLess(sent, 100_000_000)

    def test_chunks_without_end(self):
        part = b'--XXboundaryXX\r\nContent-Disposition: form-data; name="options"\r\n\r\n'
        start = self.chunked() + b"%x\r\n" % len(part) + part + b"\r\n"
        for piece in (b"1\r\nx\r\n" * 10_000, b"ffff\r\n" + b"x" * 65535 + b"\r\n", b"1;x=y\r\nx\r\n" * 5000):
            answer, sent = self.flood(start, piece)
            self.refused(answer, 413, "too-large")
            self.assertLess(sent, 100_000_000)

    def test_malformed_chunks(self):
        trailers = b"0\r\n" + b"T: x\r\n" * 100 + b"\r\n"
        for chunk in (b"x\r\n", b"-1\r\n", b"+1\r\nx\r\n", b"0x1\r\nx\r\n", b" 1\r\nx\r\n", b"1 \r\nx\r\n", b"\r\nx\r\n",
                      b"1" * 17 + b"\r\n", b"0" * 1000, b"1;" + b"x" * 1000, b"1;a\nb\r\nx\r\n", b"1\nx\n0\n\n\r\n", trailers,
                      b"0\r\nT: " + b"x" * 1000, b"0\r\nT: x\n\nGET / HTTP/1.1\r\n\r\n"):
            self.refused_and_closed(self.chunked() + chunk, 400, "malformed-request")
        for size in (b"ffffffffffffffff", b"1e8481"):
            self.refused_and_closed(self.chunked() + size + b"\r\n", 413, "too-large")

    def test_a_length_that_lies(self):
        body = comparison()
        self.refused(self.server.raw(post_head(len(body) + 1) + body), 408, "request-timeout")
        with self.server.connect() as connection:  # the rest is a request that never ends
            connection.sendall(post_head(len(body) - 10) + body)
            stream = connection.makefile("rb")
            answers = [read_answer(stream) for _ in range(3)]
            self.assertEqual([answer and answer.status for answer in answers], [400, 408, None])
        with self.server.connect() as connection:  # what is too much is a request of its own, and a bad one
            connection.sendall(post_head(len(body)) + body + body[:100] + b"\r\n\r\n")
            stream = connection.makefile("rb")
            answers = [read_answer(stream) for _ in range(3)]
            self.assertEqual([answer and answer.status for answer in answers], [200, 400, None])

    def test_heads_of_parts(self):
        def with_head(extra):
            body = comparison().replace(b'filename="a.obj"', extra)
            return post_head(len(body)) + body
        for extra in (b"filename*=UTF-8''" + b"%41" * 8000, b'filename="' + b"\\" * 9000 + b'"', b"x=" + b"y" * 100_000,
                      b'filename="a"\r\n' + b"X: y\r\n" * 5000):
            self.refused_and_closed(with_head(extra), 400, "malformed-request")
        self.assertEqual(self.server.raw(with_head(b"filename*=UTF-8''" + b"%0d%0a" * 500)).status, 200)

    def test_a_part_head_without_end(self):
        start = self.chunked() + b"%x\r\n" % 18 + b"--XXboundaryXX\r\nX:" + b"\r\n"
        answer, sent = self.flood(start, b"ffff\r\n" + b"x" * 65535 + b"\r\n")
        self.refused(answer, 400, "malformed-request")
        self.assertLess(sent, 100_000_000)

    def test_what_common_clients_put_around_the_parts(self):
        plain = comparison()
        body = plain[:plain.rindex(b"--XXboundaryXX--")]
        padded = plain.replace(b"--XXboundaryXX\r\n", b"--XXboundaryXX \t\r\n")
        wanted = self.distance_of(plain)
        for sent in (b"\r\n" + plain,  # UnityWebRequest, hand-written C# and JavaScript
                     b"\r\n\r\n" + plain, b"This is a multi-part message.\r\n" + plain, b"x" * 8190 + b"\r\n" + plain, padded,
                     plain + b"\r\n\r\n", plain + b"The end.\r\n" * 10_000, body + b"--XXboundaryXX--", body + b"--XXboundaryXX-- \t\r\n",
                     plain + b"--XXboundaryXX--\r\n"):
            self.assertEqual(self.distance_of(sent), wanted, sent[:100])
        with self.server.connect() as connection:  # byte by byte
            connection.sendall(post_head(len(plain) + 2))
            for byte in b"\r\n" + plain:
                connection.sendall(bytes([byte]))
            self.assertEqual(read_answer(connection.makefile("rb")).status, 200)

    def distance_of(self, body):
        answer = self.server.raw(post_head(len(body)) + body)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["distance"]

    def test_parts_are_not_lost_around_the_form(self):
        """Options before an odd first boundary, or after the closing one, would be a gate that is passed over."""
        options, meshes = multipart([("options", b'{"gate": {"max_distance": 1}}')]), multipart([("a", SQUARE), ("b", RAISED)])
        first = options[:options.rindex(b"--XXboundaryXX--")] + meshes
        for sent, saying in ((b"\n" + first, "a boundary begins a line"), (b"\xef\xbb\xbf" + first, "after byte 3 of the body"),
                             (b"x" * 9000 + b"\r\n" + first, "the body's first 8192 bytes"), (meshes + options, "after the closing one"),
                             (first.replace(b"\r\n", b"\n"), "must end with CR LF"), (b"", "no line of the body is '--XXboundaryXX'")):
            problem = self.refused(self.server.raw(post_head(len(sent)) + sent), 400, "malformed-request")
            self.assertIn(saying, problem["detail"])

    def test_a_preamble_or_blanks_without_end(self):
        for start, piece, status, slug in ((b"", b"x" * 65536, 400, "malformed-request"), (b"--XXboundaryXX", b" " * 65536, 413, "too-large"),
                                           (comparison(), b"\r\n--XXboundaryX" * 5000, 413, "too-large")):
            opening = self.chunked() + (b"%x\r\n" % len(start) + start + b"\r\n" if start else b"")
            answer, sent = self.flood(opening, b"%x\r\n" % len(piece) + piece + b"\r\n")
            self.refused(answer, status, slug)
            self.assertLess(sent, 100_000_000)

    def test_what_a_client_most_likely_meant(self):
        def said(data, status, slug):
            return self.refused(self.server.raw(data), status, slug)["detail"]

        def form(*parts):
            body = multipart(parts)
            return post_head(len(body)) + body

        head = post_head(2) + b"{}"
        both = ("multipart/form-data for files (curl -F a=@part.stl -F b=@baseline.stl)", "application/json for stored meshes")
        for kind in (b"application/x-www-form-urlencoded", b"text/plain", b""):  # curl -d '{}'
            detail = said(head.replace(b"multipart/form-data; boundary=XXboundaryXX", kind), 415, "unsupported-media-type")
            for wanted in both:
                self.assertIn(wanted, detail)
        detail = said(head.replace(b"multipart/form-data; boundary=XXboundaryXX", b"application/json"), 422, "invalid-request")
        self.assertIn("a JSON body names stored meshes: files are sent as multipart/form-data", detail)
        detail = said(head.replace(b"; boundary=XXboundaryXX", b""), 400, "malformed-request")
        self.assertIn("lacks its parameter 'boundary': do not set Content-Type by hand", detail)
        detail = said(form(("file1", SQUARE), ("file2", RAISED)), 400, "malformed-request")
        self.assertIn("unknown part 'file1'; the form holds 'file1', 'file2'; known: a and b, the meshes, options", detail)
        body = comparison(a=b"part.stl").replace(b'; filename="a.obj"', b"")
        problem = self.refused(self.server.raw(post_head(len(body)) + body), 400, "malformed-request")
        self.assertEqual(problem["detail"], "field 'a' holds the text 'part.stl', not a file: write -F a=@part.stl")
        self.assertEqual(problem["errors"][0]["part"], "a")

    def test_boundaries(self):
        for boundary in (b"", b"x" * 71, b'"x', b"a\xffb", b"a b;c"):
            head = post_head(5).replace(b"XXboundaryXX", boundary)
            self.refused_and_closed(head + b"hello", 400, "malformed-request")
        body = comparison(a=SQUARE + b"#\r\n--XXboundaryX\r\n--XXboundar" * 1000, b=RAISED)  # nearly
        problem = self.refused(self.server.raw(post_head(len(body)) + body), 422, "unreadable-mesh")
        self.assertEqual(problem["errors"][0]["where"], "line 8")  # so it is all of the file, and no boundary


if __name__ == "__main__":
    unittest.main()
