"""Comparisons as jobs: awaited or not, watched, cancelled, repeated, kept, and continued after a restart."""

import contextlib
import json
import signal
import tempfile
import threading
import time
import unittest

from contract import events_of
from harness import (ASYNC, ENDED, RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, begin_slow, comparison, post_head, processor_seconds,
                     read_answer, until, until_computing, wait_for, wavy_grid)


class Answers(ServerCase):
    flags = ("--workers", "2")

    def test_at_once(self):
        answer = self.server.compare(extra=ASYNC)
        self.assertEqual(answer.status, 202)
        self.assertEqual(answer.headers["preference-applied"], "respond-async")
        job = wait_for(self.server, answer.headers["location"], *ENDED)
        self.assertEqual(job["state"], "done")
        self.assertEqual(job["tries"], 1)
        self.assertEqual(job["result"]["id"], answer.json()["id"])
        self.assertLessEqual(job["result"]["distance"]["lower"], 2)
        self.assertGreaterEqual(job["result"]["distance"]["upper"], 2)
        self.assertLessEqual(job["created"], job["started"])
        self.assertLessEqual(job["started"], job["finished"])
        self.assertLess(job["finished"], job["expires"])

    def test_in_time(self):
        answer = self.server.compare(extra="Prefer: respond-async, wait=60\r\n")
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.headers["preference-applied"], "respond-async, wait=60")
        self.assertIn("server-timing", answer.headers)
        self.assertEqual(self.server.get(answer.headers["location"]).json()["result"], answer.json())

    def test_not_in_time(self):
        start = time.monotonic()
        path, job = begin_slow(self.server, "Prefer: wait=1\r\n")
        self.assertGreaterEqual(time.monotonic() - start, 1)
        self.assertIn(job["state"], ("queued", "running"))
        self.assertEqual(self.server.send("DELETE", path).status, 200)

    def test_preferences_that_mean_nothing_are_ignored(self):
        for extra in ("Prefer: handling=strict\r\n", "Prefer: wait=soon\r\n", "Prefer: wait=-1\r\n"):
            answer = self.server.compare(extra=extra)
            self.assertEqual(answer.status, 200)
            self.assertNotIn("preference-applied", answer.headers)
            self.assertNotIn("location", answer.headers)

    def test_one_that_was_waited_for_can_be_asked_for_as_well(self):
        answer = self.server.compare()
        job = self.server.get("/v1/comparisons/" + answer.headers["x-request-id"]).json()
        self.assertEqual((job["state"], job["result"]), ("done", answer.json()))

    def test_a_failure_is_kept(self):
        answer = self.server.compare(a=b"v 0 0 nan\n", extra=ASYNC)
        job = wait_for(self.server, answer.headers["location"], *ENDED)
        self.assertEqual((job["state"], job["result"]), ("failed", None))
        self.assertEqual(job["problem"]["type"], "/problems/non-finite-vertex")
        waited = self.server.compare(a=b"v 0 0 nan\n", extra="Prefer: wait=60\r\n")
        self.refused(waited, 422, "non-finite-vertex")

    def test_options_are_refused_before_anything_is_promised(self):
        self.refused(self.server.compare(options={"unknown": 1}, extra=ASYNC), 422, "invalid-request")

    def test_what_is_not_there(self):
        for path in ("/v1/comparisons/" + "0" * 32, "/v1/comparisons/x", "/v1/comparisons/" + "0" * 32 + "/events"):
            self.refused(self.server.get(path), 404, "not-found")
        self.refused(self.server.send("DELETE", "/v1/comparisons/" + "0" * 32), 404, "not-found")
        self.refused(self.server.get("/v1/comparisons/x/y"), 404, "not-found")

    def test_wrong_methods_and_queries(self):
        path = self.server.compare(extra=ASYNC).headers["location"]
        for method, place, allowed in (("PUT", path, "GET, HEAD, DELETE"), ("DELETE", path + "/events", "GET, HEAD"),
                                       ("DELETE", "/v1/comparisons", "POST, GET, HEAD")):
            answer = self.server.send(method, place)
            self.refused(answer, 405, "method-not-allowed")
            self.assertEqual(answer.headers["allow"], allowed)
        for place in (path, path + "/events"):
            self.refused(self.server.get(place + "?x=1"), 400, "malformed-request")
        self.refused(self.server.send("POST", "/v1/comparisons?x=1", b"{}"), 400, "malformed-request")
        self.refused(self.server.send("DELETE", path + "?x=1"), 400, "malformed-request")


