"""Keys of idempotency, jobs cancelled and deleted at once, batches of thousands, streams that are never read."""

import concurrent.futures
import hashlib
import json
import xml.etree.ElementTree as ET

from clients.arena import ENDLESS, comparison, endless, holds, reset, until
from clients.attack import JSON, Family, demand, post, request, shown
from contract import events_of
from victim import square

REPEATS, RACES, BATCHES, STREAMS, STORED, MAPS = (
    Family(name) for name in ("idempotency keys", "races", "batches", "streams", "stored meshes", "maps"))
FAMILIES = (REPEATS, RACES, BATCHES, STREAMS, STORED, MAPS)
ENDED = ("done", "failed", "cancelled")


def at_once(count, act):
    """Calls act(0), act(1) and so on, all at once; their results."""
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        return list(pool.map(act, range(count)))


def unique(arena):
    """A text that no other attack has."""
    return "%s-%s-%d" % (arena.source, arena.dice.randrange(1 << 60), arena.tries)


def ended(arena, path):
    """The document of a job, once it has ended."""
    return until(lambda: (document := arena.get(path, 200).json())["state"] in ENDED and document)


def put(arena, mesh):
    """Stores a mesh; its id."""
    identity = hashlib.sha256(mesh).hexdigest()
    arena.ask(request(b"PUT /v1/meshes/" + identity.encode(), body=mesh), 200, 201)
    return identity


# --- idempotency keys -------------------------------------------------------------------------------------------------

for name, value in (("two words", b"two words"), ("of 256 bytes", b"x" * 256), ("a control character", b"a\x7f"),
                    ("bytes beyond ASCII", b"caf\xc3\xa9"), ("a tab", b"a\tb"), ("empty", b"")):
    REPEATS.sends(name, comparison(0, 2, 1, None, b"Idempotency-Key: " + value), 400)


@REPEATS.does("of 255 odd characters")
def _(arena):
    key = bytes(arena.dice.choice(range(33, 127)) for _ in range(255))
    first, again = (arena.compare(fields=(b"Idempotency-Key: " + key,)) for _ in range(2))
    demand(first.json() == again.json(), "two answers to one key")
    arena.delete(first.headers["location"])


@REPEATS.does("of another content")
def _(arena):
    key = b"Idempotency-Key: " + unique(arena).encode()
    first = arena.compare(0, 2, fields=(key,))
    for changed in (dict(high=3), dict(options={"direction": "a_to_b"}), dict(high=2, n=2)):
        arena.compare(**{"low": 0, "high": 2, **changed}, fields=(key,), allowed=(422,))
    arena.delete(first.headers["location"])


@REPEATS.does("sent twelve times at once")
def _(arena):
    data = comparison(0, 5, 8, None, b"Idempotency-Key: " + unique(arena).encode())
    answers = at_once(12, lambda _: arena.ask(data, 200))
    demand(len({answer.body for answer in answers}) == 1, "several answers to one key")
    holds(answers[0].json(), 5)
    arena.delete(answers[0].headers["location"])


@REPEATS.does("twelve contents at once, of one key")
def _(arena):
    key = b"Idempotency-Key: " + unique(arena).encode()
    answers = at_once(12, lambda i: (i, arena.ask(comparison(0, 1 + i % 3, 4, None, key), 200, 422)))
    right = {i % 3 for i, answer in answers if answer.status == 200}
    demand(len(right) == 1, "one key stands for", right)
    for i, answer in answers:
        if answer.status == 200:
            holds(answer.json(), 1 + i % 3)
            path = answer.headers["location"]
    arena.delete(path)


@REPEATS.does("of a client that goes before its answer")
def _(arena):
    key = b"Idempotency-Key: " + unique(arena).encode()
    data = arena.filled(comparison(0, 4, 30, None, key))
    for _ in range(5):
        with arena.connect() as connection:
            connection.sendall(data)
            reset(connection)
    answer = arena.ask(data, 200)
    holds(answer.json(), 4)
    arena.delete(answer.headers["location"])


@REPEATS.does("of a job that is deleted meanwhile")
def _(arena):
    for _ in range(5):
        key = b"Idempotency-Key: " + unique(arena).encode()
        path = arena.ask(comparison(0, 2, 1, None, key, b"Prefer: respond-async"), 200, 202).headers["location"]
        # 409: it was cancelled before its meshes were read.
        at_once(2, lambda i: arena.delete(path) if i else arena.ask(comparison(0, 2, 1, None, key, b"Prefer: wait=0"),
                200, 202, 409, 503))
        arena.delete(path)


# --- races ------------------------------------------------------------------------------------------------------------


