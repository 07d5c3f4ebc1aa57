"""Batches: many comparisons by one request, watched, reported together, cancelled, shared, and continued after a restart."""

import json
import os
import signal
import tempfile
import unittest
import xml.etree.ElementTree as ET
from pathlib import Path

from contract import events_of
from harness import RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, flat_grid, multipart, read_answer, until
from keys import bearer, new_key, write_keys

AS_JSON = "Content-Type: application/json\r\n"
AS_FORM = "Content-Type: multipart/form-data; boundary=XXboundaryXX\r\n"
PATH = "/v1/batches"


def raised(height):
    return RAISED.replace(b" 2\n", b" %r\n" % height)


def put(server, mesh, extra="", name=""):
    disposition = 'Content-Disposition: attachment; filename="%s"\r\n' % name if name else ""
    answer = server.send("POST", "/v1/meshes", mesh, extra + disposition)
    assert answer.status in (200, 201), answer.body
    return answer.json()["id"]


def submit(server, manifest, extra=""):
    return server.send("POST", PATH, json.dumps(manifest).encode(), AS_JSON + extra)


def send_form(server, *parts, extra=""):
    return server.send("POST", PATH, multipart(parts), AS_FORM + extra)


def pairs(*ids, **members):
    return {"comparisons": [{"a": a, "b": b} for a, b in ids], **members}


def accepted(answer):
    assert answer.status == 202, answer.body
    return answer.headers["location"]


def ended(server, path, extra=""):
    until(lambda: server.get(path, extra=extra).json()["finished"])
    return server.get(path, extra=extra).json()


def results(server, path):
    answer = server.get(path + "/results.jsonl")
    assert answer.status == 200
    return [json.loads(line) for line in answer.body.splitlines()]


def slow_pairs(server, count, extra=""):
    """Each runs for long."""
    a, b = put(server, SLOW["a"], extra), put(server, SLOW["b"], extra)
    comparisons = [{"a": a, "b": b, "options": {"tolerance": {"absolute": i * 1e-12}}} for i in range(count)]
    return {"options": SLOW_OPTIONS, "comparisons": comparisons}


