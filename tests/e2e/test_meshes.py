"""Stored meshes, comparisons by their ids, and what one key sees of another's."""

import hashlib
import json
import threading
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from harness import (RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, ServerCase, comparison, flat_grid, post_head, read_answer, until,
                     wavy_grid)
from keys import TwoKeys, bearer

JSON = "Content-Type: application/json\r\n"


def id_of(data):
    return hashlib.sha256(data).hexdigest()


def path_of(data):
    return "/v1/meshes/" + id_of(data)


def compare(server, a, b, options=None, extra=""):
    """Compares stored meshes by their ids."""
    document = {"a": a, "b": b, **({} if options is None else {"options": options})}
    return server.send("POST", "/v1/comparisons", json.dumps(document).encode(), JSON + extra)

OVERHEAD = 5 << 10  # that a mesh takes beside its bytes


class Store(ServerCase):
    def test_put(self):
        extra = 'Content-Type: model/obj\r\nContent-Disposition: attachment; filename="square one.obj"\r\n'
        answer = self.server.send("PUT", path_of(SQUARE), SQUARE, extra)
        self.assertEqual(answer.status, 201)
        self.assertEqual(answer.headers["location"], path_of(SQUARE))
        mesh = answer.json()
        self.assertEqual((mesh["id"], mesh["bytes"]), (id_of(SQUARE), len(SQUARE)))
        self.assertEqual((mesh["media_type"], mesh["file_name"]), ("model/obj", "square one.obj"))
        self.assertLess(mesh["created"], mesh["expires"])
        again = self.server.send("PUT", path_of(SQUARE), SQUARE, extra)
        self.assertEqual(again.status, 200)
        self.assertEqual(again.json()["created"], mesh["created"])
        self.assertEqual(self.server.get(path_of(SQUARE)).json()["id"], id_of(SQUARE))

    def test_post(self):
        mesh = b"# posted\n" + SQUARE
        first, second = (self.server.send("POST", "/v1/meshes", mesh) for _ in range(2))
        self.assertEqual((first.status, second.status), (201, 200))
        self.assertEqual(first.headers["location"], path_of(mesh))
        self.assertEqual((first.json()["media_type"], first.json()["file_name"]), (None, None))

    def test_head(self):
        mesh = b"# head\n" + SQUARE
        self.assertEqual(self.server.get(path_of(mesh), "HEAD").status, 404)
        self.server.send("POST", "/v1/meshes", mesh)
        answer = self.server.get(path_of(mesh), "HEAD")
        self.assertEqual((answer.status, answer.body), (200, b""))
        self.assertEqual(int(answer.headers["content-length"]), len(self.server.get(path_of(mesh)).body))

    def test_delete(self):
        mesh = b"# deleted\n" + SQUARE
        self.server.send("POST", "/v1/meshes", mesh)
        self.assertEqual(self.server.send("DELETE", path_of(mesh)).status, 204)
        for method in ("GET", "DELETE"):
            self.refused(self.server.send(method, path_of(mesh)), 404, "not-found")
        self.refused(compare(self.server, id_of(mesh), id_of(mesh)), 422, "unknown-mesh")

    def test_another_digest(self):
        other = b"# other\n" + SQUARE
        problem = self.refused(self.server.send("PUT", path_of(other), SQUARE + b"#\n"), 422, "digest-mismatch")
        self.assertIn(id_of(SQUARE + b"#\n"), problem["detail"])
        self.refused(self.server.get(path_of(other)), 404, "not-found")
        self.refused(self.server.get(path_of(SQUARE + b"#\n")), 404, "not-found")

    def test_what_is_no_id(self):
        for name in ("x", id_of(SQUARE).upper(), id_of(SQUARE) + "0", "%61" * 32):
            for method in ("GET", "HEAD", "DELETE", "PUT"):
                answer = self.server.send(method, "/v1/meshes/" + name, SQUARE if method == "PUT" else b"")
                self.assertEqual(answer.status, 400)
        self.refused(self.server.get("/v1/meshes/"), 404, "not-found")

    def test_what_is_no_body(self):
        self.refused(self.server.send("POST", "/v1/meshes", b""), 400, "malformed-request")
        self.refused(self.server.send("PUT", path_of(b""), b""), 400, "malformed-request")
        self.refused(self.server.send("POST", "/v1/meshes?x", SQUARE), 400, "malformed-request")
        self.refused(self.server.get(path_of(SQUARE) + "?x"), 400, "malformed-request")
        self.refused(self.server.raw(b"POST /v1/meshes HTTP/1.1\r\nHost: localhost\r\n\r\n"), 411, "length-required")

    def test_wrong_methods(self):
        for method, path, allowed in (("DELETE", "/v1/meshes", "GET, HEAD, POST"), ("PATCH", path_of(SQUARE), "PUT, GET, HEAD, DELETE"),
                                      ("POST", path_of(SQUARE), "PUT, GET, HEAD, DELETE")):
            answer = self.server.send(method, path)
            self.refused(answer, 405, "method-not-allowed")
            self.assertEqual(answer.headers["allow"], allowed)

    def test_many_at_once_are_one(self):
        mesh = b"# crowd\n" + flat_grid(60)
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(self.server.send("PUT", path_of(mesh), mesh)))
                   for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(answer.status for answer in answers), [200] * 7 + [201])


