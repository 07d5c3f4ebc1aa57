"""Two front ends, two workers, one PostgreSQL: it is one service, whichever front end is asked."""

import hashlib
import json
import re
import signal
import socket
import threading
import unittest
from pathlib import Path

from postgres import Missing
from rig import ASYNC, ENDED, Client, Rig, endless, holds, square, until
from contract import events_of
from harness import read_answer
from keys import new_key, write_keys

RIG = None
KEYS = None  # the file
TOKENS, ENTRIES = {}, []


def setUpModule():
    global RIG
    tokens = {name: new_key(name, requests_per_minute=1000000, burst=10000, max_jobs=1000) for name in ("alice", "bob")}
    TOKENS.update({name: token for name, (token, _) in tokens.items()})
    ENTRIES.extend(entry for _, entry in tokens.values())

    def keys(folder):
        global KEYS
        KEYS = Path(folder) / "keys.json"
        write_keys(KEYS, *ENTRIES)
        return "--keys-file", str(KEYS)
    try:
        RIG = Rig(front_ends=2, workers=2, prepare=keys)
    except Missing as reason:
        raise unittest.SkipTest(str(reason)) from None


def tearDownModule():
    if RIG is not None:
        RIG.stop()


class Case(unittest.TestCase):
    def setUp(self):
        self.one, self.other = (Client(front_end, TOKENS["alice"]) for front_end in RIG.front_ends)
        self.salt = self.id()

    def refused(self, answer, status, slug):
        self.assertIsNotNone(answer)
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.json()["type"], "/problems/" + slug)


