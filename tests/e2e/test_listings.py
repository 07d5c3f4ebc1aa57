"""What a key has in the service, listed page by page."""

import json
import unittest

from harness import RAISED, SLOW, SLOW_OPTIONS, SQUARE, ServerCase, until
from keys import TwoKeys, bearer
from test_meshes import JSON, OVERHEAD, id_of, path_of


class Lists(TwoKeys):
    def pages(self, token, path, name, limit):
        """Every entry of a list, from page to page."""
        entries, query = [], "?limit=%d" % limit
        while True:
            answer = self.send(token, "GET", path + query)
            self.assertEqual(answer.status, 200, answer.body)
            document = answer.json()
            entries += document[name]
            if document["next"] is None:
                self.assertLessEqual(len(document[name]), limit)
                return entries
            self.assertEqual(len(document[name]), limit)
            query = "?limit=%d&after=%s" % (limit, document["next"])

    def test_a_list_shows_what_fills_the_quota(self):
        empty = self.send(self.mine, "GET", "/v1/meshes").json()
        self.assertEqual((empty["meshes"], empty["next"]), ([], None))
        stored = [b"# %d\n" % number + SQUARE for number in range(5)]
        for mesh in stored:
            self.send(self.mine, "PUT", path_of(mesh), mesh)
        self.send(self.theirs, "PUT", path_of(SQUARE), SQUARE)
        for limit in (1, 2, 5, 100):
            listed = self.pages(self.mine, "/v1/meshes", "meshes", limit)
            self.assertCountEqual([mesh["id"] for mesh in listed], [id_of(mesh) for mesh in stored])
            order = [(mesh["created"], mesh["id"]) for mesh in listed]
            self.assertEqual(order, sorted(order, reverse=True))
            self.assertEqual(listed[0], self.send(self.mine, "GET", "/v1/meshes/" + listed[0]["id"]).json())
        used = self.send(self.mine, "GET", "/v1/meshes?limit=1").json()["used"]
        self.assertEqual(used["meshes"], 5)
        self.assertEqual(used["bytes"], sum(len(mesh) + OVERHEAD for mesh in stored))
        self.assertEqual(used["max_bytes"], 1_000_000)
        self.assertEqual([mesh["id"] for mesh in self.pages(self.theirs, "/v1/meshes", "meshes", 9)], [id_of(SQUARE)])
        self.assertEqual(self.send(self.mine, "HEAD", "/v1/meshes").status, 200)

    def test_a_list_of_comparisons(self):
        passed = self.server.compare(options=b'{"gate": {"max_distance": 3}}', extra=bearer(self.mine))
        self.server.compare(extra=bearer(self.theirs))
        running = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n" + bearer(self.mine))
        location = running.headers["location"]
        self.addCleanup(self.send, self.mine, "DELETE", location)
        for limit in (1, 10):
            listed = self.pages(self.mine, "/v1/comparisons", "comparisons", limit)
            self.assertEqual([one["id"] for one in listed], [location.split("/")[-1], passed.headers["x-request-id"]])
        first, last = listed
        self.assertIn(first["state"], ("queued", "running"))
        self.assertIsNone(first["finished"])
        self.assertEqual((last["state"], last["verdict"], last["batch"]), ("done", "pass", None))
        self.assertEqual(last["a"]["file_name"], "a.obj")
        used = self.send(self.mine, "GET", "/v1/comparisons").json()["used"]
        self.assertEqual((used["done"], used["queued"] + used["running"], used["jobs"], used["max_jobs"]), (1, 1, 1, 1))
        self.assertEqual(used["bytes"], len(SLOW["a"]) + len(SLOW["b"]))

    def test_a_list_of_batches(self):
        for mesh in (SQUARE, RAISED):
            self.send(self.mine, "PUT", path_of(mesh), mesh)
        pair = {"a": id_of(SQUARE), "b": id_of(RAISED)}
        for name in ("first", "second"):
            manifest = json.dumps({"name": name, "comparisons": [{**pair, "name": name}]}).encode()
            answer = self.send(self.mine, "POST", "/v1/batches", manifest, JSON)
            self.assertEqual(answer.status, 202, answer.body)
            until(lambda: self.send(self.mine, "GET", answer.headers["location"]).json()["state"] == "done")
        listed = self.pages(self.mine, "/v1/batches", "batches", 1)
        self.assertEqual(sorted(batch["name"] for batch in listed), ["first", "second"])
        self.assertEqual([batch["unended"] for batch in listed], [0, 0])
        used = self.send(self.mine, "GET", "/v1/batches").json()["used"]
        self.assertEqual((used["batches"], used["unended_batches"], used["unended_comparisons"]), (2, 0, 0))
        comparisons = self.pages(self.mine, "/v1/comparisons", "comparisons", 10)
        self.assertIn(comparisons[0]["batch"], [batch["id"] for batch in listed])
        self.assertEqual(self.pages(self.theirs, "/v1/batches", "batches", 1), [])

    def test_what_is_no_page(self):
        for path in ("/v1/meshes", "/v1/comparisons", "/v1/batches"):
            for query in ("limit=0", "limit=101", "limit=x", "limit=", "limit=1&limit=2", "after=", "after=1", "after=-",
                          "after=x-1", "after=1-", "after=99999999999999999999-1", "after=1-" + "0" * 65, "page=2"):
                answer = self.send(self.mine, "GET", path + "?" + query)
                self.assertEqual((answer.status, answer.json()["type"]), (400, "/problems/malformed-request"))
                self.assertIn(query.split("=")[0], answer.json()["detail"])
            self.assertEqual(self.send(self.mine, "GET", path + "?after=0-0&limit=7").status, 200)


class WithoutKeys(ServerCase):
    def test_without_keys_nothing_is_listed(self):
        for path in ("/v1/meshes", "/v1/comparisons", "/v1/batches"):
            problem = self.refused(self.server.get(path), 403, "forbidden")
            self.assertIn("without keys", problem["detail"])


if __name__ == "__main__":
    unittest.main()