class Done(ServerCase):
    flags = ("--workers", "2")

    def test_from_the_manifest_to_the_report(self):
        flat = put(self.server, SQUARE)
        up = [put(self.server, raised(height)) for height in (1, 2, 3)]
        manifest = {"name": "heights, <& all>", "options": {"gate": {"max_distance": 2.5, "units": "mm"}},
                    "comparisons": [{"name": "low \"1\"", "a": flat, "b": up[0]},
                                    {"a": flat, "b": up[1], "options": {"gate": {"max_distance": 1}}},
                                    {"name": "high", "a": flat, "b": up[2]},
                                    {"name": "at once", "a": flat, "b": up[2], "options": {"timeout_ms": 1}},
                                    {"name": "Ünïcode", "a": flat, "b": flat}]}
        answer = submit(self.server, manifest)
        path = accepted(answer)
        self.assertEqual(answer.json()["counts"]["total"], 5)
        batch = ended(self.server, path)
        self.assertEqual((batch["state"], batch["name"]), ("done", manifest["name"]))
        counts = batch["counts"]
        self.assertEqual(counts["done"] + counts["failed"], 5)
        self.assertEqual((counts["queued"], counts["running"], counts["gone"]), (0, 0, 0))
        self.assertGreaterEqual(counts["pass"], 2)
        self.assertGreaterEqual(counts["fail"], 2)
        self.assertLess(batch["finished"], batch["expires"])
        first = batch["failures"][:2]
        self.assertEqual([(f["position"], f["name"], f["verdict"]) for f in first], [(1, None, "fail"), (2, "high", "fail")])
        self.assertLessEqual(first[0]["distance"]["lower"], 2)
        self.assertGreaterEqual(first[0]["distance"]["upper"], 2)
        self.assertEqual([f["gate"]["max_distance"] for f in first], [1, 2.5])
        self.check_view(answer.json(), batch)
        self.check_results(path, batch)
        self.check_report(path, batch)

    def check_view(self, *documents):
        page = os.environ.get("MESHGAUGE_DOCS", "1") == "1"
        for batch in documents:
            self.assertEqual(batch.get("view"), "/b/" + batch["id"] if page else None)

    def check_results(self, path, batch):
        lines = results(self.server, path)
        self.assertEqual([line["position"] for line in lines], list(range(5)))
        self.assertEqual(lines[0]["name"], "low \"1\"")
        for line in lines:
            job = self.server.get("/v1/comparisons/" + line["comparison"]).json()
            self.assertEqual((job["state"], job["result"], job["problem"]), (line["state"], line["result"], line["problem"]))
        self.assertEqual([line["verdict"] for line in lines[:3]], ["pass", "fail", "fail"])
        self.assertEqual(lines[0]["result"]["gate"], {"max_distance": 2.5, "units": "mm"})
        self.assertEqual(lines[1]["result"]["gate"], {"max_distance": 1, "units": None})
        told = list(events_of(self.server.get(path + "/events").body))
        self.assertEqual(told, [("end", batch)])
        map_of = self.server.get("/v1/comparisons/%s/deviation.ply" % lines[0]["comparison"])
        self.assertEqual(map_of.status, 200)

    def check_report(self, path, batch):
        answer = self.server.get(path + "/junit.xml")
        suite, = ET.fromstring(answer.body)
        self.assertEqual(suite.get("name"), batch["name"])
        cases = suite.findall("testcase")
        self.assertEqual(len(cases), int(suite.get("tests")))
        self.assertEqual(len(suite.findall("testcase/failure")), int(suite.get("failures")))
        self.assertEqual(len(suite.findall("testcase/error")), int(suite.get("errors")))
        self.assertEqual([case.get("name") for case in cases], ["low \"1\"", "comparison 1", "high", "at once", "Ünïcode"])
        self.assertEqual(len(cases[0]), 0)
        failure = cases[2].find("failure")
        self.assertEqual(failure.get("type"), "fail")
        self.assertIn("above the limit of 2.5 mm", failure.get("message"))

    def test_without_a_gate_or_a_name(self):
        flat = put(self.server, SQUARE)
        batch = ended(self.server, accepted(submit(self.server, pairs((flat, flat)))))
        self.assertEqual((batch["name"], batch["failures"], batch["counts"]["done"]), (None, [], 1))
        self.assertEqual(batch["counts"]["pass"], 0)

    def test_files_that_come_along(self):
        flat = put(self.server, SQUARE)
        manifest = {"comparisons": [{"a": {"part": "new"}, "b": flat}, {"a": flat, "b": {"part": "other"}},
                                    {"a": {"part": "new"}, "b": {"part": "other"}}, {"a": {"part": "bad"}, "b": flat}]}
        answer = send_form(self.server, ("manifest", json.dumps(manifest).encode()), ("other", raised(5)),
                           ("new", raised(4)), ("bad", b"v 0 0 nan\n"))
        path = accepted(answer)
        batch = ended(self.server, path)
        self.assertEqual((batch["counts"]["done"], batch["counts"]["failed"]), (3, 1))
        self.assertEqual(batch["failures"][0]["problem"]["type"], "/problems/non-finite-vertex")
        for line, height in zip(results(self.server, path), (4, 5, 1)):
            self.assertLessEqual(line["result"]["distance"]["lower"], height)
            self.assertGreaterEqual(line["result"]["distance"]["upper"], height)
        self.assertEqual(batch["failures"][0]["position"], 3)

    def test_equal_work_is_done_once(self):
        a, b = put(self.server, flat_grid(5)), put(self.server, raised(7))
        first = accepted(submit(self.server, pairs((a, b), (b, a), (a, b))))
        ended(self.server, first)
        ids = [line["comparison"] for line in results(self.server, first)]
        self.assertEqual(ids[0], ids[2])
        self.assertNotEqual(ids[0], ids[1])
        again = submit(self.server, pairs((a, b)))
        self.assertEqual(again.json()["state"], "done")
        self.assertEqual([line["comparison"] for line in results(self.server, accepted(again))], ids[:1])
        self.assertEqual(self.server.send("DELETE", first).status, 204)
        self.assertEqual(self.server.get(first).status, 404)
        self.assertEqual(self.server.get("/v1/comparisons/" + ids[1]).status, 404)
        self.assertEqual(self.server.get("/v1/comparisons/" + ids[0]).status, 200)  # of the other one as well

    def test_the_same_request_twice(self):
        flat, key = put(self.server, SQUARE), "Idempotency-Key: nightly\r\n"
        first = submit(self.server, pairs((flat, flat), name="one"), key)
        again = submit(self.server, pairs((flat, flat), name="one"), key)
        self.assertEqual(accepted(first), accepted(again))
        self.refused(submit(self.server, pairs((flat, flat), name="two"), key), 422, "idempotency-key-reused")
        self.assertEqual(self.server.compare(extra=key).status, 200)  # comparisons have theirs apart
        form = ("manifest", json.dumps({"comparisons": [{"a": {"part": "x"}, "b": flat}]}).encode()), ("x", raised(9))
        key = "Idempotency-Key: form\r\n"
        self.assertEqual(accepted(send_form(self.server, *form, extra=key)), accepted(send_form(self.server, *form, extra=key)))
        self.refused(send_form(self.server, form[0], ("x", raised(8)), extra=key), 422, "idempotency-key-reused")

    def test_sent_again_while_it_is_forgotten(self):
        manifest = {"comparisons": [{"a": {"part": "x"}, "b": {"part": "y"}}]}
        form = multipart((("manifest", json.dumps(manifest).encode()), ("x", raised(21)), ("y", raised(22))))
        key = AS_FORM + "Idempotency-Key: forgotten\r\n"
        first = accepted(self.server.send("POST", PATH, form, key))
        ended(self.server, first)
        with self.server.connect() as connection:
            stream = connection.makefile("rb")
            connection.sendall(("POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\nExpect: 100-continue\r\n%s\r\n"
                                % (PATH, len(form), key)).encode())
            self.assertEqual(stream.readline(), b"HTTP/1.1 100 Continue\r\n")  # its key was looked for
            self.assertEqual(self.server.send("DELETE", first).status, 204)
            stream.readline()
            connection.sendall(form)
            problem = self.refused(read_answer(stream), 503, "storage-unavailable")
        self.assertIn("was removed while the request arrived", problem["detail"])
        anew = accepted(self.server.send("POST", PATH, form, key))
        self.assertNotEqual(anew, first)
        self.assertEqual(ended(self.server, anew)["counts"]["done"], 1)

    def test_one_forgotten_comparison(self):
        a, b = put(self.server, raised(11)), put(self.server, raised(12))
        path = accepted(submit(self.server, pairs((a, b), (b, a))))
        ended(self.server, path)
        gone = results(self.server, path)[0]["comparison"]
        self.assertEqual(self.server.send("DELETE", "/v1/comparisons/" + gone).status, 204)
        self.assertEqual(self.server.get(path).json()["counts"]["gone"], 1)
        line = results(self.server, path)[0]
        self.assertEqual((line["position"], line["state"], line["comparison"]), (0, "gone", None))
        self.assertIn(b'type="gone"', self.server.get(path + "/junit.xml").body)