@RACES.does("deleted eight times at once while it runs")
def _(arena):
    path = arena.begin(20_000)
    at_once(8, lambda _: arena.delete(path))
    until(lambda: arena.delete(path).status in (204, 404))
    arena.get(path, 404)


@RACES.does("cancelled, deleted and looked at at once")
def _(arena):
    path = arena.begin(20_000)
    acts = (lambda: arena.ask(request(b"POST %s/cancel" % path.encode(), b"Content-Length: 0"), 200, 404),
            lambda: arena.delete(path),
            lambda: arena.get(path, 200, 404), lambda: arena.get(path + "/events", 200, 404),
            lambda: arena.get(path + "/deviation.ply", 200, 404, 409, 410))
    at_once(10, lambda i: acts[i % 5]())
    until(lambda: arena.delete(path).status == 404)


@RACES.does("cancelled as soon as it is accepted")
def _(arena):
    for _ in range(10):
        path = arena.begin(5000)
        answer = arena.ask(request(b"POST %s/cancel" % path.encode(), b"Content-Length: 0"), 200)
        demand(answer.json()["state"] in ("cancelled", "running", "queued", "done"), answer.body)
        document = ended(arena, path)
        demand(document["state"] in ("cancelled", "done"), document)
        if document["result"]:
            holds(document["result"], 0)
        arena.delete(path)


@RACES.does("a mesh that is deleted while it is compared")
def _(arena):
    meshes = [square(height, 12, unique(arena)) for height in (0, 3)]
    ids = [put(arena, mesh) for mesh in meshes]
    body = json.dumps({"a": ids[0], "b": ids[1]}).encode()

    def act(i):
        if i % 3 == 0:
            return arena.delete("/v1/meshes/" + ids[0]) and put(arena, meshes[0])
        answer = arena.ask(post(body, kind=JSON), 200, 422)
        return answer.status != 200 or holds(answer.json(), 3)
    at_once(9, act)
    for one in ids:
        arena.delete("/v1/meshes/" + one)


@RACES.does("one mesh stored and deleted by eight clients at once")
def _(arena):
    mesh = square(1, 6, unique(arena))
    path = "/v1/meshes/" + hashlib.sha256(mesh).hexdigest()
    at_once(8, lambda i: put(arena, mesh) if i % 2 else arena.delete(path))
    put(arena, mesh)
    arena.get(path, 200)
    arena.delete(path)


@RACES.does("clients that go while their comparisons run")
def _(arena):
    def act(i):
        with arena.connect() as connection:
            connection.sendall(arena.filled(endless(20_000)))
            connection.settimeout(0.1)
            try:
                connection.recv(1)
            except OSError:  # no answer yet: it waits or runs
                pass
            if i % 2:
                reset(connection)
    at_once(8, act)
    holds(arena.compare(0, 2).json(), 2)


# --- batches ----------------------------------------------------------------------------------------------------------


def submit(arena, manifest, *allowed, fields=()):
    return arena.ask(post(json.dumps(manifest).encode(), *fields, kind=JSON, line=b"POST /v1/batches"), *allowed)


def gone(arena, path):
    """Cancels and removes a batch."""
    until(lambda: arena.delete(path).status in (204, 404))


def pair_of(arena):
    """A pair of stored meshes at a distance of 2."""
    return {"a": put(arena, square(0, 1, "of batches")), "b": put(arena, square(2, 1, "of batches"))}


@BATCHES.does("of two thousand pairs")
def _(arena):
    pair = pair_of(arena)
    path = submit(arena, {"comparisons": [{**pair, "name": "p%d" % i} for i in range(2000)]}, 202).headers["location"]
    until(lambda: arena.get(path, 200).json()["finished"])
    counts = arena.get(path, 200).json()["counts"]
    demand(counts["total"] == counts["done"] == 2000, counts)
    gone(arena, path)


@BATCHES.does("whose rows are read by five clients at once")
def _(arena):
    pair = pair_of(arena)
    path = submit(arena, {"comparisons": [pair] * 100}, 202).headers["location"]
    until(lambda: arena.get(path, 200).json()["finished"])
    bodies = {answer.body for answer in at_once(5, lambda _: arena.get(path + "/results.jsonl", 200))}
    demand(len(bodies) == 1, "several answers to one batch")
    lines = [json.loads(line) for line in bodies.pop().splitlines()]
    demand([line["position"] for line in lines] == list(range(100)), "%d lines" % len(lines))
    holds(lines[-1]["result"], 2)
    gone(arena, path)


@BATCHES.does("of two thousand different pairs, cancelled at once")
def _(arena):
    pair = pair_of(arena)
    manifest = {"options": {**ENDLESS, "timeout_ms": 20_000},
                "comparisons": [{**pair, "options": {"tolerance": {"absolute": i * 1e-9}}} for i in range(2000)]}
    path = submit(arena, manifest, 202).headers["location"]
    arena.ask(request(b"POST %s/cancel" % path.encode(), b"Content-Length: 0"), 200)
    until(lambda: arena.get(path, 200).json()["finished"])
    gone(arena, path)