class Ends(ServerCase):
    flags = ("--workers", "1")

    def delete(self, path):
        return self.server.send("DELETE", path)

    def test_one_that_waits(self):
        running, _ = begin_slow(self.server)
        wait_for(self.server, running, "running")
        key = "Idempotency-Key: waits\r\n"
        waiting, _ = begin_slow(self.server, ASYNC + key)
        answers = []
        waits = threading.Thread(target=lambda: answers.append(self.server.compare(
            **SLOW, options=SLOW_OPTIONS, extra=key + "Prefer: wait=60\r\n")))
        waits.start()
        time.sleep(0.3)
        answer = self.delete(waiting)
        waits.join()
        self.assertEqual((answer.status, answer.json()["state"], answer.json()["result"]), (200, "cancelled", None))
        self.assertEqual(answer.json()["problem"]["type"], "/problems/cancelled")
        self.assertEqual(answer.json(), self.server.get(waiting).json())
        self.refused(answers[0], 409, "cancelled")
        self.delete(running)

    def test_one_that_runs_stops_soon_and_keeps_its_interval(self):
        path, _ = begin_slow(self.server)
        until(lambda: (self.server.get(path).json()["progress"] or {}).get("stage") == "reduce")
        before = self.server.get(path).json()["progress"]
        job = self.delete(path).json()
        self.assertEqual((job["state"], job["result"]["status"]), ("cancelled", "cancelled"))
        distance = job["result"]["distance"]
        self.assertEqual(distance["lower"], 0)  # the true one: the meshes are the same square
        self.assertGreaterEqual(distance["upper"], 0)
        self.assertLessEqual(distance["upper"], before["upper"])

    def test_one_that_has_ended_is_forgotten(self):
        path = "/v1/comparisons/" + self.server.compare().headers["x-request-id"]
        self.assertEqual(self.delete(path).status, 204)
        self.refused(self.server.get(path), 404, "not-found")
        self.refused(self.delete(path), 404, "not-found")

    def test_work_stops_within_50_ms(self):
        """Measured by the service's own processor time, so that the work of other processes does not count."""
        taken = []
        for _ in range(5):
            path, _ = begin_slow(self.server)
            wait_for(self.server, path, "running")
            time.sleep(0.2)
            before = processor_seconds(self.server.process)
            self.assertEqual(self.delete(path).json()["state"], "cancelled")
            taken.append(1000 * (processor_seconds(self.server.process) - before))
        print("a running comparison worked for %.0f ms at most after DELETE was sent" % max(taken))
        self.assertLess(min(taken), 50)

    def test_a_client_that_disconnects_ends_a_plain_comparison(self):
        body = comparison(**SLOW, options=SLOW_OPTIONS)
        with self.server.connect() as connection:
            connection.sendall(post_head(len(body)) + body)
            until(lambda: b"\nmeshgauge_jobs_running 1\n" in self.server.get("/metrics").body)
        until(lambda: self.server.compare(extra="Prefer: wait=5\r\n").status == 200)  # the one worker is free

    def test_a_client_that_disconnects_ends_no_durable_comparison(self):
        key = "Idempotency-Key: gone-away\r\n"
        before = len(self.server.log)
        body = comparison(options={**SLOW_OPTIONS, "threads": 1}, **SLOW)  # of another size than in other tests
        with self.server.connect() as connection:
            connection.sendall(post_head(len(body), key) + body)
            until_computing(self.server.process)
        answer = self.server.raw(post_head(len(body), key + ASYNC) + body)
        self.assertEqual(answer.status, 202)
        # The client that left was promised the same.
        until(lambda: sum('"bytes_in":%d,' % len(body) in line and '"status":202,' in line for line in self.server.log[before:]) == 2)
        job = wait_for(self.server, answer.headers["location"], "running")
        self.assertIsNone(job["finished"])
        self.delete(answer.headers["location"])


