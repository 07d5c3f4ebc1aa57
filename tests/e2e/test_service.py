"""The service as a well-meaning client sees it."""

import contextlib
import http.client
import json
import re
import select
import signal
import threading
import unittest

from contract import OPENAPI, PROBLEMS
from harness import (RAISED, ROOT, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, begin_slow, flat_grid, comparison, free_port, holding_the_worker, multipart, occupy_guests,
                     post_head, read_answer, until, until_computing, wavy_grid)
from test_batches import accepted, slow_pairs, submit


class Comparisons(ServerCase):
    def test_shards_are_refused_with_what_to_do(self):
        answer = self.server.compare(options={"shards": 4})
        self.assertEqual((answer.status, answer.json()["errors"][0]["where"]), (422, "/shards"), answer.body)
        self.assertIn("leave it out", answer.json()["detail"])

    def test_a_comparison(self):
        answer = self.server.compare(options={"tolerance": {"absolute": 1e-6}, "gate": {"max_distance": 3, "units": "mm"}})
        self.assertEqual(answer.status, 200)
        result = answer.json()
        self.assertEqual(result["verdict"], "pass")
        self.assertEqual(result["gate"], {"max_distance": 3, "units": "mm"})
        self.assertLessEqual(result["distance"]["lower"], 2)
        self.assertGreaterEqual(result["distance"]["upper"], 2)

    def test_it_converges(self):
        result = self.server.compare(options={"tolerance": {"absolute": 1e-6}}).json()
        self.assertEqual(result["status"], "converged")
        self.assertAlmostEqual(result["distance"]["lower"], 2, delta=1e-6)
        witness = result["a_to_b"]["witness"]
        self.assertAlmostEqual(sum((x - y) ** 2 for x, y in zip(witness["point_a"], witness["point_b"])) ** 0.5, 2)

    def test_threads_are_granted_as_far_as_workers_are_idle(self):
        for workers, granted in (("1", 1), ("3", 3)):
            server = Server("--workers", workers)
            self.addCleanup(server.stop)
            result = server.compare(wavy_grid(30, 0.1), wavy_grid(23, 0.103), {"threads": 64}).json()
            self.assertEqual(result["status"], "converged")
            self.assertEqual(result["engine"]["threads"], granted)

    def test_identical_meshes_end(self):
        result = self.server.compare(b=SQUARE, options={"tolerance": {"relative": 0.01}}).json()
        self.assertEqual(result["distance"]["lower"], 0)
        self.assertIn(result["status"], ("converged", "precision_floor"))

    def test_options_may_be_left_out(self):
        body = multipart([("a", SQUARE), ("b", RAISED)])
        result = self.server.raw(post_head(len(body)) + body).json()
        self.assertEqual(result["tolerance"]["asked"], {"relative": 0.01, "diagonal": 1e-6})

    def test_timeout_is_200(self):
        for i in range(8):  # a slow machine may have no interval by then
            answer = self.server.compare(**SLOW, options={**SLOW_OPTIONS, "timeout_ms": 400 << i})
            if answer.status == 200:
                break
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.json()["status"], "timeout")
        self.assertLessEqual(answer.json()["distance"]["lower"], answer.json()["distance"]["upper"])

    def test_no_time_to_read_is_a_problem(self):
        answer = self.server.compare(a=flat_grid(200), b=flat_grid(200), options={"timeout_ms": 1})
        self.refused(answer, 503, "out-of-time")

    def test_a_connection_serves_many_requests(self):
        body = comparison()
        with self.server.connect() as connection:
            stream = connection.makefile("rb")
            for _ in range(20):
                connection.sendall(post_head(len(body)) + body)
                answer = read_answer(stream)
                self.assertEqual(answer.status, 200)
                self.assertNotIn("connection", answer.headers)

    def test_pipelined_requests_are_answered_in_order(self):
        request = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
        with self.server.connect() as connection:
            connection.sendall(request + b"\r\n" + request + b"GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n")
            stream = connection.makefile("rb")
            self.assertEqual([read_answer(stream).status for _ in range(3)], [200, 200, 404])

    def test_chunked_bodies(self):
        body = comparison()
        chunks = b"".join(b"%x\r\n%s\r\n" % (len(body[i:i + 99]), body[i:i + 99]) for i in range(0, len(body), 99))
        head = post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding: chunked")
        with self.server.connect() as connection:
            stream = connection.makefile("rb")
            for _ in range(3):
                connection.sendall(head + chunks + b"0\r\n\r\n")
                self.assertEqual(read_answer(stream).status, 200)

    def test_a_client_that_waits_for_100_is_invited(self):
        body = comparison()
        with self.server.connect() as connection:
            connection.sendall(post_head(len(body), "Expect: 100-continue\r\n"))
            stream = connection.makefile("rb")
            self.assertEqual(stream.readline(), b"HTTP/1.1 100 Continue\r\n")
            stream.readline()
            connection.sendall(body)
            self.assertEqual(read_answer(stream).status, 200)

    def test_a_refused_client_is_not_invited(self):
        with self.server.connect() as connection:
            connection.sendall(post_head(1 << 40, "Expect: 100-continue\r\n"))
            self.assertTrue(connection.makefile("rb").readline().startswith(b"HTTP/1.1 413 "))

    def test_options_alone(self):
        def read(text, kind="application/json"):
            return self.server.send("POST", "/v1/options", text, "Content-Type: %s\r\n" % kind)
        answer = read(b'{"max_distance": "0.5 %", "timeout": "2 min", "direction": "candidate_to_baseline"}')
        self.assertEqual(answer.status, 200, answer.body)
        self.assertEqual(answer.json(), {"direction": "a_to_b", "strategy": "auto", "timeout_ms": 120_000,
                                         "gate": {"max_distance": 0.005, "units": "diagonal", "narrow": True},
                                         "tolerance": {"diagonal": 1e-9}})
        self.assertEqual(read(answer.body).json(), answer.json())
        wrong = self.refused(read(b'{"max_distance": "x", "threads": 65, "colour": 1}'), 422, "invalid-request")
        self.assertCountEqual([one["where"] for one in wrong["errors"]], ["/max_distance", "/threads", "/colour"])
        self.refused(read(b"{"), 422, "invalid-request")
        self.refused(read(b" " * (1 << 16) + b"{}"), 413, "too-large")
        self.refused(read(b"{}", "text/plain"), 415, "unsupported-media-type")  # as a foreign page's form could send
        self.refused(self.server.send("POST", "/v1/options?x", b"{}"), 400, "malformed-request")

    def test_other_paths_and_methods(self):
        self.assertEqual(self.server.get("/").status, 200)
        self.assertEqual(self.server.get("/healthz", "HEAD").status, 200)
        self.refused(self.server.get("/v1"), 404, "not-found")
        self.refused(self.server.get("/v1/comparisons/"), 404, "not-found")
        self.refused(self.server.get("/%2e%2e/etc/passwd"), 404, "not-found")
        self.assertEqual(self.server.get("/v1/comparisons", "DELETE").headers["allow"], "POST, GET, HEAD")
        self.refused(self.server.get("/healthz", "DELETE"), 405, "method-not-allowed")
        self.refused(self.server.get("*", "OPTIONS"), 404, "not-found")
        self.assertEqual(self.server.get("/healthz", "OPTIONS").headers["allow"], "GET, HEAD")

    def test_the_schema_of_manifests(self):
        answer = self.server.get("/gates.schema.json")
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, "application/schema+json"))
        self.assertEqual(answer.body, (ROOT / "check/gates.schema.json").read_bytes())

    def test_the_type_of_a_problem_is_the_path_of_a_page_about_it(self):
        problem = self.refused(self.server.get("/v1"), 404, "not-found")
        page = self.server.get(problem["type"])
        self.assertEqual((page.status, page.headers["content-type"]), (200, "text/html; charset=utf-8"))
        self.assertIn("<h1>Not found</h1>\n<p><code>not-found</code>, HTTP status 404</p>\n<p>Nothing has this path", page.body.decode())
        listed = re.findall(r'<a href="/problems/([a-z-]+)">', self.server.get("/problems").body.decode())
        self.assertEqual(sorted(listed), sorted(OPENAPI["components"]["examples"]))
        for kind in listed:
            text = self.server.get(PROBLEMS + kind).body.decode()
            self.assertIn(f"<p><code>{kind}</code>, HTTP status ", text)
            self.assertNotRegex(text, r"<(?:script|style|img|link)\b")
        for kind in ("none", "Not-Found", "..", "%2e%2e", "not-found/"):
            self.refused(self.server.get(PROBLEMS + kind), 404, "not-found")

    def test_a_range_is_ignored(self):
        ranges = "Range: bytes=" + ",".join("0-" for _ in range(100)) + "\r\n"
        answer = self.server.get("/openapi.yaml", extra=ranges)
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.body, (ROOT / "openapi.yaml").read_bytes())


