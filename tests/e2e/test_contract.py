"""openapi.yaml itself, the judge made from it, and every operation under the refusals that any request can get."""

import contextlib
import copy
import errno
import hashlib
import json
import mmap
import os
import select
import signal
import struct
import tempfile
import unittest
from pathlib import Path

import yaml

import contract
from contract import OPENAPI, OPERATIONS, ROOT, PROBLEMS, Violation, hold, resolved
from harness import (RAISED, SQUARE, Answer, Server, ServerCase, comparison, flat_grid, multipart, post_head, read_answer,
                     until)
from keys import bearer, new_key, write_keys
from wire import Request

ID, MESH_ID = "0" * 32, "0" * 64
AS_JSON = "Content-Type: application/json\r\n"
FAILING_DISK = os.environ.get("MESHGAUGE_FAILING_DISK_LIBRARY", "")


def nodes(node, path=()):
    """Each mapping of the document, with the way to it."""
    if isinstance(node, dict):
        yield path, node
    for name, child in (node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()):
        yield from nodes(child, (*path, name))


def with_examples():
    """Each node that has examples and a schema, and these examples."""
    for path, node in nodes(OPENAPI):
        if "schema" in node:
            values = [resolved(example)["value"] for example in node.get("examples", {}).values()]
            yield path, node["schema"], values + ([node["example"]] if "example" in node else [])
        elif path[:2] == ("components", "schemas") and "example" in node:
            yield path, node, [node["example"]]


class Description(unittest.TestCase):
    def test_examples_are_what_they_are_examples_of(self):
        count = 0
        for path, schema, values in with_examples():
            for value in values:
                hold(value, schema, "/".join(map(str, path)))
                count += 1
        self.assertGreater(count, 60)

    def test_all_that_is_described_has_an_example(self):
        lacking = [path for path, node in nodes(OPENAPI["paths"])
                   if path[-1:] == ("application/json",) and "responses" in path and "example" not in node
                   and path[1] != "head"]
        self.assertEqual(lacking, [])

    def test_nothing_is_without_use(self):
        used = {node["$ref"] for _, node in nodes(OPENAPI) if "$ref" in node}
        there = {"#/components/%s/%s" % (kind, name) for kind, all_of in OPENAPI["components"].items()
                 for name in all_of if kind != "securitySchemes"}
        self.assertEqual(there - used, set())

    def test_requests_are_strict_and_answers_may_grow(self):
        """contract.py itself closes what this service answers."""
        described = yaml.safe_load((ROOT / "openapi.yaml").read_text())
        of_requests, todo = set(), [node for path, node in nodes(described["paths"]) if path[-1:] in (("requestBody",), ("parameters",))]
        while todo:
            for _, node in nodes(todo.pop()):
                name = node.get("$ref", "").removeprefix("#/components/schemas/")
                if name in described["components"]["schemas"] and name not in of_requests:
                    of_requests.add(name)
                    todo.append(described["components"]["schemas"][name])
        for name, schema in described["components"]["schemas"].items():
            closed = [node.get("additionalProperties") is False for _, node in nodes(schema) if "properties" in node and "type" in node]
            self.assertEqual(set(closed), ({True} if name in of_requests else {False}) if closed else set(), name)

    def test_each_problem_is_an_example_of_some_response_of_its_status(self):
        table = {row["properties"]["type"]["const"].removeprefix(PROBLEMS): row["properties"]["status"]["const"]
                 for row in OPENAPI["components"]["schemas"]["Problem"]["oneOf"]}
        self.assertEqual(set(table), set(OPENAPI["components"]["examples"]))
        told = set()
        for responses in [operation.responses for operation in OPERATIONS] + [contract.ANY_REQUEST, contract.BY_STATUS]:
            for status, response in responses.items():
                if status == "default":
                    continue
                problems = resolved(response).get("content", {}).get("application/problem+json", {}).get("examples", {})
                self.assertEqual({table[slug] for slug in problems} - {int(status)}, set())
                told |= set(problems)
        self.assertEqual(told, set(table))