class Events(ServerCase):
    flags = ("--workers", "1", "--max-event-streams", "4")

    def watch(self, path):
        """The events of a comparison, once all of them are there."""
        answer = self.server.get(path + "/events")
        self.assertEqual(answer.status, 200)
        return list(events_of(answer.body))

    def follow(self, path):
        """Yields the events of a job as they come."""
        with self.server.connect() as connection:
            connection.sendall(("GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path).encode())
            name = ""
            for line in connection.makefile("rb"):
                if line.startswith(b"event: "):
                    name = line[7:].decode().strip()
                if line.startswith(b"data: "):
                    yield name, json.loads(line[6:])
                    if name == "end":
                        return

    def test_the_interval_shrinks(self):
        path, _ = begin_slow(self.server)
        start, events = time.monotonic(), []
        for name, event in self.follow(path):
            events.append((name, event))
            if event.get("stage") == "reduce":
                self.server.send("DELETE", path)
        self.assertEqual([name for name, _ in events], ["progress"] * (len(events) - 1) + ["end"])
        self.assertLessEqual(len(events) - 1, 10 * (time.monotonic() - start) + 2)
        known = [event for _, event in events[:-1] if event["upper"] is not None]
        for before, after in zip(known, known[1:]):
            self.assertLessEqual(before["lower"], after["lower"])
            self.assertGreaterEqual(before["upper"], after["upper"])
        end = events[-1][1]
        self.assertEqual(end, self.server.get(path).json())
        self.assertEqual(end["result"]["status"], "cancelled")
        self.assertLessEqual(end["result"]["distance"]["upper"], known[-1]["upper"])
        self.assertGreaterEqual(end["result"]["distance"]["lower"], known[-1]["lower"])

    def test_they_come_as_they_happen_and_at_most_ten_a_second(self):
        path, _ = begin_slow(self.server)
        wait_for(self.server, path, "running")
        told = [event for _, event in zip(range(3), (event for name, event in self.follow(path) if name == "progress"))]
        for before, after in zip(told, told[1:]):
            self.assertNotEqual({**before, "elapsed_ms": 0}, {**after, "elapsed_ms": 0})
        self.assertGreaterEqual(told[-1]["elapsed_ms"] - told[0]["elapsed_ms"], 90 * (len(told) - 1))
        self.server.send("DELETE", path)

    def test_the_events_of_an_ended_job_are_its_end(self):
        path = self.server.compare(extra="Prefer: wait=60\r\n").headers["location"]
        self.assertEqual(self.watch(path), [("end", self.server.get(path).json())])
        head = self.server.get(path + "/events", "HEAD")
        self.assertEqual((head.status, head.headers.get("content-length")), (200, None))  # the length of the events is not known

    def test_a_cancelled_one(self):
        path, _ = begin_slow(self.server)
        found = []
        watcher = threading.Thread(target=lambda: found.extend(self.watch(path)))
        watcher.start()
        wait_for(self.server, path, "running")
        self.server.send("DELETE", path)
        watcher.join()
        self.assertEqual((found[-1][0], found[-1][1]["state"]), ("end", "cancelled"))

    def test_there_are_only_so_many(self):
        path, _ = begin_slow(self.server)
        with contextlib.ExitStack() as stack:
            for _ in range(2):
                connection = stack.enter_context(self.server.connect())
                connection.sendall(("GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path).encode())
                self.assertTrue(connection.makefile("rb").readline().startswith(b"HTTP/1.1 200 "))
            self.refused(self.server.get(path + "/events"), 503, "overloaded")
            other = stack.enter_context(self.server.connect(source="127.0.0.2"))  # one address alone does not get all places
            other.sendall(("GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path).encode())
            self.assertTrue(other.makefile("rb").readline().startswith(b"HTTP/1.1 200 "))
        until(lambda: self.server.get(path + "/events", "HEAD").status == 200)
        self.server.send("DELETE", path)

    def test_not_over_http_1_0(self):
        path = self.server.compare(extra=ASYNC).headers["location"]
        answer = self.server.raw(("GET %s/events HTTP/1.0\r\n\r\n" % path).encode())
        self.refused(answer, 505, "http-version")


class Repeats(ServerCase):
    def key(self, name):
        return "Idempotency-Key: %s\r\n" % name

    def test_the_same_again(self):
        first = self.server.compare(extra=self.key("again"))
        second = self.server.compare(extra=self.key("again"))
        self.assertEqual((first.status, second.status), (200, 200))
        self.assertEqual(first.json(), second.json())
        self.assertEqual(first.headers["location"], second.headers["location"])
        self.assertNotEqual(first.headers["x-request-id"], second.headers["x-request-id"])
        later = self.server.compare(extra=self.key("again") + ASYNC)
        self.assertEqual(later.headers["location"], first.headers["location"])

    def test_other_content(self):
        self.assertEqual(self.server.compare(extra=self.key("other")).status, 200)
        for change in ({"b": SQUARE}, {"options": {"direction": "a_to_b"}}):
            self.refused(self.server.compare(**change, extra=self.key("other")), 422, "idempotency-key-reused")

    def test_a_failure_again(self):
        for _ in range(2):
            self.refused(self.server.compare(a=b"v 0 0 nan\n", extra=self.key("fails")), 422, "non-finite-vertex")

    def test_many_at_once_are_one(self):
        mesh = wavy_grid(25, 0.1)
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(self.server.compare(a=mesh, extra=self.key("many"))))
                   for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({answer.status for answer in answers}, {200})
        self.assertEqual(len({answer.headers["location"] for answer in answers}), 1)
        self.assertEqual(len({answer.body for answer in answers}), 1)

    def test_what_is_no_key(self):
        for name in ("", "two words", "x" * 256, "\x7f", "caf\u00e9"):
            body = comparison()
            head = post_head(len(body), self.key(name)).decode().encode("latin-1")
            self.refused(self.server.raw(head + body), 400, "malformed-request")
        self.refused(self.server.compare(extra=self.key("a") + self.key("a")), 400, "malformed-request")


class Kept(unittest.TestCase):
    """Jobs and results that outlive the service."""

    def start(self, *flags):
        server = Server("--data-dir", self.folder.name, "--workers", "1", *flags)
        self.addCleanup(server.stop)
        return server

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def by_its_deadline(self, job):
        """With its interval, or, on a slow machine, without: then the problem says that there was no time."""
        if job["state"] == "failed":
            return self.assertEqual(job["problem"]["type"], "/problems/out-of-time")
        self.assertEqual((job["state"], job["result"]["status"]), ("done", "timeout"))
        self.assertLessEqual(job["result"]["distance"]["lower"], job["result"]["distance"]["upper"])

    def restarted(self, sign, code, timeout_ms):
        """The service after a restart, and the paths of the comparison that ran and of those behind it."""
        server = self.start("--grace-ms", "200")
        running, _ = begin_slow(server, timeout_ms=timeout_ms)
        wait_for(server, running, "running")
        waiting = server.compare(extra=ASYNC).headers["location"]
        ended = server.compare(extra="Prefer: wait=0\r\n").headers["location"]
        self.assertEqual(server.stop(sign), code)
        return self.start(), running, (waiting, ended)

    def test_a_kill_loses_nothing(self):
        server, running, others = self.restarted(signal.SIGKILL, -signal.SIGKILL, timeout_ms=5000)
        job = wait_for(server, running, *ENDED)
        self.assertEqual(job["tries"], 2)
        self.by_its_deadline(job)
        self.assertEqual([wait_for(server, path, *ENDED)["result"]["status"] for path in others], ["converged"] * 2)

    def test_an_end_in_peace_loses_nothing(self):
        server, running, others = self.restarted(signal.SIGTERM, 0, timeout_ms=100000)
        self.assertIn(wait_for(server, running, "running")["tries"], (1, 2))
        self.assertEqual(server.send("DELETE", running).json()["state"], "cancelled")
        self.assertEqual([wait_for(server, path, *ENDED)["result"]["status"] for path in others], ["converged"] * 2)

    def test_what_runs_has_the_grace_to_end_though_no_client_is_connected(self):
        server = self.start("--grace-ms", "60000")
        running = server.compare(**SLOW, options={**SLOW_OPTIONS, "timeout_ms": 2000}, extra=ASYNC).headers["location"]
        until(lambda: b"\nmeshgauge_jobs_running 1\n" in server.get("/metrics").body)  # a thread has begun it
        waiting = server.compare(extra=ASYNC).headers["location"]
        self.assertEqual(server.stop(), 0)
        server = self.start()
        job = server.get(running).json()
        self.assertEqual(job["tries"], 1)
        self.by_its_deadline(job)
        self.assertEqual(wait_for(server, waiting, *ENDED)["tries"], 1)

    def test_idempotency_outlives_a_kill(self):
        server = self.start()
        first = server.compare(extra="Idempotency-Key: k\r\n")
        server.stop(signal.SIGKILL)
        second = self.start().compare(extra="Idempotency-Key: k\r\n")
        self.assertEqual(first.json(), second.json())

    def test_results_expire(self):
        server = self.start("--result-ttl-s", "1")
        path = server.compare(extra="Prefer: wait=60\r\n").headers["location"]
        self.assertEqual(server.get(path).status, 200)
        until(lambda: server.get(path).status == 404, 90)

    def test_only_so_many_wait(self):
        server = self.start("--max-queued-jobs", "2")
        paths = [begin_slow(server)[0] for _ in range(2)]
        answer = server.compare(extra=ASYNC)
        self.assertEqual((answer.status, answer.json()["type"]), (503, "/problems/overloaded"))
        until(lambda: server.get("/readyz").status == 503)
        # Being refused costs no connection.
        post = f"POST /v1/comparisons HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n{ASYNC}Content-Length: %d\r\n\r\n%s"
        with server.connect() as connection:
            stream = connection.makefile("rb")
            for _ in range(3):
                connection.sendall((post % (30, "GET /healthz HTTP/1.1\r\nHost: x")).encode())  # no request is seen in it
                answer = read_answer(stream)
                self.assertEqual((answer.status, answer.headers.get("connection")), (503, None))
            connection.sendall((post % (5, "{}")).encode())  # and the answer does not wait for it
            answer = read_answer(stream)
            self.assertEqual((answer.status, answer.headers.get("connection")), (503, None))
        for path in paths:
            server.send("DELETE", path)
        until(lambda: server.get("/readyz").status == 200)

    def test_what_was_promised_is_found_when_there_is_no_room(self):
        server = self.start("--max-queued-jobs", "1", "--max-stored-bytes", str(len(SLOW["a"] + SLOW["b"])))
        key = "Idempotency-Key: k\r\n"
        path, _ = begin_slow(server, ASYNC + key)
        self.assertEqual(server.compare(extra=ASYNC).status, 503)
        self.assertEqual(begin_slow(server, ASYNC + key)[0], path)
        answer = server.compare(extra=ASYNC + key)
        self.assertEqual((answer.status, answer.json()["type"]), (422, "/problems/idempotency-key-reused"))
        server.send("DELETE", path)

    def test_what_waits_takes_storage(self):
        server = self.start("--max-stored-bytes", str(len(SQUARE + RAISED) - 1))
        answer = server.compare(extra=ASYNC)
        self.assertEqual((answer.status, answer.json()["type"]), (403, "/problems/quota-exceeded"))
        self.assertEqual(server.compare().status, 200)


if __name__ == "__main__":
    unittest.main()