@BATCHES.does("of 2001 pairs")
def _(arena):
    submit(arena, {"comparisons": [pair_of(arena)] * 2001}, 413)


@BATCHES.does("of a hundred thousand pairs that are none")
def _(arena):
    submit(arena, {"comparisons": [1] * 100_000}, 413, 422)


@BATCHES.does("of names that are markup")
def _(arena):
    """What a client called a comparison is a text in the report, whatever it looks like."""
    names = ["<!-- -->", "]]>", '"><failure/>', "&lt;&#0;", "\ufffe\u0001", "a\u202eb", "x" * 255, "'", "<?xml?>"]
    pair = pair_of(arena)
    allowed = [name for name in names if name.isprintable()]
    submit(arena, {"comparisons": [{**pair, "name": name} for name in names if name not in allowed]}, 202, 422)
    path = submit(arena, {"name": "<&\"'>", "comparisons": [{**pair, "name": name} for name in allowed]},
                  202).headers["location"]
    until(lambda: arena.get(path, 200).json()["finished"])
    suite, = ET.fromstring(arena.get(path + "/junit.xml", 200).body)
    demand([case.get("name") for case in suite.findall("testcase")] == allowed, "names of a report")
    gone(arena, path)


@BATCHES.does("that name a part a thousand times")
def _(arena):
    manifest = json.dumps({"comparisons": [{"a": {"part": "x"}, "b": {"part": "x"}}] * 1000}).encode()
    body = b"".join(b'--XXboundaryXX\r\nContent-Disposition: form-data; name="%s"; filename="x.obj"\r\n\r\n%s\r\n' % one
                    for one in ((b"manifest", manifest), (b"x", square(0)))) + b"--XXboundaryXX--\r\n"
    path = arena.ask(post(body, line=b"POST /v1/batches"), 202).headers["location"]
    until(lambda: arena.get(path, 200).json()["finished"])
    gone(arena, path)


@BATCHES.does("the same one eight times at once")
def _(arena):
    manifest, key = {"comparisons": [pair_of(arena)] * 20}, (b"Idempotency-Key: " + unique(arena).encode(),)
    paths = {submitted.headers["location"] for submitted in at_once(8,
            lambda _: submit(arena, manifest, 202, fields=key))}
    demand(len(paths) == 1, "several batches of one key")
    gone(arena, paths.pop())


for name, value in (("a part that is not sent", {"part": "y"}), ("an empty part", {"part": ""}),
                    ("a part that is a path", {"part": "../../x"}), ("a number", 7), ("null", None), ("a list", []),
                    ("a path", "../x"), ("a URL", "http://evil.example/x")):
    BATCHES.sends("a mesh that is " + name, post(json.dumps({"comparisons": [{"a": value, "b": value}]}).encode(),
                                                 kind=JSON, line=b"POST /v1/batches"), (400, 422))

# --- streams ----------------------------------------------------------------------------------------------------------


def honest_stream(arena):
    """Another client follows a job to its end."""
    service = arena.service

    def follow():
        with service.connect() as connection:  # of another address than all attackers
            connection.sendall(endless(200, b"Prefer: respond-async").replace(b"@KEY@", service.other_key))
            answer = service.read(connection.makefile("rb"))
        if answer is None or answer.status != 202:
            return None
        with service.connect() as connection:
            connection.sendall(request(b"GET %s/events" % answer.headers["location"].encode()).replace(b"@KEY@",
                    service.other_key))
            told = service.read(connection.makefile("rb"))
        demand(told is not None and told.status == 200, "an honest stream beside others that are never read:",
               told and told.status)
        name, document = list(events_of(told.body))[-1]
        demand((name, document["state"]) == ("end", "done"), name, document)
        holds(document["result"], 0)
        return True
    arena.patiently(follow)


@STREAMS.does("a hundred that are never read", alone=True)
def _(arena):
    path, connections = arena.begin(20_000), []
    try:
        for _ in range(100):
            connections.append(arena.connect())
            connections[-1].sendall(arena.filled(request(b"GET %s/events" % path.encode())))
        honest_stream(arena)
    finally:
        for connection in connections:
            connection.close()
        arena.delete(path)
        until(lambda: arena.delete(path).status == 404)


@STREAMS.does("a hundred clients that wait, and go", alone=True)
def _(arena):
    connections = []
    for _ in range(100):
        connections.append(arena.connect())
        connections[-1].sendall(arena.filled(endless(50, b"Prefer: wait=20")))
    honest_stream(arena)
    for connection in connections:
        reset(connection)
    # What was promised to them runs on, in their share, until its time is over.
    until(lambda: arena.service.levels("jobs_running")["jobs_running"] == 0, 300)