class Judge(unittest.TestCase):
    """What must not pass does not."""

    def setUp(self):
        self.request = Request("GET", "/v1/meshes/" + MESH_ID, "", {}, b"")
        stored = resolved(OPENAPI["paths"]["/v1/meshes"]["post"]["responses"]["200"])
        mesh = stored["content"]["application/json"]["example"]
        self.answer = Answer(200, {"content-type": "application/json", "content-length": "9", "x-request-id": ID,
                                   "traceparent": "00-%s-%s-00" % (ID, "1" * 16), "x-content-type-options": "nosniff",
                                   "referrer-policy": "no-referrer", "cache-control": "no-store"}, json.dumps(mesh).encode())
        self.seen = copy.deepcopy(contract.SEEN)
        self.addCleanup(lambda: setattr(contract, "SEEN", self.seen))

    def changed(self, **members):
        self.answer.body = json.dumps({**json.loads(self.answer.body), **members}).encode()

    def refuse(self, saying):
        with self.assertRaisesRegex(Violation, saying):
            contract.check(self.request, self.answer)

    def test_what_is_as_described_passes(self):
        contract.check(self.request, self.answer)

    def test_a_status(self):
        self.answer.status = 206
        self.refuse("is not declared")

    def test_headers(self):
        self.answer.headers["x-more"] = "1"
        self.refuse("undeclared header: x-more")
        del self.answer.headers["x-more"], self.answer.headers["traceparent"]
        self.refuse("has no header traceparent")
        self.answer.headers["traceparent"] = "x"
        self.refuse("header traceparent is not as its schema says")

    def test_members(self):
        self.changed(more=1)
        self.refuse("more")

    def test_types_and_repeats(self):
        self.changed(bytes="12")
        self.refuse("bytes")
        self.answer.body = self.answer.body.replace(b'"bytes"', b'"id": 1, "bytes"')
        with self.assertRaises(ValueError):
            contract.check(self.request, self.answer)

    def test_a_media_type(self):
        self.answer.headers["content-type"] = "text/html"
        self.refuse("text/html")

    def test_a_problem_of_another_operation(self):
        self.answer.status = 404
        self.answer.headers["content-type"] = "application/problem+json"
        self.answer.body = json.dumps(OPENAPI["components"]["examples"]["method-not-allowed"]["value"]).encode()
        self.refuse("method-not-allowed|405")

    def test_a_request_that_should_have_been_refused(self):
        self.request.query = "x=1"
        self.refuse("accepted what the description does not allow: a query")

    def test_a_request_that_should_have_been_accepted(self):
        body = comparison()
        request = Request("POST", "/v1/comparisons", "", {"content-type": "multipart/form-data; boundary=XXboundaryXX"}, body)
        problem = OPENAPI["components"]["examples"]["invalid-request"]["value"]
        self.answer = Answer(422, {**self.answer.headers, "content-type": "application/problem+json"}, json.dumps(problem).encode())
        with self.assertRaisesRegex(Violation, "refused what the description allows"):
            contract.check(request, self.answer)
        request.body = comparison(options=b'{"x": 1}')
        contract.check(request, self.answer)


def line_of(operation, version="HTTP/1.1", query=""):
    path = operation.path.replace("{file}", "docs.js").replace("{id}", MESH_ID if "meshes" in operation.path else ID)
    path = path.replace("{kind}", "not-found")
    return "%s %s%s %s\r\n" % (operation.method, path, query, version)


def ask(server, operation, extra="", **line):
    """A request with no body, or an empty one."""
    length = "Content-Length: 0\r\n" if operation.method in ("POST", "PUT") and "Content-Length" not in extra else ""
    return server.raw((line_of(operation, **line) + "Host: localhost\r\n" + length + extra + "\r\n").encode())