class Crowd(unittest.TestCase):
    def test_64_clients_on_a_queue_of_8(self):
        server = Server("--queue", "8", "--workers", "2", "--grace-ms", "100")
        self.addCleanup(server.stop)
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        with contextlib.ExitStack() as stack:
            clients = [stack.enter_context(server.connect(120)) for _ in range(64)]
            for client in clients:
                client.sendall(post_head(len(body)) + body)
            # At once: while those that got a place wait or run. One address alone gets all ten places.
            refused = until(lambda: len(found := select.select(clients, [], [], 0)[0]) >= 54 and found)
            for client in refused:
                answer = read_answer(client.makefile("rb"))
                self.assertEqual((answer.status, answer.json()["type"]), (503, "/problems/overloaded"))
            until(lambda: b"\nmeshgauge_queue_depth 8\n" in server.get("/metrics").body)
            admitted = [client for client in clients if client not in refused]
            self.assertEqual(select.select(admitted, [], [], 0)[0], [])
            server.process.send_signal(signal.SIGTERM)
            answers = [read_answer(client.makefile("rb")) for client in admitted]
        self.assertEqual(len(answers), 10)
        ended = [answer for answer in answers if answer.status == 200]  # a worker may have begun one without an interval yet
        self.assertLessEqual(len(ended), 2)
        self.assertTrue(all(answer.json()["status"] == "cancelled" for answer in ended))
        self.assertEqual({answer.status for answer in answers if answer not in ended}, {503})

    def test_slow_and_idle_connections_hold_no_thread(self):
        server = Server("--io-threads", "1", "--keep-alive-ms", "600000", "--head-timeout-ms", "600000")
        self.addCleanup(server.stop)
        with contextlib.ExitStack() as stack:
            slow, idle = ([stack.enter_context(server.connect()) for _ in range(20)] for _ in range(2))
            for connection in slow:
                connection.sendall(b"GET /openapi.yaml HTTP/1.1\r\n")
            for connection in idle * 2:
                connection.sendall(b"GET /openapi.yaml HTTP/1.1\r\nHost: localhost\r\n\r\n")
                self.assertEqual(read_answer(connection.makefile("rb")).status, 200)
            self.assertEqual(server.compare().status, 200)
            for connection in slow:
                connection.sendall(b"Host: localhost\r\n\r\n")
                self.assertEqual(read_answer(connection.makefile("rb")).status, 200)

    def test_clients_that_wait_or_listen_hold_no_thread(self):
        server = Server("--io-threads", "1", "--workers", "1", "--queue", "30", "--max-event-streams", "30")
        self.addCleanup(server.stop)
        busy, _ = begin_slow(server)
        until(lambda: server.get(busy).json()["progress"])  # before that the others may overtake it
        body = comparison()
        with contextlib.ExitStack() as stack:
            guest = stack.enter_context(occupy_guests(server, 2))
            waiting = [stack.enter_context(server.connect(120)) for _ in range(10)]
            for connection in waiting:
                connection.sendall(post_head(len(body)) + body)
            listening = [stack.enter_context(server.connect(120)) for _ in range(10)]
            for connection in listening:
                connection.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % busy.encode())
            until(lambda: b"\nmeshgauge_queue_depth 10\n" in server.get("/metrics").body)
            until(lambda: b"\nmeshgauge_event_streams 10\n" in server.get("/metrics").body)
            self.assertEqual(server.get("/openapi.yaml").status, 200)
            guest.close()
            server.send("DELETE", busy)
            self.assertEqual([read_answer(connection.makefile("rb")).status for connection in waiting], [200] * 10)
            self.assertTrue(all(b"event: end" in read_answer(connection.makefile("rb")).body for connection in listening))

    def test_a_port_for_health_alone(self):
        port = free_port()
        server = Server("--status-port", str(port))
        self.addCleanup(server.stop)
        for path, status in (("/healthz", 200), ("/readyz", 200), ("/metrics", 200), ("/", 404), ("/v1/comparisons", 404)):
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
            connection.request("GET", path)
            self.assertEqual(connection.getresponse().status, status, path)
            connection.close()

    def test_a_client_that_goes_away_frees_its_worker(self):
        server = Server("--queue", "0", "--workers", "1")
        self.addCleanup(server.stop)
        holding_the_worker(server).close()
        until(lambda: server.compare().status == 200)
        until(lambda: any('"status":200' in line and "reduce" in line for line in server.log))


