"""One pair in parts on two workers (docs/sharding.md), whichever front end is asked."""

import unittest

from fixture import wavy_grid
from postgres import Missing
from rig import ASYNC, ENDED, Rig, endless, holds, until
from contract import events_of

RIG = None
PAIR = dict(a=wavy_grid(60, 0.2), b=wavy_grid(47, 0.21))
TOLERANCE = {"tolerance": {"diagonal": 1e-6}}


def setUpModule():
    global RIG
    try:
        RIG = Rig(front_ends=2, workers=2)
    except Missing as reason:
        raise unittest.SkipTest(str(reason)) from None


def tearDownModule():
    if RIG is not None:
        RIG.stop()


def meet(result, other):
    mine, its = result["distance"], other["distance"]
    return mine["lower"] <= its["upper"] and its["lower"] <= mine["upper"]


def endless_in_parts(timeout_ms, shards=2):
    pair = endless(timeout_ms)
    return {**pair, "options": {**pair["options"], "shards": shards}}


class Shards(unittest.TestCase):
    def setUp(self):
        self.one, self.other = RIG.client(0), RIG.client(1)

    def begin(self, timeout_ms=100000, shards=2):
        answer = self.one.compare(**endless_in_parts(timeout_ms, shards), extra=ASYNC)
        self.assertEqual(answer.status, 202, answer.body)
        return answer.headers["location"]

    def test_they_give_what_one_piece_gives(self):
        whole = self.one.compare(**PAIR, options=TOLERANCE).json()
        self.assertEqual(whole["engine"]["shards"], 1)
        for shards in (2, 5):
            options = {**TOLERANCE, "shards": shards}
            waited_for = self.one.compare(**PAIR, options=options)
            self.assertEqual(waited_for.status, 200, waited_for.body)
            path = self.one.compare(**PAIR, options=options, extra=ASYNC).headers["location"]
            for result in (waited_for.json(), self.other.wait_for(path, *ENDED)["result"]):
                self.assertEqual((result["status"], result["engine"]["shards"]), ("converged", shards))
                self.assertTrue(meet(result, whole), (result, whole))
                self.assertEqual(result["meshes"], whole["meshes"])

    def test_their_time_ends_them_with_an_interval(self):
        answer = self.one.compare(**endless_in_parts(1500))
        self.assertEqual((answer.status, answer.json()["status"]), (200, "timeout"), answer.body)
        self.assertEqual(answer.json()["engine"]["shards"], 2)
        self.assertTrue(holds({"result": answer.json()}, 0))

    def test_who_watches_sees_the_interval_of_all(self):
        path = self.begin(3000)
        answer = self.other.get(path + "/events")
        events = list(events_of(answer.body))
        known = [event for name, event in events if name == "progress" and event["upper"] is not None]
        self.assertGreater(len(known), 1, events)
        self.assertEqual({event["state"] for event in known}, {"running"})
        end = events[-1][1]
        self.assertEqual((end["state"], end["result"]["status"], end["result"]["engine"]["shards"]), ("done", "timeout", 2))
        self.assertLessEqual(end["result"]["distance"]["upper"], known[-1]["upper"])

    def test_a_cancel_ends_them_all(self):
        path = self.begin(shards=3)
        until(lambda: self.running() == 3, what="all parts to run")
        self.assertEqual(self.other.send("DELETE", path).json()["state"], "cancelled")
        until(lambda: self.running() == 0, what="them to end")

    def test_a_worker_that_dies_takes_no_part_with_it(self):
        path = self.begin(4000, shards=4)
        until(lambda: self.running() == 4, what="all parts to run")
        RIG.workers[0].kill()
        try:
            document = self.other.wait_for(path, *ENDED)
        finally:
            RIG.workers[0].start()
        self.assertEqual((document["state"], document["result"]["engine"]["shards"]), ("done", 4))
        self.assertTrue(holds(document, 0), document)

    def test_the_whole_fails_as_a_part_does(self):
        answer = self.one.compare(a=b"v 0 0 nan\n", b=PAIR["b"], options={"shards": 3})
        self.assertEqual((answer.status, answer.json()["type"]), (422, "urn:meshgauge:problem:non-finite-vertex"), answer.body)

    def running(self):
        return int(RIG.postgres.query("SELECT count(*) FROM jobs WHERE state = 1"))


if __name__ == "__main__":
    unittest.main()