class Refused(ServerCase):
    flags = ("--max-batch-pairs", "3", "--max-part-bytes", "100000")

    def invalid(self, manifest, where, form=False):
        answer = send_form(self.server, ("manifest", json.dumps(manifest).encode())) if form else submit(self.server, manifest)
        problem = self.refused(answer, 422, "invalid-request")
        self.assertEqual([(error["part"], error["where"]) for error in problem["errors"]],
                         [("manifest" if form else "body", where)])

    def test_what_a_manifest_may_not_say(self):
        flat = put(self.server, SQUARE)
        good = {"a": flat, "b": flat}
        for manifest, where in (
                ([], ""), ({}, "/comparisons"), ({"comparisons": []}, "/comparisons"), ({"comparisons": {}}, "/comparisons"),
                ({"comparisons": [good], "gates": []}, "/gates"), ({"comparisons": [good], "name": ""}, "/name"),
                ({"comparisons": [good], "name": "a\nb"}, "/name"), ({"comparisons": [good], "name": 7}, "/name"),
                ({"comparisons": [good], "options": 7}, "/options"),
                ({"comparisons": [good], "options": {"tolerence": 1}}, "/options/tolerence"),
                ({"comparisons": [good], "options": {"gate": {"max_distance": -1}}}, "/options/gate/max_distance"),
                ({"comparisons": [good, {**good, "c": 1}]}, "/comparisons/1/c"),
                ({"comparisons": [good, {"a": flat}]}, "/comparisons/1/b"), ({"comparisons": [7]}, "/comparisons/0"),
                ({"comparisons": [{**good, "a": flat.upper()}]}, "/comparisons/0/a"),
                ({"comparisons": [{**good, "a": {"part": "x"}}]}, "/comparisons/0/a"),
                ({"comparisons": [good, {**good, "options": {"threads": 0}}]}, "/comparisons/1/options/threads"),
                ({"comparisons": [good, {**good, "options": []}]}, "/comparisons/1/options")):
            self.invalid(manifest, where)
        self.invalid({"comparisons": [{**good, "a": {"part": "x", "y": 1}}]}, "/comparisons/0/a/y", form=True)
        self.invalid({"comparisons": [{**good, "a": {}}]}, "/comparisons/0/a/part", form=True)
        twice = b'{"comparisons": [], "comparisons": []}'
        self.refused(self.server.send("POST", PATH, twice, AS_JSON), 422, "invalid-request")
        self.refused(self.server.send("POST", PATH, b"{", AS_JSON), 422, "invalid-request")

    def test_too_many_or_too_much(self):
        flat = put(self.server, SQUARE)
        self.refused(submit(self.server, pairs(*[(flat, flat)] * 4)), 413, "too-large")
        self.assertEqual(submit(self.server, pairs(*[(flat, flat)] * 3)).status, 202)
        self.refused(self.server.send("POST", PATH, b" " * 200_000, AS_JSON), 413, "too-large")
        manifest = json.dumps({"comparisons": [{"a": {"part": "x"}, "b": flat}]}).encode()
        self.refused(send_form(self.server, ("manifest", manifest), ("x", bytes(100_001))), 413, "too-large")

    def test_meshes_that_are_not_stored(self):
        flat = put(self.server, SQUARE)
        problem = self.refused(submit(self.server, pairs((flat, "1" * 64), (flat, flat), ("2" * 64, "1" * 64))), 422, "unknown-mesh")
        self.assertEqual([error["where"] for error in problem["errors"]],
                         ["/comparisons/0/b", "/comparisons/2/a", "/comparisons/2/b"])

    def test_parts(self):
        flat = put(self.server, SQUARE)
        manifest = ("manifest", json.dumps({"comparisons": [{"a": {"part": "x"}, "b": flat}]}).encode())
        for parts in ((("x", SQUARE), manifest), (manifest,), (manifest, ("x", SQUARE), ("y", SQUARE)),
                      (manifest, ("x", SQUARE), ("x", SQUARE)), (manifest, manifest, ("x", SQUARE)), (("x", SQUARE),)):
            self.refused(send_form(self.server, *parts), 400, "malformed-request")
        self.refused(self.server.send("POST", PATH, b"{}", "Content-Type: text/plain\r\n"), 415, "unsupported-media-type")

    def test_what_is_not_there(self):
        path = PATH + "/" + "0" * 32
        for place in (path, path + "/events", path + "/results.jsonl", path + "/junit.xml"):
            self.refused(self.server.get(place), 404, "not-found")
            self.refused(self.server.get(place + "?x=1"), 400, "malformed-request")
        self.refused(self.server.send("DELETE", path), 404, "not-found")
        self.refused(self.server.send("POST", path + "/cancel"), 404, "not-found")
        self.refused(self.server.send("DELETE", path + "?x=1"), 400, "malformed-request")
        self.refused(self.server.send("POST", PATH + "?x=1"), 400, "malformed-request")

    def test_older_clients(self):
        flat = put(self.server, SQUARE)
        path = accepted(submit(self.server, pairs((flat, flat))))
        ended(self.server, path)
        for place in ("/events", "/results.jsonl", "/junit.xml"):
            self.assertEqual(self.server.raw(b"GET %s HTTP/1.0\r\n\r\n" % (path + place).encode()).status, 505)
            self.assertEqual(self.server.get(path + place, method="HEAD").status, 200)


