"""Batches and their comparisons, watched and read while they run, end or go away."""

import socket
import sqlite3
import tempfile
import time
import unittest

from contract import events_of
from harness import SQUARE, Server, read_answer, until
from test_batches import accepted, ended, pairs, put, slow_pairs, submit


def comparisons(folder):
    """The ids of comparisons that have not ended, running ones first; no response has them."""
    database = sqlite3.connect("file:%s/jobs.sqlite?mode=ro" % folder, uri=True)
    rows = database.execute("SELECT id FROM jobs WHERE state IN (0, 1) ORDER BY state DESC").fetchall()
    database.close()
    return [identity for identity, in rows]


class Watched(unittest.TestCase):
    def start(self, *flags):
        server = Server("--workers", "1", *flags)
        self.addCleanup(server.stop)
        return server

    def test_watched(self):
        server = self.start()
        flat = put(server, SQUARE)
        manifest = slow_pairs(server, 2)
        manifest["comparisons"].append({"a": flat, "b": flat})
        path = accepted(submit(server, manifest))
        with server.connect() as connection:
            connection.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path.encode())
            until(lambda: b"event: progress" in connection.recv(1 << 16, socket.MSG_PEEK))
            server.send("DELETE", path)
            told = list(events_of(read_answer(connection.makefile("rb")).body))
        self.assertEqual(told[-1][0], "end")
        self.assertEqual(told[-1][1]["state"], "cancelled")
        self.assertEqual([name for name, _ in told[:-1]], ["progress"] * (len(told) - 1))
        self.assertGreater(len(told), 1)

    def test_waited_for(self):
        """The answer comes when another comparison has ended; meanwhile the batch lists what runs with its interval."""
        server = self.start()
        path = accepted(submit(server, slow_pairs(server, 2)))

        def lists_what_runs():
            batch = server.get(path).json()
            self.assertLessEqual({one["position"] for one in batch["running"]}, {0, 1})
            told = any(one["progress"] for one in batch["running"])
            return told and len(batch["running"]) == batch["counts"]["running"]  # read one after the other
        until(lists_what_runs)
        begun = time.monotonic()
        batch = server.get(path, extra="Prefer: wait=1\r\n").json()
        self.assertGreaterEqual(time.monotonic() - begun, 0.9)
        self.assertTrue(any(one["progress"] for one in batch["running"]), batch)
        until(lambda: b"meshgauge_event_streams 0\n" in server.get("/metrics").body)  # its place is free again
        with server.connect() as connection:
            connection.sendall(b"GET %s HTTP/1.1\r\nHost: localhost\r\nPrefer: wait=60\r\n\r\n" % path.encode())
            until(lambda: b"meshgauge_event_streams 1\n" in server.get("/metrics").body)
            server.send("POST", path + "/cancel")
            answer = read_answer(connection.makefile("rb"))
        self.assertEqual(answer.headers["preference-applied"], "wait=60")
        self.assertGreater(answer.json()["counts"]["cancelled"], 0)
        ended(server, path)
        answer = server.get(path, extra="Prefer: wait=60\r\n")
        self.assertEqual((answer.json()["state"], answer.json()["running"]), ("cancelled", []))
        self.assertNotIn("preference-applied", answer.headers)

    def test_deleted_while_its_results_are_read(self):
        server = self.start("--max-batch-pairs", "4000")
        flat = put(server, SQUARE)
        path = accepted(submit(server, pairs(*[(flat, flat)] * 4000)))  # some 9 MB, more than a socket holds
        ended(server, path)
        with server.connect() as connection:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 16)
            connection.sendall(b"GET %s/results.jsonl HTTP/1.1\r\nHost: localhost\r\n\r\n" % path.encode())
            self.assertIn(b" 200 ", connection.recv(2048))
            self.assertEqual(server.send("DELETE", path).status, 204)
            self.assertFalse(connection.makefile("rb").read().endswith(b"0\r\n\r\n"))  # it does not pass for complete

    def test_deleted_while_watched(self):
        """The stream looks twice a second: the batch is mostly gone when it looks again. Never is its end told as null."""
        server = self.start()
        path = accepted(submit(server, slow_pairs(server, 1)))
        with server.connect() as connection:
            connection.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path.encode())
            until(lambda: b"event: progress" in connection.recv(1 << 16, socket.MSG_PEEK))
            until(lambda: server.send("DELETE", path).status == 204)
            told = list(events_of(read_answer(connection.makefile("rb")).body))
        self.assertLessEqual({event["state"] for name, event in told if name == "end"}, {"cancelled"})

    def test_a_comparison_deleted_while_its_watching_begins(self):
        server = self.start()
        for _ in range(50):
            path = server.compare(extra="Prefer: wait=60\r\n").headers["location"]
            with server.connect() as connection:
                connection.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path.encode())
                self.assertEqual(server.send("DELETE", path).status, 204)
                answer = read_answer(connection.makefile("rb"))
            if answer.status == 200:
                self.assertLessEqual({event["state"] for _, event in events_of(answer.body)}, {"done"})

    def test_its_comparisons_watched(self):
        with tempfile.TemporaryDirectory() as folder:
            server = self.start("--data-dir", folder)
            manifest = slow_pairs(server, 1)
            manifest["comparisons"].append({**manifest["comparisons"][0], "options": {"timeout_ms": 99999}})
            path = accepted(submit(server, manifest))
            until(lambda: server.get(path).json()["counts"]["running"])
            watched = ["/v1/comparisons/" + identity for identity in comparisons(folder)]
            self.assertEqual(len(watched), 2)
            with server.connect() as first, server.connect() as second:
                answers = [connection.makefile("rb") for connection in (first, second)]
                for connection, answer, one in zip((first, second), answers, watched):
                    connection.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % one.encode())
                    answer.peek()
                self.assertEqual(server.send("DELETE", path).status, 200)
                told = [list(events_of(read_answer(answer).body)) for answer in answers]
            for events, one in zip(told, watched):
                self.assertEqual([name for name, _ in events], ["progress"] * (len(events) - 1) + ["end"])
                self.assertIn(events[0][1]["state"], ("running", "queued"))
                self.assertEqual(events[-1][1], server.get(one).json())
                self.assertEqual(events[-1][1]["state"], "cancelled")

    def test_its_comparisons_watched_until_the_service_ends(self):
        with tempfile.TemporaryDirectory() as folder:
            server = self.start("--data-dir", folder, "--grace-ms", "100")
            path = accepted(submit(server, slow_pairs(server, 1)))
            until(lambda: server.get(path).json()["counts"]["running"])
            running, = comparisons(folder)
            with server.connect() as connection:
                connection.sendall(b"GET /v1/comparisons/%s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % running.encode())
                answer = connection.makefile("rb")
                answer.peek()
                self.assertEqual(server.stop(), 0)
                told = [name for name, _ in events_of(read_answer(answer).body)]
            self.assertEqual(told, ["progress"] * len(told))  # it has no end here


if __name__ == "__main__":
    unittest.main()
