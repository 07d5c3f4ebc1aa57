"""Requests that the service refuses: each gives a row (what was sent, the answer)."""

import hashlib
import json
import pathlib
import tempfile

from harness import RAISED, SLOW, SLOW_OPTIONS, SQUARE, Server, comparison, holding_the_worker, multipart, post_head, until
from keys import bearer, new_key, write_keys

NO_ID = "0" * 32
AS_JSON = "Content-Type: application/json\r\n"
ASYNC = "Prefer: respond-async\r\n"
# Small enough to be passed by small requests; nothing depends on the machine.
FLAGS = ("--workers", "1", "--max-part-bytes", "20000", "--max-request-bytes", "90000", "--max-triangles", "1000",
         "--max-vertices", "1000", "--max-expanded-bytes", "30000", "--head-timeout-ms", "1000", "--body-timeout-ms", "1000",
         "--max-batch-pairs", "3", "--max-event-streams", "0", "--max-stored-bytes", "20000")


def id_of(mesh):
    return hashlib.sha256(mesh).hexdigest()


def form(server, *parts, extra=""):
    body = multipart(parts)
    return server.raw(post_head(len(body), extra) + body)


def row_major(numbers):
    return {"row_major": numbers}


def options(server, value):
    return server.compare(options=json.dumps(value).encode() if not isinstance(value, bytes) else value)


def to_batches(server, parts):
    body = multipart(parts)
    return server.raw(post_head(len(body)).replace(b"/v1/comparisons", b"/v1/batches") + body)


