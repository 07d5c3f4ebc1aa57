"""Metrics, the log and traces."""

import json
import re
import subprocess
import unittest

from harness import BINARY, OWN_DATA, Server, comparison, post_head, read_answer, until

TRACE_ID, PARENT_ID = "4bf92f3577b34da6a3ce929d0e0e4736", "00f067aa0ba902b7"
TRACEPARENT = "00-%s-%s-01" % (TRACE_ID, PARENT_ID)


def requests(server):
    return [line for line in map(json.loads, server.log) if line["event"] == "request"]


class Metrics(unittest.TestCase):
    def setUp(self):
        self.server = Server("--workers", "3", "--queue", "7")
        self.addCleanup(self.server.stop)

    def value(self, sample):
        page = self.server.get("/metrics").body.decode()
        found = re.search("^%s (.*)$" % re.escape(sample), page, re.M)
        return float(found[1]) if found else None

    def test_what_happened_is_counted(self):
        self.server.compare()
        self.server.compare(a=b"v 0 0 nan\n")
        self.server.get("/made/up/path")
        ours = 'code="%d",method="POST",route="/v1/comparisons"}'
        for sample in ('code="404",method="GET",route="none"}', ours % 200, ours % 422):  # each after its answer
            until(lambda: self.value("meshgauge_requests_total{" + sample) == 1)
        self.assertEqual(self.value('meshgauge_jobs_total{state="done",status="converged",strategy="auto"}'), 1)
        self.assertEqual(self.value('meshgauge_jobs_total{state="failed",status="non-finite-vertex",strategy="auto"}'), 1)
        self.assertEqual(self.value('meshgauge_rejected_total{reason="non-finite-vertex"}'), 1)
        self.assertEqual(self.value('meshgauge_stage_seconds_count{stage="total"}'), 1)
        self.assertEqual(self.value("meshgauge_queue_wait_seconds_count"), 2)
        self.assertEqual(self.value("meshgauge_triangles_total"), 4)

    def test_how_things_stand(self):
        self.assertEqual(self.value("meshgauge_workers"), 3)
        self.assertEqual(self.value("meshgauge_queue_limit"), 7 + 1000)  # --queue, and --max-queued-jobs as it is
        self.assertEqual(self.value("meshgauge_upload_bytes"), 0)
        self.assertGreaterEqual(self.value("meshgauge_connections"), 1)  # this one
        body = comparison()
        with self.server.connect() as connection:
            connection.sendall(post_head(len(body)) + body[:200])
            until(lambda: self.value("meshgauge_upload_bytes") > 0)
        until(lambda: self.value("meshgauge_upload_bytes") == 0)

    def test_readers_of_uploads_are_counted(self):
        self.server.compare()
        until(lambda: self.value('meshgauge_sandbox_workers_ended_total{outcome="read"}') == 2)
        self.assertGreaterEqual(self.value("meshgauge_sandbox_workers_started_total"), 2)

    def test_head_has_no_body(self):
        answer = self.server.get("/metrics", "HEAD")
        self.assertEqual((answer.status, answer.body), (200, b""))


class Traces(unittest.TestCase):
    def setUp(self):
        self.server = Server()
        self.addCleanup(self.server.stop)

    def test_a_trace_goes_on(self):
        answer = self.server.get("/healthz", extra="traceparent: %s\r\nTracestate: a=b,c=d\r\n" % TRACEPARENT)
        version, trace_id, span_id, flags = answer.headers["traceparent"].split("-")
        self.assertEqual((version, trace_id, flags), ("00", TRACE_ID, "01"))
        self.assertNotEqual(span_id, PARENT_ID)
        self.assertEqual(answer.headers["tracestate"], "a=b,c=d")
        until(lambda: requests(self.server))
        line = requests(self.server)[0]
        self.assertEqual((line["trace_id"], line["span_id"], line["parent_id"]), (TRACE_ID, span_id, PARENT_ID))

    def test_a_broken_one_begins_anew_and_is_no_error(self):
        for broken in (TRACEPARENT.upper(), TRACEPARENT + "-00", "00-" + "0" * 32 + "-" + PARENT_ID + "-01", "x"):
            answer = self.server.get("/healthz", extra="traceparent: %s\r\ntracestate: a=b\r\n" % broken)
            self.assertEqual(answer.status, 200)
            self.assertRegex(answer.headers["traceparent"], "^00-[0-9a-f]{32}-[0-9a-f]{16}-00$")
            self.assertNotIn(TRACE_ID, answer.headers["traceparent"])
            self.assertNotIn("tracestate", answer.headers)

    def test_a_refused_request_has_one_too(self):
        answer = self.server.compare(options={"unknown": 1})
        self.assertEqual(answer.status, 422)
        self.assertIn("traceparent", answer.headers)


class Log(unittest.TestCase):
    def lines(self, *flags):
        server = Server(*flags)
        server.compare()
        server.get("/no/such/path")
        self.assertEqual(server.stop(), 0)
        return requests(server), [json.loads(line)["event"] for line in server.log]

    def test_a_line_has_what_it_needs(self):
        (compared, missing), _ = self.lines()
        if compared["status"] != 200:  # written after the answer: they may change places
            compared, missing = missing, compared
        self.assertEqual(compared["route"], "/v1/comparisons")
        self.assertEqual(set(compared["stages_ms"]),
                         {"queue", "read_a", "read_b", "build", "traverse", "reduce", "certify", "total"})
        self.assertGreaterEqual(compared["duration_ms"], compared["stages_ms"]["total"])
        self.assertGreater(compared["bytes_in"], 100)
        self.assertGreater(compared["bytes_out"], 1000)
        self.assertNotIn("problem", compared)
        self.assertEqual(missing["route"], None)
        self.assertEqual(missing["problem"], "/problems/not-found")

    def test_less_of_it(self):
        problems, events = self.lines("--log-requests", "problems")
        self.assertEqual([line["status"] for line in problems], [404])
        self.assertIn("stopped", events)
        nothing, events = self.lines("--log-requests", "none")
        self.assertEqual(nothing, [])
        self.assertIn("stopped", events)

    def test_a_word_that_is_no_choice_ends_the_start(self):
        done = subprocess.run([BINARY, "serve", "--port", "0", "--log-requests", "some"], env=OWN_DATA,
                              capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(done.returncode, 3)
        self.assertIn("--log-requests must be all, problems or none", done.stderr)

    def test_a_client_that_leaves_is_logged(self):
        server = Server()
        body = comparison()
        with server.connect() as connection:
            connection.sendall(post_head(len(body) + 10) + body)
        until(lambda: requests(server))
        self.assertEqual(server.stop(), 0)
        self.assertEqual(requests(server)[0]["problem"], "/problems/malformed-request")

    def test_two_answers_on_one_connection_are_two_lines(self):
        server = Server()
        with server.connect() as connection:
            stream = connection.makefile("rb")
            for _ in range(2):
                connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
                read_answer(stream)
        self.assertEqual(server.stop(), 0)
        lines = requests(server)
        self.assertEqual(len(lines), 2)
        self.assertNotEqual(lines[0]["trace_id"], lines[1]["trace_id"])


if __name__ == "__main__":
    unittest.main()