@STREAMS.does("opened and reset sixty times")
def _(arena):
    path = arena.begin(20_000)
    for i in range(60):
        with arena.connect() as connection:
            connection.sendall(arena.filled(request(b"GET %s/events" % path.encode())))
            if i % 2:
                reset(connection)
    arena.delete(path)
    until(lambda: arena.delete(path).status == 404)


@STREAMS.does("over HTTP/1.0")
def _(arena):
    path = arena.begin(500)
    arena.ask(request(b"GET %s/events" % path.encode()).replace(b"HTTP/1.1", b"HTTP/1.0", 1), 505)
    arena.ask(request(b"HEAD %s/events" % path.encode()), 200)
    ended(arena, path)
    arena.delete(path)


for value in (b"wait=-1", b"wait=1e9", b"wait=99999999999999999999", b"wait=soon", b"wait=", b'wait="0"',
              b"respond-async; wait=0", b"handling=strict", b"wait=0, " * 500 + b"wait=0", b"=", b",,,"):
    STREAMS.sends("Prefer: " + shown(value), comparison(0, 2, 1, {"timeout_ms": 60_000}, b"Prefer: " + value),
                  (200, 202))

# --- stored meshes ----------------------------------------------------------------------------------------------------

MESH = square(9, 3, "stored")
WRONG = hashlib.sha256(b"another").hexdigest().encode()
STORED.table([
    ("a digest of another content", request(b"PUT /v1/meshes/" + WRONG, body=MESH), 422),
    ("a digest of nothing", request(b"PUT /v1/meshes/" + WRONG, b"Content-Length: 0"), 400),
    ("a digest in upper case", request(b"PUT /v1/meshes/" + WRONG.upper(), body=MESH), 400),
    ("no content", request(b"POST /v1/meshes", b"Content-Length: 0"), 400),
    ("one that is too large", request(b"POST /v1/meshes", body=b"#" * 1_000_001), 413),
    ("what is no mesh", request(b"POST /v1/meshes", body=b"\x89PNG" + bytes(100)), (200, 201)),
    ("a media type of a kilobyte", request(b"POST /v1/meshes", b"Content-Type: " + b"x" * 1000, body=MESH), (200, 201)),
    ("a body on a GET", request(b"GET /v1/meshes/" + WRONG, body=MESH), 404),
    ("one that is not there", request(b"DELETE /v1/meshes/" + WRONG), 404),
])


@STORED.does("half an upload, then its digest again")
def _(arena):
    mesh = square(8, 40, unique(arena))
    identity = hashlib.sha256(mesh).hexdigest().encode()
    for part in (0, 1, len(mesh) // 2, len(mesh) - 1):
        with arena.connect() as connection:
            connection.sendall(arena.filled(request(b"PUT /v1/meshes/" + identity,
                                                    b"Content-Length: %d" % len(mesh))) + mesh[:part])
            reset(connection)
    arena.get("/v1/meshes/" + identity.decode(), 404)
    put(arena, mesh)
    arena.delete("/v1/meshes/" + identity.decode())


@STORED.does("a hundred small ones, and gone again")
def _(arena):
    ids = [put(arena, square(i % 7, 1, unique(arena) + str(i))) for i in range(100)]
    for one in ids:
        arena.delete("/v1/meshes/" + one)


# --- maps -------------------------------------------------------------------------------------------------------------


@MAPS.does("asked for in every way at once, and deleted")
def _(arena):
    ids = [put(arena, square(height, 30, unique(arena))) for height in (0, 1)]
    answer = arena.ask(post(json.dumps({"a": ids[0], "b": ids[1]}).encode(), kind=JSON), 200)
    path = "/v1/comparisons/" + answer.json()["id"]
    kinds = ("ply", "glb", "vtp", "csv", "ply?of=b", "glb?max_triangles=10", "glb?max_triangles=1")

    def act(i):
        if i == 13:
            return arena.delete(path)
        head = (b"Range: bytes=0-10", b"If-None-Match: *", b"If-Modified-Since: Fri, 31 Dec 9999 23:59:59 GMT")[i % 3]
        return arena.ask(request(b"GET %s/deviation.%s" % (path.encode(), kinds[i % 7].encode()), head), 200, 304, 404,
                         410)
    at_once(14, act)
    for one in ids:
        arena.delete("/v1/meshes/" + one)


@MAPS.does("of a comparison without one")
def _(arena):
    path = arena.begin(20_000)
    arena.get(path + "/deviation.ply", 404, 409, 410)
    arena.delete(path)
    until(lambda: arena.delete(path).status == 404)