class ByIds(ServerCase):
    flags = ("--workers", "1")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for mesh in (SQUARE, RAISED):
            cls.server.send("PUT", path_of(mesh), mesh)

    def test_the_same_as_from_files(self):
        by_id = compare(self.server, id_of(SQUARE), id_of(RAISED), {"direction": "a_to_b"})
        self.assertEqual(by_id.status, 200)
        files = self.server.compare(options={"direction": "a_to_b"}).json()
        for member in ("distance", "a_to_b", "status", "tolerance"):
            self.assertEqual(by_id.json()[member], files[member])
        self.assertEqual(by_id.json()["meshes"]["a"]["sha256"], id_of(SQUARE))
        self.assertIn("server-timing", by_id.headers)

    def test_a_warm_baseline_is_neither_read_nor_built_again(self):
        mesh, other = wavy_grid(150, 0.1), wavy_grid(10, 0.1)
        for data in (mesh, other):
            self.server.send("PUT", path_of(data), data)
        first, *later = (compare(self.server, id_of(mesh), id_of(other)).json() for _ in range(6))
        self.assertEqual([one["distance"] for one in later], [first["distance"]] * 5)
        cold = first["timings_ms"]
        warm = {stage: min(one["timings_ms"][stage] for one in later) for stage in cold}  # other work of the machine delays some
        print("first %(read_a).2f + %(build).2f ms," % cold, "then %(read_a).3f + %(build).3f ms" % warm)
        for stage in ("read_a", "build"):
            self.assertGreater(cold[stage], 10 * warm[stage])

    def test_it_may_be_a_job(self):
        answer = compare(self.server, id_of(SQUARE), id_of(RAISED), extra="Prefer: respond-async\r\n")
        self.assertEqual(answer.status, 202)
        until(lambda: self.server.get(answer.headers["location"]).json()["state"] == "done")

    def test_a_job_keeps_what_it_needs(self):
        mesh = b"# kept\n" + SQUARE
        self.server.send("PUT", path_of(mesh), mesh)
        slow = self.server.compare(**SLOW, options={**SLOW_OPTIONS, "timeout_ms": 2000}, extra="Prefer: respond-async\r\n")
        answer = compare(self.server, id_of(mesh), id_of(RAISED), extra="Prefer: respond-async\r\n")
        self.assertEqual(self.server.send("DELETE", path_of(mesh)).status, 204)
        until(lambda: self.server.get(slow.headers["location"]).json()["state"] == "done")
        until(lambda: self.server.get(answer.headers["location"]).json()["state"] == "done")

    def test_the_same_by_files_and_by_ids_has_one_idempotency(self):
        key = "Idempotency-Key: both\r\n"
        first = compare(self.server, id_of(SQUARE), id_of(RAISED), {}, key)
        second = self.server.compare(extra=key)
        self.assertEqual(first.json(), second.json())

    def test_documents_that_are_refused(self):
        good = {"a": id_of(SQUARE), "b": id_of(RAISED)}
        for document, where in (({"a": good["a"]}, "/b"), ({**good, "c": 1}, "/c"), ({**good, "a": 1}, "/a"),
                                ({**good, "a": "x"}, "/a"), ({**good, "a": None}, "/a"), ([good], ""), ("x", ""), (None, ""),
                                ({**good, "options": {"threads": "two"}}, "/threads"),
                                ({**good, "options": {"threads": 1.5}}, "/threads"),
                                ({**good, "options": {"gate": {}}}, "/gate"), ({**good, "options": None}, ""),
                                ({**good, "options": {"tolerance": {}}}, "/tolerance")):
            answer = self.server.send("POST", "/v1/comparisons", json.dumps(document).encode(), JSON)
            problem = self.refused(answer, 422, "invalid-request")
            self.assertEqual(problem["errors"][0]["where"], where, document)
        for text in (b"", b"{", b'{"a": 1, "a": 1}', b"NaN", b"{}\0", b"[" * 10000):
            self.refused(self.server.send("POST", "/v1/comparisons", text, JSON), 422, "invalid-request")
        self.refused(self.server.send("POST", "/v1/comparisons", b" " * 70000 + b"{}", JSON), 413, "too-large")

    def test_media_types(self):
        document = json.dumps({"a": id_of(SQUARE), "b": id_of(RAISED)}).encode()
        for extra in ("", "Content-Type: text/json\r\n", "Content-Type: application/jsonx\r\n", "Content-Type: */*\r\n"):
            self.refused(self.server.send("POST", "/v1/comparisons", document, extra), 415, "unsupported-media-type")
        answer = self.server.send("POST", "/v1/comparisons", document, "Content-Type: Application/JSON; charset=utf-8\r\n")
        self.assertEqual(answer.status, 200)

    def test_what_was_promised_is_found_when_its_meshes_are_gone(self):
        mesh = wavy_grid(12, 0.2)
        document = json.dumps({"a": id_of(mesh), "b": id_of(mesh)}).encode()
        self.server.send("PUT", path_of(mesh), mesh)
        extra = JSON + "Idempotency-Key: gone\r\n"
        first = self.server.send("POST", "/v1/comparisons", document, extra)
        self.server.send("DELETE", path_of(mesh))
        again = self.server.send("POST", "/v1/comparisons", document, extra)
        self.assertEqual((first.status, again.status, again.body), (200, 200, first.body))
        self.refused(self.server.send("POST", "/v1/comparisons", document, JSON), 422, "unknown-mesh")

    def test_unknown_meshes(self):
        problem = self.refused(compare(self.server, id_of(SQUARE), "0" * 64), 422, "unknown-mesh")
        self.assertEqual(problem["errors"][0]["part"], "b")


