"""The service as an attacker sees it. After every test the next request is served (ServerCase.tearDown)."""

import gzip
import socket
import struct
import unittest

from harness import (RAISED, SQUARE, Server, ServerCase, comparison, multipart, post_head, read_answer)


class Meshes(ServerCase):
    flags = ("--max-part-bytes", "1000000", "--max-request-bytes", "2500000", "--max-triangles", "1000")

    def part_refused(self, mesh, status, slug, where=None):
        for part in ("a", "b"):
            problem = self.refused(self.server.compare(**{part: mesh}), status, slug)
            self.assertEqual([error["part"] for error in problem["errors"]], [part])
            self.assertIn("'%s'" % part, problem["detail"])
            if where is not None:
                self.assertEqual(problem["errors"][0]["where"], where)

    def test_empty(self):
        self.part_refused(b"", 422, "empty-mesh")
        self.part_refused(b"v 0 0 0\n", 422, "empty-mesh")

    def test_not_a_mesh(self):
        body = multipart([("a", b"\x89PNG\r\n\x1a\n" + bytes(range(256))), ("b", SQUARE)])
        answer = self.server.raw(post_head(len(body)) + body)
        self.assertIn(answer.status, (415, 422))
        self.assertEqual(answer.json()["errors"][0]["part"], "a")

    def test_nan_and_infinity(self):
        self.part_refused(SQUARE.replace(b"v 1 1 0", b"v 1 nan 0"), 422, "non-finite-vertex", "line 3")
        self.part_refused(SQUARE.replace(b"v 1 1 0", b"v 1 inf 0"), 422, "non-finite-vertex", "line 3")
        self.part_refused(SQUARE.replace(b"v 1 1 0", b"v 1 1e999 0"), 422, "non-finite-vertex", "line 3")

    def test_index_out_of_range(self):
        self.part_refused(SQUARE.replace(b"f 1 3 4", b"f 1 3 5"), 422, "index-out-of-range", "line 6")
        self.part_refused(SQUARE.replace(b"f 1 3 4", b"f 1 3 -9"), 422, "index-out-of-range", "line 6")
        self.part_refused(SQUARE.replace(b"f 1 3 4", b"f 0 3 4"), 422, "index-out-of-range", "line 6")

    def test_malformed_numbers(self):
        self.part_refused(SQUARE.replace(b"v 1 1 0", b"v 1 2,5 0"), 422, "unreadable-mesh", "line 3")
        self.part_refused(SQUARE.replace(b"v 1 1 0", b"v 1"), 422, "unreadable-mesh", "line 3")

    def test_too_large_a_coordinate(self):
        self.part_refused(SQUARE.replace(b"v 1 1 0", b"v 1 1e308 0"), 422, "coordinate-too-large")

    def test_truncated_binary_stl(self):
        stl = b"\0" * 80 + struct.pack("<I", 2) + b"\0" * 50
        body = comparison(a=stl).replace(b"a.obj", b"a.stl")
        problem = self.server.raw(post_head(len(body)) + body).json()
        self.assertEqual(problem["status"], 422, problem)
        self.assertEqual(problem["errors"][0]["part"], "a")

    def test_a_count_that_lies(self):
        ply = (b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty double x\nproperty double y\n"
               b"property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n")
        problem = self.server.compare(b=ply).json()
        self.assertIn(problem["status"], (413, 422))
        self.assertEqual(problem["errors"][0]["part"], "b")

    def test_too_many_triangles(self):
        self.part_refused(SQUARE + b"f 1 2 3\n" * 1000, 413, "too-large")

    def test_gzip_bomb(self):
        bomb = gzip.compress(b"#" * 200_000_000, 1)
        problem = self.server.compare(a=bomb).json()
        self.assertIn(problem["status"], (413, 422))
        self.assertEqual(problem["errors"][0]["part"], "a")

    def test_a_gzip_that_is_cut_anywhere(self):
        whole = gzip.compress(SQUARE)
        self.assertEqual(self.server.compare(a=whole).status, 200)
        for length in range(1, len(whole), 7):
            self.assertIn(self.server.compare(a=whole[:length]).status, (415, 422))

    def test_oversized_part(self):
        problem = self.refused(self.server.compare(b=b"#" * 1_000_001), 413, "too-large")
        self.assertEqual(problem["errors"][0]["part"], "b")
        self.assertIn("1000000 bytes", problem["detail"])