class Comparisons(Case):
    def test_any_front_end_answers_for_any_job(self):
        paths = [client.begin(0, height, salt=self.salt) for height in (1, 2, 3, 4) for client in (self.one, self.other)]
        for number, path in enumerate(paths):
            document = self.other.wait_for(path, *ENDED)
            self.assertEqual((document["state"], document["tries"]), ("done", 1))
            self.assertTrue(holds(document, 1 + number // 2), document)
            self.assertEqual(self.one.get(path).json(), document)

    def test_waited_for_and_asked_for_at_the_other(self):
        answer = self.one.compare(square(0, 1, self.salt), square(3))
        self.assertEqual(answer.status, 200, answer.body)
        document = self.other.get("/v1/comparisons/" + answer.json()["id"]).json()
        self.assertEqual((document["state"], document["result"]), ("done", answer.json()))
        self.assertTrue(holds(document, 3), document)

    def test_many_waited_for_at_both(self):
        answers = []
        threads = [threading.Thread(target=lambda client=client, height=height: answers.append(
            (height, client.compare(square(0, 1, self.salt), square(height))))) for client in (self.one, self.other)
            for height in range(1, 9)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual([answer.status for _, answer in answers], [200] * 16)
        for height, answer in answers:
            self.assertTrue(holds({"result": answer.json()}, height), answer.body)

    def test_its_time_ends_it_with_an_interval(self):
        for timeout_ms in (1000, 4000, 16000, 64000):  # less may be over before the meshes are read
            answer = self.one.compare(**endless(timeout_ms))
            if answer.status != 503:
                break
        self.assertEqual((answer.status, answer.json()["status"]), (200, "timeout"), answer.body)
        self.assertTrue(holds({"result": answer.json()}, 0))

    def test_a_worker_refers_clients_to_a_front_end(self):
        answer = RIG.workers[0].ask("POST", "/v1/comparisons", headers={"Authorization": "Bearer " + TOKENS["alice"]})
        self.refused(answer, 404, "not-found")
        self.assertIn("of a front end", answer.json()["detail"])

    def test_a_worker_reads_its_keys_again(self):
        token, entry = new_key("scrape", scopes=["metrics"])
        scrape = {"Authorization": "Bearer " + token}
        worker = RIG.workers[0]
        self.refused(worker.ask("GET", "/metrics", headers=scrape), 401, "unauthorized")
        write_keys(KEYS, *ENTRIES, entry)
        worker.process.send_signal(signal.SIGHUP)
        until(lambda: worker.ask("GET", "/metrics", headers=scrape).status == 200, 30, "the new key to be known")
        self.assertIn("keys: 3", [line.get("detail") for line in worker.lines() if line["event"] == "reload"])

    def test_what_cannot_be_read_is_refused_by_name(self):
        self.refused(self.one.compare(a=b"v 0 0 nan\n"), 422, "non-finite-vertex")

    def test_not_in_time_for_a_client_that_waits_a_little(self):
        answer = self.one.compare(**endless(100000), extra="Prefer: wait=1\r\n")
        self.assertEqual(answer.status, 202, answer.body)
        self.assertEqual(self.other.send("DELETE", answer.headers["location"]).status, 200)
        self.assertEqual(self.other.wait_for(answer.headers["location"], *ENDED)["state"], "cancelled")

    def test_events_at_the_other(self):
        path = self.one.begin_endless()
        with self.other.connect() as connection:
            connection.sendall(("GET %s/events HTTP/1.1\r\nHost: localhost\r\n%s\r\n" % (path, self.other.head)).encode())
            until(lambda: re.search(rb'"upper": ?\d', connection.recv(1 << 20, socket.MSG_PEEK)), what="an interval")
            self.assertEqual(self.one.send("DELETE", path).status, 200)
            events = list(events_of(read_answer(connection.makefile("rb")).body))
        self.assertEqual([name for name, _ in events], ["progress"] * (len(events) - 1) + ["end"])
        known = [event for _, event in events[:-1] if event["upper"] is not None]
        self.assertTrue(known, events)
        for before, after in zip(known, known[1:]):
            self.assertLessEqual(before["lower"], after["lower"])
            self.assertGreaterEqual(before["upper"], after["upper"])
        end = events[-1][1]
        self.assertEqual(end, self.one.get(path).json())
        self.assertEqual((end["state"], end["result"]["status"]), ("cancelled", "cancelled"))
        self.assertLessEqual(end["result"]["distance"]["upper"], known[-1]["upper"])

    def test_a_cancel_reaches_the_worker(self):
        path = self.one.begin_endless()
        self.one.wait_for(path, "running")
        until(lambda: (self.one.get(path).json()["progress"] or {}).get("upper") is not None, what="its first interval")
        answer = self.other.send("DELETE", path)
        self.assertEqual(answer.status, 200, answer.body)
        document = self.one.wait_for(path, *ENDED)
        self.assertEqual((document["state"], document["result"]["status"]), ("cancelled", "cancelled"))
        self.assertTrue(holds(document, 0), document)
        self.assertEqual(self.other.send("DELETE", path).status, 204)
        for client in (self.one, self.other):
            self.refused(client.get(path), 404, "not-found")

    def test_one_that_waits_is_cancelled_at_once(self):
        fill = [self.one.begin_endless() for _ in range(4)]  # as many as the workers run
        for path in fill:
            self.one.wait_for(path, "running")
        waiting = self.one.begin(0, 1, salt=self.salt)
        document = self.other.send("DELETE", waiting).json()
        self.assertEqual((document["state"], document["result"]), ("cancelled", None))
        self.assertEqual(document, self.one.get(waiting).json())
        for path in fill:
            self.assertEqual(self.other.send("DELETE", path).status, 200)

    def test_a_client_that_disconnects_ends_a_plain_comparison(self):
        with self.one.connect() as connection:
            connection.sendall(self.one.request_of(**endless(100000)))
            until(lambda: self.running() == 1, what="it to run")
        until(lambda: self.running() == 0, what="it to end")

    def running(self):
        return int(RIG.query("SELECT count(*) FROM jobs WHERE state = 1"))


class Repeats(Case):
    def test_the_same_at_the_other(self):
        key = "Idempotency-Key: %s\r\n" % self.salt
        first, again = (client.compare(extra=key) for client in (self.one, self.other))
        self.assertEqual((first.status, first.json()), (again.status, again.json()))
        self.assertEqual(first.headers["location"], again.headers["location"])
        self.refused(self.other.compare(b=square(7), extra=key), 422, "idempotency-key-reused")

    def test_many_at_once_at_both_are_one(self):
        key = "Idempotency-Key: %s\r\n" % self.salt
        answers = []
        threads = [threading.Thread(target=lambda client=client, extra=extra: answers.append(
            client.compare(square(0, 20, self.salt), square(1), extra=key + extra)))
            for client in (self.one, self.other) for extra in (ASYNC, "", ASYNC, "")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertLessEqual({answer.status for answer in answers}, {200, 202})
        self.assertEqual(len({answer.headers["location"] for answer in answers}), 1)

    def test_the_same_key_of_another_owner(self):
        key = "Idempotency-Key: %s\r\n" % self.salt
        bob = Client(RIG.front_ends[1], TOKENS["bob"])
        ours, theirs = self.one.compare(extra=key), bob.compare(b=square(5), extra=key)
        self.assertEqual((ours.status, theirs.status), (200, 200))
        self.assertNotEqual(ours.headers["location"], theirs.headers["location"])


class Owners(Case):
    def test_what_one_has_the_other_does_not_see(self):
        path = self.one.begin(0, 2, salt=self.salt)
        self.one.wait_for(path, "done")
        for front_end in RIG.front_ends:
            bob = Client(front_end, TOKENS["bob"])
            self.refused(bob.get(path), 404, "not-found")
            self.refused(bob.get(path + "/events"), 404, "not-found")
            self.refused(bob.send("DELETE", path), 404, "not-found")
            self.refused(Client(front_end).get(path), 401, "unauthorized")
        self.assertEqual(self.other.get(path).status, 200)

    def test_meshes_as_well(self):
        mesh = square(0, 1, self.salt)
        self.assertEqual(self.one.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n").status, 201)
        self.refused(Client(RIG.front_ends[1], TOKENS["bob"]).get(path_of(mesh)), 404, "not-found")


class Meshes(Case):
    def test_put_at_one_and_used_at_the_other(self):
        a, b = square(0, 3, self.salt), square(6, 60, self.salt)
        for mesh in (a, b):
            self.assertEqual(self.one.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n").status, 201)
            self.assertEqual(self.other.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n").status, 200)
            self.assertEqual(self.other.get(path_of(mesh)).json(), self.one.get(path_of(mesh)).json())
        body = json.dumps({"a": id_of(a), "b": id_of(b)}).encode()
        for client in (self.other, self.one):
            answer = client.send("POST", "/v1/comparisons", body, "Content-Type: application/json\r\n")
            self.assertEqual(answer.status, 200, answer.body)
            self.assertTrue(holds({"result": answer.json()}, 6), answer.body)
            self.assertEqual([answer.json()["meshes"][name]["sha256"] for name in "ab"], [id_of(a), id_of(b)])
        self.assertEqual(self.one.send("DELETE", path_of(a)).status, 204)
        self.refused(self.other.get(path_of(a)), 404, "not-found")
        answer = self.other.send("POST", "/v1/comparisons", body, "Content-Type: application/json\r\n")
        self.assertEqual(answer.status, 422, answer.body)

    def test_deleted_while_a_job_needs_it(self):
        a, b = square(0, 40, self.salt), square(0, 43, self.salt)
        for mesh in (a, b):
            self.one.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n")
        body = json.dumps({"a": id_of(a), "b": id_of(b), "options": {"tolerance": {"diagonal": 1e-3}}}).encode()
        answer = self.one.send("POST", "/v1/comparisons", body, "Content-Type: application/json\r\n" + ASYNC)
        self.assertEqual(self.other.send("DELETE", path_of(a)).status, 204)
        document = self.other.wait_for(answer.headers["location"], *ENDED)
        self.assertEqual((document["state"], document["result"]["status"]), ("done", "converged"))

    def test_a_map_of_what_another_front_end_took(self):
        for mesh in (square(0, 5, self.salt), square(2, 5, self.salt)):
            self.assertEqual(self.one.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n").status, 201)
        a, b = square(0, 5, self.salt), square(2, 5, self.salt)
        for mesh in (a, b):
            self.one.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n")
        body = json.dumps({"a": id_of(a), "b": id_of(b)}).encode()
        answer = self.one.send("POST", "/v1/comparisons", body, "Content-Type: application/json\r\n")
        path = "/v1/comparisons/" + answer.json()["id"]
        maps = [client.get(path + "/deviation.ply") for client in (self.other, self.one)]
        self.assertEqual([answer.status for answer in maps], [200, 200], maps[0].body[:300])
        self.assertEqual(maps[0].body, maps[1].body)


class Batches(Case):
    def submit(self, client, *pairs, options=None):
        """The path of a batch of stored meshes."""
        for mesh in {mesh for pair in pairs for mesh in pair}:
            self.assertIn(client.send("PUT", path_of(mesh), mesh, "Content-Type: model/obj\r\n").status, (200, 201))
        comparisons = [{"a": id_of(a), "b": id_of(b)} for a, b in pairs]
        body = json.dumps({"options": options or {}, "comparisons": comparisons}).encode()
        answer = client.send("POST", "/v1/batches", body, "Content-Type: application/json\r\n")
        self.assertEqual(answer.status, 202, answer.body)
        return answer.headers["location"]

    def ended(self, client, path):
        until(lambda: client.get(path).json()["finished"], what="the end of " + path)
        return client.get(path).json()["counts"], [json.loads(line) for line in client.get(path + "/results.jsonl").body.splitlines()]

    def test_sent_at_one_and_read_at_both(self):
        heights = [1, 2, 3, 2, 1]
        path = self.submit(self.one, *((square(0, 1, self.salt), square(height)) for height in heights))
        counts, lines = self.ended(self.other, path)
        self.assertEqual((counts["total"], counts["done"]), (5, 5))
        self.assertEqual([line["position"] for line in lines], list(range(5)))
        for line, height in zip(lines, heights):
            self.assertTrue(holds(line, height), line)
        self.assertEqual([line["comparison"] for line in lines], [lines[i]["comparison"] for i in (0, 1, 2, 1, 0)])
        self.assertEqual(len({line["comparison"] for line in lines}), 3)
        self.assertEqual(self.ended(self.one, path), (counts, lines))
        again = self.submit(self.other, (square(0, 1, self.salt), square(3)))
        self.assertEqual(self.ended(self.one, again)[1][0]["comparison"], lines[2]["comparison"])

    def test_a_cancel_of_one_leaves_the_other(self):
        pairs = [(square(0, 40, self.salt + str(i)), square(0, 43)) for i in range(6)]
        options = endless(100000)["options"]
        kept = self.submit(self.one, pairs[0], options=options)
        path = self.submit(self.other, *pairs, options=options)
        self.assertEqual(self.one.send("DELETE", path).status, 200)
        until(lambda: self.other.get(path).json()["counts"]["cancelled"] == 5, what="all but one to be cancelled")
        counts = self.other.get(kept).json()["counts"]
        self.assertEqual(counts["queued"] + counts["running"], 1, counts)
        self.assertEqual(self.other.send("DELETE", kept).status, 200)
        counts, lines = self.ended(self.other, path)
        self.assertEqual((counts["total"], counts["cancelled"]), (6, 6))
        self.assertEqual(self.ended(self.one, kept)[1], [{**lines[0], "position": 0}])
        for line in lines:
            self.assertTrue(line["result"] is None or holds(line, 0), line)


def id_of(mesh):
    return hashlib.sha256(mesh).hexdigest()


def path_of(mesh):
    return "/v1/meshes/" + id_of(mesh)


if __name__ == "__main__":
    unittest.main()