class Limits(unittest.TestCase):
    def start(self, *flags):
        server = Server(*flags)
        self.addCleanup(server.stop)
        return server

    def test_they_expire(self):
        server = self.start("--mesh-ttl-s", "1")
        server.send("PUT", path_of(SQUARE), SQUARE)
        until(lambda: server.get(path_of(SQUARE)).status == 404, 90)

    def test_there_is_only_so_much_room(self):
        server = self.start("--max-stored-bytes", str(len(SQUARE) + 10 + OVERHEAD))
        self.assertEqual(server.send("PUT", path_of(SQUARE), SQUARE).status, 201)
        for method, path in (("PUT", path_of(RAISED)), ("POST", "/v1/meshes")):
            answer = server.send(method, path, RAISED)
            self.assertEqual((answer.status, answer.json()["type"]), (403, "/problems/quota-exceeded"))
            self.assertNotIn("www-authenticate", answer.headers)
        self.assertEqual(server.send("PUT", path_of(SQUARE), SQUARE).status, 200)  # takes no more
        self.assertEqual(server.send("DELETE", path_of(SQUARE)).status, 204)
        self.assertEqual(server.send("POST", "/v1/meshes", RAISED).status, 201)

    def test_there_are_only_so_many(self):
        server = self.start("--max-stored-meshes", "1")
        self.assertEqual(server.send("PUT", path_of(SQUARE), SQUARE).status, 201)
        answer = server.send("PUT", path_of(RAISED), RAISED)
        self.assertEqual((answer.status, answer.json()["type"]), (403, "/problems/quota-exceeded"))
        self.assertIn("limit of 1", answer.json()["detail"])
        self.assertEqual(server.send("PUT", path_of(SQUARE), SQUARE).status, 200)
        self.assertEqual(server.send("DELETE", path_of(SQUARE)).status, 204)
        self.assertEqual(server.send("PUT", path_of(RAISED), RAISED).status, 201)

    def test_small_ones_count_as_what_they_take_on_the_disk(self):
        server = self.start("--max-stored-bytes", "100000")
        stored = [server.send("POST", "/v1/meshes", b"# %d\n" % i).status for i in range(30)]
        self.assertEqual(stored.count(201), 100000 // OVERHEAD)
        self.assertEqual(stored.count(403), 30 - 100000 // OVERHEAD)

    def test_many_at_once_take_no_more_storage_than_there_is(self):
        """Comparisons and meshes, of which the storage holds one at a time: nothing ends meanwhile."""
        most = 2_000_000
        server = self.start("--max-stored-bytes", str(most))
        body = [b"# %d\n" % i + SLOW["a"] + b"#" * (1_900_000 - len(SLOW["a"])) + b"\n" for i in range(12)]
        folder = Path(server.data_dir.name, "data", "blobs")

        def compares(mesh, start):
            """Sends all but the last byte before the start, so that the requests compete."""
            sent = comparison(mesh, SQUARE, SLOW_OPTIONS)
            with server.connect() as connection:
                connection.sendall(post_head(len(sent), "Prefer: respond-async\r\n") + sent[:-1])
                start.wait()
                connection.sendall(sent[-1:])
                return read_answer(connection.makefile("rb"))

        def stores(mesh, start):
            start.wait()
            return server.send("POST", "/v1/meshes", mesh)

        for sends in (compares, compares, compares, stores):
            start = threading.Barrier(len(body))
            with ThreadPoolExecutor(len(body)) as senders:
                answers = list(senders.map(lambda mesh, sends=sends, start=start: sends(mesh, start), body))
            taken = [answer for answer in answers if answer.status in (201, 202)]
            refused = [answer for answer in answers if answer.status == 403]
            self.assertEqual((len(taken), len(refused)), (1, len(body) - 1), [answer.status for answer in answers])
            self.assertEqual({answer.json()["type"] for answer in refused}, {"/problems/quota-exceeded"})
            self.assertLessEqual(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()), most)
            server.send("DELETE", taken[0].headers["location"])
            until(lambda: not any(path.is_file() for path in folder.rglob("*")))

    def test_what_is_deleted_takes_no_room(self):
        server = self.start("--max-stored-bytes", "1000000")
        folder = Path(server.data_dir.name, "data", "blobs")
        for i in range(20):
            mesh = flat_grid(30) + b"# %d" % i
            self.assertEqual(server.send("PUT", path_of(mesh), mesh).status, 201)
            self.assertEqual(server.send("DELETE", path_of(mesh)).status, 204)
        self.assertEqual([path for path in folder.rglob("*") if path.is_file()], [])

    def test_one_is_only_so_large(self):
        server = self.start("--max-part-bytes", "50", "--max-request-bytes", "100")
        for size in (51, 101):
            self.assertEqual(server.send("POST", "/v1/meshes", b"#" * size).status, 413)


class Owners(TwoKeys):
    def test_meshes(self):
        self.assertEqual(self.send(self.mine, "PUT", path_of(SQUARE), SQUARE).status, 201)
        missing = self.send(self.theirs, "GET", "/v1/meshes/" + "0" * 64)
        for method in ("GET", "DELETE"):
            answer = self.send(self.theirs, method, path_of(SQUARE))
            self.assertEqual((answer.status, answer.body), (404, missing.body))
        self.assertEqual(self.send(self.theirs, "HEAD", path_of(SQUARE)).status, 404)
        document = json.dumps({"a": id_of(SQUARE), "b": id_of(SQUARE)}).encode()
        self.assertEqual(self.send(self.theirs, "POST", "/v1/comparisons", document, JSON).status, 422)
        self.assertEqual(self.send(self.theirs, "PUT", path_of(SQUARE), SQUARE).status, 201)  # new to this key
        self.assertEqual(self.send(self.theirs, "DELETE", path_of(SQUARE)).status, 204)
        self.assertEqual(self.send(self.mine, "GET", path_of(SQUARE)).status, 200)

    def test_comparisons(self):
        extra = "Prefer: wait=60\r\nIdempotency-Key: k\r\n"
        mine = self.server.compare(extra=extra + bearer(self.mine)).headers["location"]
        missing = self.send(self.theirs, "GET", "/v1/comparisons/" + "0" * 32)
        for method, path in (("GET", mine), ("DELETE", mine), ("GET", mine + "/events")):
            answer = self.send(self.theirs, method, path)
            self.assertEqual((answer.status, answer.body), (404, missing.body))
        theirs = self.server.compare(extra=extra + bearer(self.theirs)).headers["location"]
        self.assertNotEqual(mine, theirs)
        self.assertEqual(self.send(self.mine, "GET", mine).status, 200)

    def test_quota(self):
        large = flat_grid(200)
        self.assertEqual(self.send(self.mine, "POST", "/v1/meshes", large).status, 403)
        self.assertEqual(self.send(self.theirs, "POST", "/v1/meshes", large).status, 201)

    def test_a_repetition_is_no_further_job(self):
        extra = "Prefer: respond-async\r\nIdempotency-Key: once\r\n" + bearer(self.mine)
        answers = [self.server.compare(**SLOW, options=SLOW_OPTIONS, extra=extra) for _ in range(2)]
        self.assertEqual([answer.status for answer in answers], [202, 202])
        self.assertEqual(answers[0].headers["location"], answers[1].headers["location"])
        self.send(self.mine, "DELETE", answers[0].headers["location"])

    def test_jobs_at_a_time(self):
        slow = self.server.compare(**SLOW, options=SLOW_OPTIONS, extra="Prefer: respond-async\r\n" + bearer(self.mine))
        self.assertEqual(slow.status, 202)
        self.assertEqual(self.server.compare(extra=bearer(self.mine)).status, 429)
        self.assertEqual(self.server.compare(extra=bearer(self.theirs)).status, 200)
        self.send(self.mine, "DELETE", slow.headers["location"])
        until(lambda: self.server.compare(extra=bearer(self.mine)).status == 200)


if __name__ == "__main__":
    unittest.main()