class Options(ServerCase):
    def test_what_is_refused(self):
        for options, where in ((b"", "byte"), (b"nonsense", "byte"), (b"[]", ""), (b'{"tolerance": {"absolut": 1}}', "/tolerance/absolut"),
                               (b'{"strategy": "fastest"}', "/strategy"), (b'{"timeout_ms": 1e3}', "/timeout_ms"),
                               (b'{"timeout_ms": 180001}', "/timeout_ms"), (b'{"threads": 65}', "/threads"),
                               (b'{"tolerance": {"relative": -1}}', "/tolerance/relative"), (b'{"a": 1, "a": 2}', "/a"),
                               (b"[" * 60000, ""), (b'{"tolerance": {"relative": NaN}}', "byte")):
            problem = self.refused(self.server.compare(options=options), 422, "invalid-request")
            self.assertEqual(problem["errors"][0]["part"], "options", options)
            self.assertTrue(problem["errors"][0]["where"].startswith(where), problem)

    def test_too_long(self):
        self.refused(self.server.compare(options=b" " * 70000 + b"{}"), 413, "too-large")


class Requests(ServerCase):
    flags = ("--max-part-bytes", "1000000", "--max-request-bytes", "2000000")

    def malformed(self, data, status=400, slug="malformed-request"):
        answer = self.server.raw(data)
        self.assertEqual(answer.headers.get("connection"), "close", data[:200])
        return self.refused(answer, status, slug)

    def test_malformed_heads(self):
        for data in (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", b"GET / HTTP/1.1\nHost: x\n\n", b"GET\r\n\r\n",
                     b"GET / HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\nHost: localhost\r\nHost: y\r\n\r\n",
                     b"GET / HTTP/1.1\r\nHost: localhost\r\nBad Header: y\r\n\r\n", b"GET / HTTP/1.1\r\nHost: localhost\r\nA: \x00\r\n\r\n"):
            self.malformed(data)
        self.malformed(b"GET / HTTP/3\r\n\r\n", 505, "http-version")
        self.malformed(b"FOO / HTTP/1.1\r\nHost: localhost\r\n\r\n", 501, "not-implemented")

    def test_long_heads(self):
        self.malformed(b"GET /" + b"a" * 8000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n", 414, "uri-too-long")
        self.malformed(b"a" * 100_000, 414, "uri-too-long")
        self.malformed(b"GET / HTTP/1.1\r\nHost: localhost\r\nA: " + b"b" * 20_000 + b"\r\n\r\n", 431, "head-too-large")
        self.malformed(b"GET / HTTP/1.1\r\nHost: localhost\r\n" + b"A: b\r\n" * 5000, 431, "head-too-large")

    def test_lengths(self):
        self.malformed(b"POST /v1/comparisons HTTP/1.1\r\nHost: localhost\r\n\r\n", 411, "length-required")
        self.malformed(post_head(2_000_001), 413, "too-large")
        self.malformed(post_head(10 ** 30), 413, "too-large")
        self.malformed(post_head(-1))
        self.malformed(post_head(5, "Content-Length: 5\r\n"))
        self.malformed(post_head(5, "Content-Encoding: gzip\r\n"), 415, "unsupported-media-type")
        self.malformed(post_head(5).replace(b"multipart/form-data", b"text/plain"), 415, "unsupported-media-type")
        self.malformed(post_head(5).replace(b"; boundary=XXboundaryXX", b""))

    def test_an_oversized_body_is_refused_before_it_is_sent(self):
        with self.server.connect() as connection:
            connection.sendall(post_head(10 ** 12))
            self.assertEqual(read_answer(connection.makefile("rb")).status, 413)

    def test_oversized_chunks(self):
        head = post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding: chunked")
        self.malformed(head + b"ffffffffffffffff\r\n", 413, "too-large")
        self.malformed(head + b"1" * 5000)
        preamble = b'--XXboundaryXX\r\nContent-Disposition: form-data; name="x%d"\r\n\r\n'
        unknown = head + b"%x\r\n" % len(preamble % 1) + preamble % 1 + b"\r\n0\r\n\r\n"
        self.refused(self.server.raw(unknown), 400, "malformed-request")
        part = b'--XXboundaryXX\r\nContent-Disposition: form-data; name="a"\r\n\r\n'
        self.malformed(head + b"%x\r\n" % len(part) + part + b"\r\n" + (b"ffff\r\n" + b"x" * 65535 + b"\r\n") * 40, 413, "too-large")

    def test_smuggling(self):
        """The bytes after a request whose end is in doubt are never taken for a second one."""
        hidden = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
        chunked = b"0\r\n\r\n" + hidden
        attempts = (
            post_head(len(chunked), "Transfer-Encoding: chunked\r\n") + chunked,
            post_head(0, "Transfer-Encoding: chunked\r\n") + chunked,
            post_head(3, "Content-Length: 300\r\n") + b"abc" + hidden,
            post_head(3).replace(b"Content-Length:", b"Content-Length :") + b"abc" + hidden,
            post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding:\x0bchunked") + chunked,
            post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding: chunked, identity") + chunked,
            post_head(0).replace(b"Content-Length: 0", b"X: y\n Transfer-Encoding: chunked") + chunked,
            # A body that no handler reads: a method or a path that takes none.
            b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n" % len(hidden) + hidden,
            b"POST /none HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n" % len(hidden) + hidden,
            post_head(len(hidden)).replace(b"multipart/form-data", b"text/plain") + hidden,
        )
        for attempt in attempts:
            with self.server.connect() as connection:
                connection.sendall(attempt)
                stream = connection.makefile("rb")
                first = read_answer(stream)
                self.assertIsNotNone(first, attempt)
                self.assertEqual(first.headers.get("connection"), "close", attempt)
                self.assertIsNone(read_answer(stream), attempt)

    def test_truncated_bodies(self):
        body = comparison()
        for length in range(0, len(body) - 2, 17):
            with self.server.connect() as connection:
                connection.sendall(post_head(len(body)) + body[:length])
                connection.shutdown(socket.SHUT_WR)
                answer = read_answer(connection.makefile("rb"))
                self.assertEqual(answer.status, 400)
            cut = body[:length]
            self.malformed_or_closed(post_head(len(cut)) + cut)

    def malformed_or_closed(self, data):
        self.assertEqual(self.server.raw(data).status, 400)

    def test_parts(self):
        mesh = ("a", SQUARE), ("b", RAISED), ("options", b"{}")
        for parts, part in ((mesh[:1], "b"), (mesh[1:], "a"), (mesh + mesh[:1], "a"), (mesh + mesh[2:], "options"),
                            (mesh + (("c", b""),), "c")):
            body = multipart(parts)
            problem = self.refused(self.server.raw(post_head(len(body)) + body), 400, "malformed-request")
            self.assertEqual(problem["errors"][0]["part"], part)
        many = multipart([("a%d" % i, b"") for i in range(5000)])
        self.refused(self.server.raw(post_head(len(many)) + many), 400, "malformed-request")

    def test_a_file_name_is_only_a_hint(self):
        body = comparison().replace(b'filename="a.obj"', b'filename="../../../../etc/passwd"')
        self.assertEqual(self.server.raw(post_head(len(body)) + body).status, 200)

    def test_a_query_is_not_ignored(self):
        body = comparison()
        self.malformed((post_head(len(body)) + body).replace(b"/v1/comparisons", b"/v1/comparisons?wait=5", 1))

    def test_control_characters_are_not_echoed_in_heads(self):
        answer = self.server.get("/%0d%0aSet-Cookie:%20x=1")
        self.assertNotIn("set-cookie", answer.headers)


class Slow(ServerCase):
    flags = ("--head-timeout-ms", "700", "--body-timeout-ms", "700", "--keep-alive-ms", "700", "--io-threads", "8", "--max-event-streams", "0",
             "--workers", "1", "--queue", "1")

    def dribble(self, connection):
        """One byte each 50 ms for 20 s or more. Whether the server had enough before."""
        connection.settimeout(0.05)
        for _ in range(400):
            try:
                connection.sendall(b"x")
                connection.recv(1, socket.MSG_PEEK)
            except TimeoutError:
                continue
            except OSError:
                pass
            connection.settimeout(60)
            return True
        return False

    def test_a_slow_head(self):
        with self.server.connect() as connection:
            connection.sendall(b"GET / HTTP/1.1\r\nX: ")
            self.assertTrue(self.dribble(connection))
            self.refused(read_answer(connection.makefile("rb")), 408, "request-timeout")

    def test_a_slow_body(self):
        with self.server.connect() as connection:
            connection.sendall(post_head(100_000) + comparison()[:100])
            self.assertTrue(self.dribble(connection))
            self.refused(read_answer(connection.makefile("rb")), 408, "request-timeout")

    def test_slow_clients_do_not_keep_others_out(self):
        slow = [self.server.connect() for _ in range(8)]
        for connection in slow:
            connection.sendall(b"GET / HTTP/1.1\r\nX: ")
        self.assertEqual(self.server.get("/healthz").status, 200)
        for connection in slow:
            connection.close()

    def test_a_silent_connection_is_closed(self):
        with self.server.connect() as connection:
            self.assertEqual(connection.recv(1), b"")

    def test_a_reset_connection(self):
        for data in (b"", b"GET / HT", post_head(1000) + b"--XX", post_head(len(comparison())) + comparison()):
            connection = self.server.connect()
            connection.sendall(data)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.close()


class NoDisk(unittest.TestCase):
    def test_uploads_leave_no_names_behind(self):
        import os
        import tempfile
        with tempfile.TemporaryDirectory() as folder:
            server = Server("--temp-dir", folder)
            self.assertEqual(server.compare(a=SQUARE + b"#" * 2_000_000).status, 200)
            self.assertEqual(os.listdir(folder), [])
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main()
