"""Two keys of one service: what one has stored, runs or has warmed up says nothing to the other."""

import hashlib
import json
import os
import re
import statistics
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from victim import ASYNC, BINARY, ENDLESS, FORM, JSON, Victim, ask, multipart, square, until

REPETITIONS = int(os.environ.get("MESHGAUGE_REPETITIONS", "20"))
UNKNOWN = "0" * 64


def new_key(name, *flags):
    out = subprocess.run([BINARY, "keys", "new", name, *flags], capture_output=True, text=True, check=True).stdout
    token, entry = out.splitlines()
    return token, {**json.loads(entry), "requests_per_minute": 100000, "burst": 10000}


class Isolation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="meshgauge-isolation-")
        (cls.ann, ann), (cls.bob, bob) = new_key("ann"), new_key("bob")
        cls.watch, watch = new_key("watch", "--scope", "metrics")
        keys = Path(cls.folder.name) / "keys.json"
        keys.write_text(json.dumps({"keys": [ann, bob, watch]}))
        cls.server = Victim("--data-dir", cls.folder.name + "/data", "--keys-file", str(keys), "--workers", "2")

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        cls.folder.cleanup()

    def ask(self, key, method, path, body=None, headers=None):
        return ask(self.server.port, method, path, body, {**(headers or {}), "Authorization": "Bearer " + key})

    def store(self, key, mesh):
        return self.ask(key, "PUT", "/v1/meshes/" + hashlib.sha256(mesh).hexdigest(), mesh)

    def begin(self, key, headers=ASYNC, options=None, salt=""):
        body = multipart(square(1, 20, salt), square(1, 23), options or {**ENDLESS, "timeout_ms": 60000})
        answer = self.ask(key, "POST", "/v1/comparisons", body, {**FORM, **headers})
        self.assertIn(answer.status, (200, 202), answer.body)
        return answer.headers["location"]

    def same_refusal(self, method, foreign, unknown, body=None, headers=None):
        """Asserts that another key's object and a missing one get the same bytes, except for the request's id."""
        answers = [self.ask(self.bob, method, path, body, headers) for path in (foreign, unknown)]
        for answer in answers:
            self.assertEqual(answer.status, 404)
            for name in ("x-request-id", "traceparent", "traceresponse", "date"):
                answer.headers.pop(name, None)
        self.assertEqual(answers[0].body, answers[1].body)
        self.assertEqual(answers[0].headers, answers[1].headers)

    def test_meshes(self):
        mesh = square(1, 3, "ann's")
        identity = hashlib.sha256(mesh).hexdigest()
        path, unknown = "/v1/meshes/" + identity, "/v1/meshes/" + UNKNOWN
        self.assertEqual(self.store(self.ann, mesh).status, 201)
        for method in ("GET", "HEAD", "DELETE"):
            self.same_refusal(method, path, unknown)
        bodies = [self.ask(self.bob, "POST", "/v1/comparisons", json.dumps({"a": one, "b": one}).encode(), JSON)
                  for one in (identity, UNKNOWN)]
        self.assertEqual([answer.status for answer in bodies], [422, 422])
        self.assertEqual(bodies[0].body.replace(identity.encode(), UNKNOWN.encode()), bodies[1].body)
        self.assertEqual(self.store(self.bob, mesh).status, 201)
        self.assertEqual(self.ask(self.bob, "DELETE", path).status, 204)
        self.assertEqual(self.ask(self.ann, "GET", path).status, 200)
        self.assertEqual(self.store(self.ann, mesh).status, 200)

    def test_jobs_and_events(self):
        path = self.begin(self.ann)
        unknown = "/v1/comparisons/" + "0" * 32
        for method in ("GET", "HEAD", "DELETE"):
            self.same_refusal(method, path, unknown)
        self.same_refusal("GET", path + "/events", unknown + "/events")
        document = self.ask(self.ann, "GET", path).json()
        self.assertIn(document["state"], ("queued", "running"))  # the other key's DELETE did not cancel it
        self.assertEqual(self.ask(self.ann, "DELETE", path).status, 200)
        until(lambda: self.ask(self.ann, "GET", path).json()["state"] == "cancelled")
        for method in ("GET", "DELETE"):  # ended, and in the store alone
            self.same_refusal(method, path, unknown)
        self.same_refusal("GET", path + "/events", unknown + "/events")
        self.assertEqual(self.ask(self.ann, "DELETE", path).status, 204)

    def test_awaited_comparisons(self):
        answer = self.ask(self.ann, "POST", "/v1/comparisons", multipart(square(0), square(1), {}), FORM)
        path = "/v1/comparisons/" + answer.json()["id"]
        self.assertEqual(self.ask(self.ann, "GET", path).status, 200)
        self.same_refusal("GET", path, "/v1/comparisons/" + "0" * 32)
        self.same_refusal("DELETE", path, "/v1/comparisons/" + "0" * 32)

    def test_idempotency_keys(self):
        headers = {**ASYNC, "Idempotency-Key": "the-same"}
        ann = self.begin(self.ann, headers, {}, "ann")
        bob = self.begin(self.bob, headers, {}, "another content")  # no conflict
        self.assertNotEqual(ann, bob)
        self.assertEqual(self.begin(self.ann, headers, {}, "ann"), ann)

    def test_a_mesh_known_to_another_key_costs_as_much_to_store(self):
        """A sign test over pairs: were a mesh cheaper that another key has stored, most pairs would say so. Each upload
        follows one of the other key, of the same mesh or of another, so that what comes before is alike."""
        times = {"foreign": [], "new": [], "own": []}
        for i in range(REPETITIONS):
            for what in sorted(times, key=lambda _: os.urandom(1)):
                mesh, other = (square(1, 60, "%s %d %d" % (what, i, which)) for which in (0, 1))
                if what == "own":
                    self.assertEqual(self.store(self.bob, mesh).status, 201)
                self.assertEqual(self.store(self.ann, mesh if what == "foreign" else other).status, 201)
                began = time.perf_counter()
                answer = self.store(self.bob, mesh)
                times[what].append(time.perf_counter() - began)
                self.assertEqual(answer.status, 200 if what == "own" else 201)
        medians = {what: 1000 * statistics.median(values) for what, values in times.items()}
        differences = [foreign - new for foreign, new in zip(times["foreign"], times["new"])]
        cheaper = sum(difference < 0 for difference in differences)
        print("median ms to store: %s; foreign cheaper in %d of %d pairs" % (
            {what: round(value, 2) for what, value in medians.items()}, cheaper, REPETITIONS), flush=True)
        spread = 4 * REPETITIONS ** 0.5 / 2  # less than one in ten thousand by chance
        self.assertLessEqual(abs(cheaper - REPETITIONS / 2), spread)

    def cached_meshes(self):
        """How many meshes were found in the cache, and how many were not."""
        page = self.ask(self.watch, "GET", "/metrics").body.decode()
        return [int(float(re.search(r"^meshgauge_mesh_cache_%s_total (.*)$" % what, page, re.M)[1])) for what in ("hits", "misses")]

    def test_comparing_by_id_is_not_warm_for_another_key(self):
        a, b = square(0, 200, "warm"), square(1, 200, "warm")
        for key in (self.ann, self.bob):
            for mesh in (a, b):
                self.assertEqual(self.store(key, mesh).status, 201)
        body = json.dumps({"a": hashlib.sha256(a).hexdigest(), "b": hashlib.sha256(b).hexdigest()}).encode()

        def read(key):
            hits, misses = self.cached_meshes()
            self.assertEqual(self.ask(key, "POST", "/v1/comparisons", body, JSON).status, 200)
            now = self.cached_meshes()
            return {"hits": now[0] - hits, "misses": now[1] - misses}

        self.assertEqual(read(self.ann), {"hits": 0, "misses": 2})
        self.assertEqual(read(self.ann), {"hits": 2, "misses": 0})
        self.assertEqual(read(self.bob), {"hits": 0, "misses": 2})


if __name__ == "__main__":
    unittest.main()