class EveryOperation(ServerCase):
    flags = ("--head-timeout-ms", "1000")

    def every(self, status, extra="", **line):
        for operation in OPERATIONS:
            self.assertEqual(ask(self.server, operation, extra, **line).status, status, operation.id)

    def test_no_http(self):
        self.every(400, "Bad Header: x\r\n")

    def test_too_large_a_body(self):
        self.every(413, "Content-Length: 1%s\r\n" % ("0" * 30))

    def test_too_long_a_target(self):
        self.every(414, query="?" + "x" * 2100)

    def test_a_content_coding(self):
        self.every(415, "Content-Encoding: gzip\r\n")

    def test_too_large_a_head(self):
        self.every(431, "X: %s\r\n" % ("x" * 20000))

    def test_a_transfer_coding(self):
        for operation in OPERATIONS:
            head = line_of(operation) + "Host: localhost\r\nTransfer-Encoding: gzip\r\n\r\n"
            self.assertEqual(self.server.raw(head.encode()).status, 501, operation.id)

    def test_another_version(self):
        self.every(505, version="HTTP/3")

    def test_no_length(self):
        for operation in OPERATIONS:
            if operation.body:
                answer = self.server.raw((line_of(operation) + "Host: localhost\r\n\r\n").encode())
                self.refused(answer, 411, "length-required")

    def test_a_head_that_does_not_come(self):
        with contextlib.ExitStack() as stack:
            streams = []
            for operation in OPERATIONS:
                connection = stack.enter_context(self.server.connect())
                connection.sendall((line_of(operation) + "Host: localhost\r\n").encode())
                streams.append(connection.makefile("rb"))
            for stream in streams:
                self.assertEqual(read_answer(stream).status, 408)

    def test_what_is_no_operation(self):
        for extra, status in (("Bad Header: x\r\n", 400), ("Content-Length: 1%s\r\n" % ("0" * 30), 413),
                              ("Content-Encoding: gzip\r\n", 415), ("X: %s\r\n" % ("x" * 20000), 431),
                              ("Transfer-Encoding: gzip\r\n", 501), ("", 404)):
            self.assertEqual(self.server.get("/none", extra=extra).status, status)
        self.assertEqual(self.server.get("/none" + "x" * 2100).status, 414)
        self.assertEqual(self.server.raw(b"GET /none HTTP/3\r\n\r\n").status, 505)
        self.assertEqual(self.server.raw(b"POST /none HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 411)
        self.assertEqual(self.server.raw(b"GET /none HTTP/1.1\r\n").status, 408)


class Crowded(unittest.TestCase):
    def start(self, *flags):
        server = Server("--workers", "1", "--queue", "0", "--max-event-streams", "0", "--head-timeout-ms", "60000", *flags)
        self.addCleanup(server.stop)
        return server

    def hold(self, server):
        """One more connection whose request does not arrive."""
        connection = server.connect()
        self.addCleanup(connection.close)
        connection.sendall(b"GET / HTTP/1.1\r\n")
        return connection

    def test_too_many_of_one_address(self):
        server = self.start("--io-threads", "8", "--max-arriving-per-peer", "1")
        select.select([self.hold(server), self.hold(server)], [], [], 60)  # either is answered, the other one is in its way
        for line in [line_of(operation) for operation in OPERATIONS] + ["GET /none HTTP/1.1\r\n"]:
            self.assertEqual(server.raw(line.encode()).status, 429)

    def test_all_threads_in_use(self):
        server = self.start("--io-threads", "1", "--max-pending-connections", "0")
        for operation in OPERATIONS:
            until(lambda: 503 in self.burst(server, operation))

    def burst(self, server, operation):
        """The statuses of requests that arrive at the same moment: more of them than threads."""
        with contextlib.ExitStack() as stack:
            connections = [stack.enter_context(server.connect()) for _ in range(20)]
            server.process.send_signal(signal.SIGSTOP)
            for connection in connections:
                connection.sendall((line_of(operation) + "Host: localhost\r\nContent-Length: 0\r\n\r\n").encode())
            server.process.send_signal(signal.SIGCONT)
            return {read_answer(connection.makefile("rb")).status for connection in connections}


class Keys(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.comparing, first = new_key("comparing", requests_per_minute=1, burst=1)
        self.measuring, second = new_key("measuring", "--scope", "metrics", requests_per_minute=6000, burst=1000)
        third = new_key("more", requests_per_minute=6000, burst=1000)
        self.more = third[0]
        write_keys(Path(folder.name) / "keys.json", first, second, third[1])
        self.server = Server("--keys-file", folder.name + "/keys.json")
        self.addCleanup(self.server.stop)

    def test_every_operation(self):
        ask(self.server, contract.operation_of("GET", "/v1/meshes/" + MESH_ID), bearer(self.comparing))
        for operation in OPERATIONS:
            if operation.open:
                self.assertNotEqual(ask(self.server, operation).status, 401, operation.id)
                continue
            self.assertEqual(ask(self.server, operation).status, 401, operation.id)
            other = self.more if operation.path == "/metrics" else self.measuring
            self.assertEqual(ask(self.server, operation, bearer(other)).status, 403, operation.id)
            self.assertEqual(ask(self.server, operation, bearer(self.comparing)).status, 429, operation.id)

    def test_what_is_no_operation(self):
        for token, status in ((None, 401), (self.measuring, 403), (self.comparing, 404), (self.comparing, 429)):
            answer = self.server.get("/none", extra=bearer(token) if token else "")
            self.assertEqual(answer.status, status)


@unittest.skipUnless(FAILING_DISK and not os.environ.get("MESHGAUGE_SANITIZED"), "a sanitizer comes before every other library")
class Stores(unittest.TestCase):
    """The answers when nothing can be stored. tests/chaos/test_disk.py has what the service does then."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        orders, disk = Path(folder.name) / "orders", Path(folder.name) / "disk"
        orders.write_bytes(bytes(8))
        disk.mkdir()
        with open(orders, "r+b") as file:
            self.orders = mmap.mmap(file.fileno(), 8)
        self.addCleanup(self.orders.close)
        self.server = Server("--data-dir", str(disk / "data"), environment={
            "LD_PRELOAD": FAILING_DISK, "MESHGAUGE_FAILING_DISK": "%s:%s" % (disk, orders)})
        self.addCleanup(self.server.stop)

    def requests(self):
        mesh = self.server.send("POST", "/v1/meshes", SQUARE).headers["location"]
        job = self.server.compare(extra="Prefer: wait=60\r\n").headers["location"]
        form = multipart([("a", SQUARE), ("b", RAISED)])
        baseline = self.server.send("POST", "/v1/meshes", flat_grid(2)).json()["id"]
        pair = json.dumps({"comparisons": [{"a": baseline, "b": baseline}]}).encode()
        batch = self.server.send("POST", "/v1/batches", pair, AS_JSON).headers["location"]
        until(lambda: self.server.get(batch).json()["state"] == "done")
        return [b"POST /v1/batches HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n%s\r\n" % (len(pair), AS_JSON.encode()) + pair,
                ("DELETE %s HTTP/1.1\r\nHost: localhost\r\n\r\n" % batch).encode(),
                post_head(len(form), "Prefer: respond-async\r\n") + form,
                *(("%s %s HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n" % (method, path, len(body))).encode() + body
                  for method, path, body in (("DELETE", job, b""), ("DELETE", mesh, b""), ("POST", "/v1/meshes", RAISED),
                                             ("PUT", "/v1/meshes/" + hashlib.sha256(RAISED).hexdigest(), RAISED)))]

    def break_disk(self, number):
        self.orders[:] = struct.pack("ii", self.server.process.pid, number)

    def test_a_full_and_a_broken_disk(self):
        requests = self.requests()
        for number, status, slug in ((errno.ENOSPC, 507, "storage-full"), (errno.EIO, 503, "storage-unavailable")):
            self.break_disk(number)
            for request in requests:
                answer = self.server.raw(request)
                self.assertEqual((answer.status, answer.json()["type"]), (status, PROBLEMS + slug), request[:60])
            until(lambda: self.server.get("/readyz").status == 503)
        self.break_disk(0)
        until(lambda: self.server.get("/readyz").status == 200)


if __name__ == "__main__":
    unittest.main()