class Running(unittest.TestCase):
    def start(self, *flags, **more):
        server = Server("--workers", "1", *flags, **more)
        self.addCleanup(server.stop)
        return server

    def test_cancelled(self):
        server = self.start()
        manifest = slow_pairs(server, 3)
        path = accepted(submit(server, manifest))
        shared = {**manifest, "comparisons": manifest["comparisons"][2:]}
        other = accepted(submit(server, shared))
        until(lambda: server.get(path).json()["counts"]["running"])
        self.assertEqual(server.get(path + "/junit.xml").status, 409)
        answer = server.send("POST", path + "/cancel")
        self.assertEqual(answer.status, 200)
        until(lambda: server.get(path).json()["counts"]["cancelled"] == 2)  # the third is the other one's as well
        self.assertEqual(server.send("DELETE", other).status, 200)
        batch = ended(server, path)
        self.assertEqual((batch["state"], batch["counts"]["cancelled"]), ("cancelled", 3))
        self.assertEqual([failure["state"] for failure in batch["failures"]], ["cancelled"] * 3)
        suite, = ET.fromstring(server.get(path + "/junit.xml").body)
        self.assertEqual(suite.get("errors"), "3")
        self.assertEqual(server.send("DELETE", path).status, 204)
        self.assertEqual(server.get(other).json()["counts"]["cancelled"], 1)

    def test_done_after_a_restart(self):
        with tempfile.TemporaryDirectory() as folder:
            server = self.start("--data-dir", folder)
            meshes = [put(server, raised(height)) for height in range(20, 40)]
            manifest = slow_pairs(server, 1)
            manifest["comparisons"] += [{"a": a, "b": b, "options": {"tolerance": {"relative": 0.01, "diagonal": 1e-6}}}
                                        for a in meshes for b in meshes[:3]]
            path = accepted(submit(server, manifest))
            until(lambda: server.get(path).json()["counts"]["running"])
            server.stop(signal.SIGKILL)
            server = self.start("--data-dir", folder)
            until(lambda: server.get(path).json()["counts"]["done"] == 60)
            self.assertEqual(server.send("DELETE", path).status, 200)
            self.assertEqual(ended(server, path)["counts"]["cancelled"], 1)

    def test_as_many_as_may_wait(self):
        server = self.start("--max-batch-pairs", "2", "--grace-ms", "0")
        for i in range(11):
            manifest = slow_pairs(server, 2)
            manifest["options"] = {**SLOW_OPTIONS, "timeout_ms": 100000 - i}
            answer = submit(server, manifest)
            if answer.status != 202:
                break
        self.assertEqual((answer.status, answer.json()["type"]), (503, "/problems/overloaded"))
        self.assertGreater(i, 9)

    def test_keys_see_their_own_alone(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        (ann, first), (bob, second) = new_key("ann"), new_key("bob")
        write_keys(Path(folder.name) / "keys.json", first, second)
        server = self.start("--keys-file", folder.name + "/keys.json")
        flat = put(server, SQUARE, bearer(ann))
        self.assertEqual(submit(server, pairs((flat, flat)), bearer(bob)).status, 422)
        path = accepted(submit(server, pairs((flat, flat)), bearer(ann)))
        self.assertEqual(ended(server, path, bearer(ann))["counts"]["done"], 1)
        for place in (path, path + "/events", path + "/results.jsonl", path + "/junit.xml"):
            self.assertEqual(server.get(place, extra=bearer(bob)).status, 404)
        self.assertEqual(server.send("DELETE", path, extra=bearer(bob)).status, 404)
        self.assertEqual(server.send("DELETE", path, extra=bearer(ann)).status, 204)


if __name__ == "__main__":
    unittest.main()