def head_rows(server):
    get = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
    return [(what, server.raw(data)) for what, data in [
        ("what is not HTTP", b"SSH-2.0-OpenSSH_9.2\r\n\r\n"),
        ("TLS on a port without TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"),
        ("lines that end with LF alone", b"GET / HTTP/1.1\nHost: x\n\n"),
        ("no Host", b"GET / HTTP/1.1\r\n\r\n"),
        ("Host twice", get + b"Host: y\r\n\r\n"),
        ("a Host that is none", b"GET /healthz HTTP/1.1\r\nHost: localhost:x\r\n\r\n"),
        ("a target without its slash", b"GET healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        ("a character that a target cannot have", b"GET /v1/{id} HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        ("another method than OPTIONS of '*'", b"GET * HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        ("a blank in the name of a header", get + b"Bad Name: y\r\n\r\n"),
        ("a blank before the colon", get + b"Name : y\r\n\r\n"),
        ("a folded header", get + b"X: a\r\n folded\r\n\r\n"),
        ("a control character in a header", get + b"X: a\x00b\r\n\r\n"),
        ("an unknown expectation", get + b"Expect: 200-ok\r\n\r\n"),
        ("HTTP/3", b"GET / HTTP/3\r\n\r\n"),
        ("an unknown method", b"FOO / HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        ("a target of 8,000 bytes", b"GET /" + b"a" * 8000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        ("a header of 20,000 bytes", get + b"X: " + b"b" * 20000 + b"\r\n\r\n"),
        ("a head that does not end in time", get),
        ("no length of the body", b"POST /v1/comparisons HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        ("another host, without keys", b"GET /v1/comparisons/%s HTTP/1.1\r\nHost: attacker.example\r\n\r\n" % NO_ID.encode()),
        ("a page of another site, without keys", post_head(5, "Origin: https://attacker.example\r\n")),
        ("two lengths", post_head(5, "Content-Length: 5\r\n")),
        ("a length that is no number", post_head(-1)),
        ("an unknown transfer coding", post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding: gzip, chunked")),
        ("a compressed body", post_head(5, "Content-Encoding: gzip\r\n")),
        ("another type of body", post_head(5).replace(b"multipart/form-data", b"text/plain")),
        ("`curl -d '{}'`", post_head(2).replace(b"multipart/form-data; boundary=XXboundaryXX", b"application/x-www-form-urlencoded") + b"{}"),
        ("no type of body", post_head(5).replace(b"Content-Type: multipart/form-data; boundary=XXboundaryXX\r\n", b"")),
        ("no boundary", post_head(5).replace(b"; boundary=XXboundaryXX", b"")),
        ("a boundary with blanks, without quotes", post_head(5).replace(b"XXboundaryXX", b"XX boundary")),
        ("a boundary that is too long", post_head(5).replace(b"XXboundaryXX", b"X" * 71)),
        ("a body larger than the limit", post_head(90001)),
        ("a body that does not arrive in time", post_head(100) + b"--XXboundaryXX\r\n"),
        ("a chunk without a size", post_head(0).replace(b"Content-Length: 0", b"Transfer-Encoding: chunked") + b"x\r\n"),
    ]]


def path_rows(server):
    path = "/v1/comparisons/" + NO_ID
    return [
        ("a path that does not exist", server.get("/v1/meshs")),
        ("a method that the path does not take", server.send("DELETE", "/healthz")),
        ("an unknown query", server.get(path + "?x=1")),
        ("a comparison that is not known", server.get(path)),
        ("its events", server.get(path + "/events")),
        ("its deviation map", server.get(path + "/deviation.ply")),
        ("a batch that is not known", server.get("/v1/batches/" + NO_ID)),
        ("a mesh that is not stored", server.get("/v1/meshes/" + "0" * 64)),
        ("a mesh by a name that is no SHA-256", server.get("/v1/meshes/part")),
    ]


def form_rows(server):
    mesh = ("a", SQUARE), ("b", RAISED), ("options", b"{}")
    unnamed = comparison().replace(b'; name="a"', b"")
    long_head = comparison().replace(b'filename="a.obj"', b'filename="' + b"x" * 9000 + b'"')
    bodies = [
        ("a body that ends within a part", comparison()[:120]),
        ("a body without the boundary", b"{}"),
        ("more than 8 KiB before the first boundary", b"x" * 9000 + b"\r\n" + comparison()),
        ("a byte order mark before the first boundary", b"\xef\xbb\xbf" + comparison()),
        ("a part after the closing boundary", multipart([("a", SQUARE)]) + multipart([("b", RAISED)])),
        ("lines that end with LF alone", comparison().replace(b"\r\n", b"\n")),
    ]
    text = comparison().replace(b'; filename="a.obj"', b"").replace(SQUARE, b"part.obj")
    return [
        ("no part `b`", form(server, mesh[0])),
        ("a part twice", form(server, *mesh, mesh[0])),
        ("an unknown part", form(server, *mesh, ("c", b""))),
        ("parts of other names", form(server, ("file1", SQUARE), ("file2", RAISED))),
        ("`curl -F a=part.obj`, without `@`", server.raw(post_head(len(text)) + text)),
        ("a part without a name", server.raw(post_head(len(unnamed)) + unnamed)),
        ("a part whose head is too long", server.raw(post_head(len(long_head)) + long_head)),
        *((what, server.raw(post_head(len(body)) + body)) for what, body in bodies),
        ("a part larger than the limit", form(server, ("a", bytes(20001)), mesh[1])),
        ("more triangles than the limit", form(server, ("a", SQUARE + b"f 1 2 3\n" * 1000), mesh[1])),
        ("more vertices than the limit", form(server, ("a", b"v 0 0 0\n" * 1001 + SQUARE), mesh[1])),
        ("options larger than the limit", form(server, *mesh[:2], ("options", b" " * 70000))),
        ("no mesh file in a part", form(server, ("a", b""), mesh[1])),
        ("two contradicting units", options(server, {"units": {"a": "mm", "b": "in"}, "gate": {"max_distance": 1}})),
        ("a limit in a unit, meshes of unknown unit", options(server, {"gate": {"max_distance": 1, "units": "mm"}, "units": {"a": "mm"}})),
    ]


def option_rows(server):
    values = [
        b"{", b'{"threads": 1, "threads": 2}', b"[]", {"thread": 2}, {"direction": "both"}, {"strategy": "fast"},
        {"strategy": "auto", "points": 4}, {"strategy": "n_point", "points": 5},
        {"tolerance": {}}, {"tolerance": {"absolute": -1}}, {"tolerance": {"relative": "1 %"}}, {"gate": {}},
        {"gate": {"zone": 1}}, {"gate": {"zone": [0.1, 0.2]}}, {"gate": {"zone": [-1, 1]}, "direction": "b_to_a"},
        {"gate": {"max_share_beyond": {"distance": 1}}}, {"gate": {"max_share_beyond": {"distance": 1, "share": 120}}},
        {"gate": {"max_distance": 1, "uncertainty": 2}},
        {"regions": [{"name": "bore"}]}, {"regions": [{"name": "bore", "box": {"min": [0, 0, 1], "max": [1, 1, 0]}}]},
        {"regions": [{"name": "tip", "sphere": {"centre": [0, 0, 0], "radius": 1}, "max_distance": 1}]},
        {"regions": [{"name": "lid", "group": ""}]}, {"regions": [{"name": "lid", "group": "Lid"}]},
        {"regions": [{"name": "lid", "group": "Lid"}], "direction": "a_to_b"},
        {"regions": [{"name": "far", "sphere": {"centre": [90, 0, 0], "radius": 1}}]},
        {"align": "stiff"}, {"align": {"overlap": 2}}, {"align": {"overlapp": 1}}, {"align": {"fit": False}},
        *({"align": {"transform": transform}} for transform in ([1, 0, 0], {"row_major": [1, 0, 0]}, *map(row_major, (
            [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1], [1.1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
            [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1])))),
        {"expect": {}}, {"expect": {"watertight": 1}}, {"expect": {"water": True}}, {"expect": {"triangles": {}}}, {"expect": {"components": 1.5}},
        {"expect": {"triangles": {"min": 2, "max": 1}}}, {"expect": {"volume": 5}}, {"expect": {"volume": {"within": "1 mm"}}},
        {"gate": {"max_distance": -1}}, {"gate": {"max_distance": 1, "units": "parsec"}}, {"timeout_ms": 0}, {"timeout_ms": 1e9}, {"threads": 1.5},
        {"budget": {"work_items": 0}}, {"units": {"a": "pt"}}, {"statistics": 1}, {"statistics": {"samples": 10}}, {"simd": "mmx"}, {"shards": 2},
    ]
    return [("`" + (value.decode() if isinstance(value, bytes) else json.dumps(value)) + "`", options(server, value)) for value in values]


def job_rows(server):
    stored = {"a": id_of(SQUARE), "b": id_of(RAISED)}

    def post(document, extra=AS_JSON):
        return server.send("POST", "/v1/comparisons", document if isinstance(document, bytes) else json.dumps(document).encode(), extra)

    rows = [
        ("a pair of meshes that are not stored", post(stored)),
        ("a pair without `b`", post({"a": stored["a"]})),
        ("files named in a JSON body", post({"a": "part.stl", "b": "baseline.stl"})),
        ("a pair with an unknown member", post({**stored, "c": 1})),
        ("a pair with an id that is none", post({**stored, "a": "part"})),
        ("a document that is not JSON", post(b"{")),
        ("a document of another media type", post(stored, "Content-Type: text/json\r\n")),
        ("an empty mesh to be stored", server.send("POST", "/v1/meshes", b"")),
        ("bytes that have another SHA-256 than their path", server.send("PUT", "/v1/meshes/" + stored["a"], RAISED)),
        ("an Idempotency-Key of two words", server.compare(extra="Idempotency-Key: two words\r\n")),
        ("an Idempotency-Key for another request", (server.compare(extra="Idempotency-Key: one\r\n"),
                                                    server.compare(a=RAISED, extra="Idempotency-Key: one\r\n"))[1]),
    ]
    done = "/v1/comparisons/" + server.compare().headers["x-request-id"]
    failed = "/v1/comparisons/" + server.compare(a=b"v 0 0 nan\n").headers["x-request-id"]
    ended = server.compare(extra=ASYNC).headers["location"]
    until(lambda: server.get(ended).json()["finished"])
    until(lambda: server.get(done + "/deviation.ply", method="HEAD").status == 410)  # durable ones let go of the meshes last
    rows += [
        ("a map with an unknown query", server.get(done + "/deviation.ply?x=1")),
        ("a map of a third mesh", server.get(done + "/deviation.ply?of=c")),
        ("a map with a number of triangles that is none", server.get(done + "/deviation.glb?max_triangles=few")),
        ("a .ply of fewer triangles", server.get(done + "/deviation.ply?max_triangles=5")),
        ("a map of a comparison without an interval", server.get(failed + "/deviation.ply")),
        ("a map whose mesh is not stored", server.get(done + "/deviation.ply")),
        ("events, when no stream is allowed", server.get(ended + "/events")),
        ("events over HTTP/1.0", server.raw(b"GET %s/events HTTP/1.0\r\n\r\n" % ended.encode())),
    ]
    return rows


def batch_rows(server):
    flat, other = (server.send("POST", "/v1/meshes", mesh).json()["id"] for mesh in (SQUARE, RAISED))
    good = {"a": flat, "b": other}

    def post(document, extra=AS_JSON):
        return server.send("POST", "/v1/batches", document if isinstance(document, bytes) else json.dumps(document).encode(), extra)

    manifest = ("manifest", json.dumps({"comparisons": [{"a": {"part": "x"}, "b": flat}]}).encode())
    rows = [
        ("a manifest that is not JSON", post(b"{")),
        ("a manifest without pairs", post({"comparisons": []})),
        ("an unknown member", post({"comparisons": [good], "gates": []})),
        ("a name of two lines", post({"comparisons": [good], "name": "a\nb"})),
        ("an unknown option of all pairs", post({"comparisons": [good], "options": {"tolerence": 1}})),
        ("a wrong option of one pair", post({"comparisons": [good, {**good, "options": {"threads": 0}}]})),
        ("a pair that is none", post({"comparisons": [7]})),
        ("a pair without `b`", post({"comparisons": [{"a": flat}]})),
        ("a part, but no form", post({"comparisons": [{**good, "a": {"part": "x"}}]})),
        ("more pairs than the limit", post({"comparisons": [good] * 4})),
        ("meshes that are not stored", post({"comparisons": [{"a": "1" * 64, "b": flat}]})),
        ("another media type", post(b"{}", "Content-Type: text/plain\r\n")),
        ("a form that does not begin with its manifest", to_batches(server, [("x", SQUARE), manifest])),
        ("a form without the file that a pair names", to_batches(server, [manifest])),
        ("a form with a file that no pair names", to_batches(server, [manifest, ("x", SQUARE), ("y", SQUARE)])),
        ("a form with a file twice", to_batches(server, [manifest, ("x", SQUARE), ("x", SQUARE)])),
        ("a file larger than the limit", to_batches(server, [manifest, ("x", bytes(20001))])),
    ]
    return rows


def stored_rows(server):
    """Stores meshes up to the key's limit."""
    rows = []
    for n in range(20):
        answer = server.send("POST", "/v1/meshes", SQUARE + b"# %d\n" % n + b"#" * 100)
        if answer.status == 403:
            rows.append(("a mesh beyond the storage of the key", answer))
            break
    return rows


def busy_rows():
    """A service with one worker and no queue, while a comparison runs."""
    server = Server("--workers", "1", "--queue", "0", "--max-event-streams", "1", "--max-queued-jobs", "1")
    try:
        slow = server.compare(**SLOW, options=SLOW_OPTIONS, extra=ASYNC).headers["location"]
        rows = [
            ("one asynchronous comparison too many", server.compare(extra=ASYNC)),
            ("a map of a comparison that runs", server.get(slow + "/deviation.ply")),
        ]
        with server.connect() as first:
            first.sendall(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % slow.encode())
            until(lambda: first.recv(1))
            rows.append(("one stream of events too many", server.get(slow + "/events")))
        server.send("DELETE", slow)
        batch = {"comparisons": [{part: server.send("POST", "/v1/meshes", mesh).json()["id"] for part, mesh in SLOW.items()}], "options": SLOW_OPTIONS}
        until(lambda: server.get(slow).json()["finished"])
        accepted = server.send("POST", "/v1/batches", json.dumps(batch).encode(), AS_JSON)
        rows.append(("the report of a batch that runs", server.get(accepted.headers["location"] + "/junit.xml")))
        server.send("DELETE", accepted.headers["location"])
        until(lambda: server.compare().status == 200)
        held = holding_the_worker(server)
        rows.append(("a comparison when the queue is full", server.compare()))
        held.close()
        return rows
    finally:
        server.stop()


def key_rows():
    token, entry = new_key("ci", requests_per_minute=1, burst=4)
    small, tiny = new_key("tiny", max_storage_bytes=10)
    single, one = new_key("single", max_jobs=1)
    metrics, scraper = new_key("prometheus", "--scope", "metrics")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "keys.json"
        write_keys(path, entry, tiny, one, scraper)
        server = Server("--workers", "1", "--keys-file", str(path))
        try:
            rows = [
                ("no key", server.get("/v1/comparisons/" + NO_ID)),
                ("an unknown key", server.get("/v1/comparisons/" + NO_ID, extra=bearer("mg_" + "0" * 64))),
                ("two keys", server.get("/none", extra=bearer(token) + bearer(token))),
                ("a scheme that is not Bearer", server.get("/none", extra="Authorization: Basic YTpi\r\n")),
                ("a key without the scope", server.get("/metrics", extra=bearer(small))),
                ("a key of metrics for a comparison", server.get("/v1/comparisons/" + NO_ID, extra=bearer(metrics))),
                ("a mesh beyond the key's storage", server.send("POST", "/v1/meshes", SQUARE, bearer(small))),
            ]
            slow = server.compare(**SLOW, options=SLOW_OPTIONS, extra=ASYNC + bearer(single)).headers["location"]
            rows.append(("more comparisons than the key may have", server.compare(extra=ASYNC + bearer(single))))
            server.send("DELETE", slow, extra=bearer(single))
            answers = [server.get("/none", extra=bearer(token)) for _ in range(6)]
            rows.append(("more requests than the key's rate", next(answer for answer in answers if answer.status == 429)))
            return rows
        finally:
            server.stop()


def sections():
    server = Server(*FLAGS)
    try:
        out = [
            ("The head and the body of a request", head_rows(server)),
            ("Paths", path_rows(server)),
            ("The form of a comparison", form_rows(server)),
            ("Options of a comparison", option_rows(server)),
            ("Jobs and stored meshes", job_rows(server)),
            ("Batches", batch_rows(server) + stored_rows(server)),
        ]
    finally:
        server.stop()
    return [*out, ("A service at its limits", busy_rows()), ("Keys", key_rows())]