class End(unittest.TestCase):
    def busy_server(self, *flags):
        server = Server("--workers", "1", *flags)
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        answers = []

        def client():
            with server.connect(120) as connection:
                connection.sendall(post_head(len(body)) + body)
                answers.append(read_answer(connection.makefile("rb")))

        threads = [threading.Thread(target=client) for _ in range(2)]
        for thread in threads:
            thread.start()
        until(lambda: b"\nmeshgauge_queue_depth 1\n" in server.get("/metrics").body)
        until_computing(server.process)
        return server, threads, answers

    def test_sigterm_answers_every_client(self):
        server, threads, answers = self.busy_server("--grace-ms", "500")
        self.assertEqual(server.stop(), 0)
        for thread in threads:
            thread.join()
        by_status = {answer.status: answer.json() for answer in answers}
        self.assertEqual(set(by_status), {200, 503})
        self.assertEqual(by_status[200]["status"], "cancelled")
        self.assertEqual(by_status[503]["type"], "/problems/shutting-down")

    def test_a_second_signal_ends_the_grace(self):
        server, threads, answers = self.busy_server("--grace-ms", "100000")
        server.process.send_signal(signal.SIGTERM)
        until(lambda: any('"stopping"' in line for line in server.log))
        self.assertEqual(server.stop(signal.SIGINT), 0)
        for thread in threads:
            thread.join()
        self.assertEqual(len(answers), 2)

    def test_new_clients_are_refused_while_requests_finish(self):
        """A proxy turns to another front end at once, as in a rolling upgrade."""
        server, threads, answers = self.busy_server("--grace-ms", "100000")
        server.process.send_signal(signal.SIGTERM)

        def refuses():
            try:
                server.connect().close()
            except ConnectionRefusedError:
                return True
            return False
        until(refuses)
        self.assertLess(len(answers), 2)
        self.assertEqual(server.stop(signal.SIGINT), 0)
        for thread in threads:
            thread.join()

    def test_idle_and_dribbling_connections_do_not_delay_the_end(self):
        server = Server("--grace-ms", "300")
        connections = [server.connect() for _ in range(3)]
        connections[1].sendall(b"GET / HT")
        connections[2].sendall(post_head(1000) + b"--XX")
        until(lambda: b"\nmeshgauge_connections 4\n" in server.get("/metrics").body)  # with this one
        self.assertEqual(server.stop(), 0)
        for connection in connections:
            connection.close()

    def test_a_body_that_is_still_arriving_is_refused_at_the_end(self):
        server = Server("--grace-ms", "100")
        with server.connect() as connection:
            connection.sendall(post_head(1000, "Expect: 100-continue\r\n"))
            stream = connection.makefile("rb")
            self.assertTrue(stream.readline().startswith(b"HTTP/1.1 100 "))
            stream.readline()
            connection.sendall(b"--XX")
            self.assertEqual(server.stop(), 0)
            answer = read_answer(stream)
        self.assertEqual((answer.status, answer.json()["type"]), (503, "/problems/shutting-down"))

    def test_log_lines_are_json(self):
        server = Server()
        server.compare()
        server.get("/no\"such")
        self.assertEqual(server.stop(), 0)
        lines = [json.loads(line) for line in server.log]
        requests = [line for line in lines if line["event"] == "request"]
        # Each is written after its answer, so the second client may be ahead of the first line.
        comparison_line, other = sorted(requests, key=lambda line: line["status"])
        self.assertEqual([comparison_line["status"], other["status"]], [200, 400])
        self.assertEqual(comparison_line["triangles"], {"a": 2, "b": 2})
        self.assertGreater(comparison_line["bytes_in"], 100)
        self.assertEqual(lines[-1]["event"], "stopped")

    def test_settings_from_the_environment(self):
        server = Server(environment={"MESHGAUGE_MAX_PART_BYTES": "10"})
        self.assertEqual(server.compare().status, 413)
        self.assertEqual(server.stop(), 0)


class StoppingWhileWatched(unittest.TestCase):
    """A client that watches what goes on after a restart does not delay the stop, and gets no event of an end."""

    def setUp(self):
        self.server = Server("--workers", "1", "--grace-ms", "100")
        self.addCleanup(self.server.stop, signal.SIGKILL)

    def stop_while_watching(self, path, told):
        with self.server.connect() as watching:
            watching.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path.encode())
            stream = watching.makefile("rb")
            while told not in stream.readline():
                pass
            self.server.process.send_signal(signal.SIGTERM)
            self.assertEqual(self.server.process.wait(60), 0)
            self.assertNotIn(b"event: end", stream.read())

    def test_a_batch(self):
        self.stop_while_watching(accepted(submit(self.server, slow_pairs(self.server, 1))), b"event: progress")

    def test_a_comparison(self):
        answer = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n")
        self.stop_while_watching(answer.headers["location"], b'"running"')


if __name__ == "__main__":
    unittest.main()
