"""Clients without a key, with half a key, with another one's, and with one whose limits are small."""

import contextlib
import hashlib
import json

from clients.attack import FORM, JSON, Family, demand, post, request, shown, with_keys
from harness import multipart
from victim import square

TOKENS, OTHERS, LIMITS = (Family(name, with_keys) for name in ("tokens", "other keys", "limits of a key"))
FAMILIES = (TOKENS, OTHERS, LIMITS)

BODY = multipart([("a", square(0)), ("b", square(2)), ("options", b"{}")])
PATHS = (b"GET /v1/none", b"GET /metrics", b"GET /v1/meshes", b"POST /v1/comparisons",
         b"DELETE /v1/meshes/" + b"0" * 64, b"GET /none", b"POST /v1/batches", b"GET /jobs.sqlite")


def bare(line, *fields, body=b"", host=b"Host: localhost"):
    """A request without the key of the attack."""
    return request(line, *fields, body=body, host=host).replace(b"@KEY@", b"")


# --- tokens -----------------------------------------------------------------------------------------------------------

for line in PATHS:
    TOKENS.sends("none, %s" % shown(line), bare(line, b"Content-Length: 0"), 401)
TOKENS.sends("none, and a body", bare(b"POST /v1/comparisons", FORM, body=BODY), 401)
TOKENS.sends("none, and a body that is expected", bare(b"POST /v1/comparisons", FORM, b"Content-Length: 1000000",
                                                       b"Expect: 100-continue"), 401)
TOKENS.sends("none, and a foreign origin", bare(b"POST /v1/options", b"Origin: https://evil.example", JSON,
                                                b"Content-Length: 0"), 401)
for value in (b"Bearer", b"Bearer ", b"Bearer x", b"Bearer mg_" + b"0" * 64, b"bearer mg_" + b"0" * 64,
              b"Bearer mg_" + b"0" * 63, b"Bearer " + b"x" * 512, b"Bearer " + b"x" * 8000,
              b"Bearer mg_" + b"\xff" * 64, b"Bearer a b", b"Bearer a,Bearer b", b"Bearer =", b"Basic eDp5", b"Basic",
              b"Digest username=x", b"Token x", b"null", b"undefined", b"",
              b"Bearer ' OR '1'='1", b"Bearer ../../keys.json", b"Bearer %00", b"Bearer \t x", b"mg_" + b"0" * 64):
    TOKENS.sends("'%s'" % shown(value, 30), bare(b"GET /v1/none", b"Authorization: " + value), 401)
for name, field in (("in a query", b"GET /v1/none?access_token=x"), ("in a query, as a key", b"GET /v1/none?key=x")):
    TOKENS.sends(name, bare(field), 401)
for header in (b"X-Api-Key", b"Proxy-Authorization", b"Cookie", b"X-Authorization", b"Authorization-Token"):
    TOKENS.sends("in %s" % header.decode(), bare(b"GET /v1/none", header + b": Bearer x"), 401)


@TOKENS.does("a byte off, at each place")
def _(arena):
    right = arena.service.key
    for place in range(len(b"Authorization: Bearer mg_"), len(right) - 2, 9):
        changed = right[:place] + (b"0" if right[place:place + 1] != b"0" else b"1") + right[place + 1:]
        arena.ask(bare(b"GET /v1/none", changed.strip()), 401)
    arena.ask(bare(b"GET /v1/none", right.strip()[:-1]), 401)
    arena.ask(bare(b"GET /v1/none", right.strip() + b"0"), 401)
    arena.ask(bare(b"GET /v1/none", right.strip().upper().replace(b"AUTHORIZATION: BEARER", b"Authorization: Bearer")),
              401)
    arena.ask(bare(b"GET /v1/none", right.strip()), 404)


@TOKENS.does("two, of which one is right")
def _(arena):
    for fields in ((arena.service.key.strip(), b"Authorization: Bearer x"),
                   (b"Authorization: Bearer x", arena.service.key.strip())):
        arena.ask(bare(b"GET /v1/none", *fields), 400)


@TOKENS.does("guessed a thousand times")
def _(arena):
    with arena.connect() as connection:
        stream = connection.makefile("rb")
        for i in range(1000):
            connection.sendall(bare(b"GET /v1/none", b"Authorization: Bearer mg_%064x" % i))
            answer = arena.read(stream)
            demand(answer is not None and answer.status in (401, 503), answer and answer.status)
    arena.ask(request(b"GET /v1/none"), 404)


# --- other keys -------------------------------------------------------------------------------------------------------


def as_other(arena, data, *allowed):
    return arena.ask(data.replace(b"@KEY@", arena.service.other_key), *allowed)


@OTHERS.does("meshes, jobs and batches of another one")
def _(arena):
    """What another key owns gets the answer of what does not exist."""
    mesh = square(4, 5, "owned")
    identity = hashlib.sha256(mesh).hexdigest().encode()
    as_other(arena, request(b"PUT /v1/meshes/" + identity, body=mesh), 200, 201)
    job = as_other(arena, post(BODY, b"Prefer: respond-async"), 202).headers["location"].encode()
    manifest = json.dumps({"comparisons": [{"a": identity.decode(), "b": identity.decode()}]}).encode()
    batch = as_other(arena, post(manifest, kind=JSON, line=b"POST /v1/batches"), 202).headers["location"].encode()
    unknown = {job: b"/v1/comparisons/" + b"0" * 32, batch: b"/v1/batches/" + b"0" * 32,
               b"/v1/meshes/" + identity: b"/v1/meshes/" + b"0" * 64}
    for path, other in unknown.items():
        for line in (b"GET %s", b"HEAD %s", b"DELETE %s"):
            theirs, none = (arena.ask(request(line % one), 404) for one in (path, other))
            demand(theirs.body == none.body, "another key's object is told from none")
    for path in (job + b"/events", job + b"/deviation.ply", batch + b"/results.jsonl", batch + b"/junit.xml",
                 batch + b"/events"):
        arena.ask(request(b"GET " + path), 404)
    for line in (b"POST %s/cancel" % job, b"POST %s/cancel" % batch):
        arena.ask(request(line, b"Content-Length: 0"), 404)
    arena.ask(post(json.dumps({"a": identity.decode(), "b": identity.decode()}).encode(), kind=JSON), 422)
    arena.ask(post(manifest, kind=JSON, line=b"POST /v1/batches"), 422)
    for path in unknown:
        as_other(arena, request(b"GET " + path), 200)


@OTHERS.does("lists, of its own alone")
def _(arena):
    for path in (b"/v1/meshes", b"/v1/comparisons", b"/v1/batches"):
        page = arena.ask(request(b"GET %s?limit=1" % path), 200).json()
        if page["next"]:
            arena.ask(request(b"GET %s?limit=1&after=%s" % (path, page["next"].encode())), 200)


@OTHERS.does("the same idempotency key, of another content")
def _(arena):
    key = b"Idempotency-Key: shared"
    other = multipart([("a", square(0)), ("b", square(7)), ("options", b"{}")])
    ours, theirs = arena.ask(post(BODY, key), 200), as_other(arena, post(other, key), 200)
    demand(ours.headers["location"] != theirs.headers["location"], "two keys share a job")


@OTHERS.does("metrics with a key that may not, and jobs with one of metrics")
def _(arena):
    arena.ask(request(b"GET /metrics"), 403)
    arena.ask(bare(b"GET /v1/none", arena.service.metrics_key.strip()), 403)
    arena.ask(bare(b"POST /v1/comparisons", arena.service.metrics_key.strip(), FORM, body=BODY), 403)


# --- limits of a key --------------------------------------------------------------------------------------------------


@LIMITS.does("a rate of six a minute")
def _(arena):
    """Beyond it each request is refused, whatever it asks for, and other keys are not."""
    key, statuses = arena.service.small_key.strip(), []
    with arena.connect() as connection:
        stream = connection.makefile("rb")
        for line in (b"GET /v1/none", b"GET /metrics", b"GET /v1/meshes") * 4:
            with contextlib.suppress(OSError):
                connection.sendall(bare(line, key))
            answer = arena.read(stream)
            if answer is None:
                break
            statuses.append(answer.status)
    demand(set(statuses) <= {200, 403, 404, 429, 503} and 429 in statuses, statuses)
    arena.ask(request(b"GET /v1/none"), 404)


@LIMITS.does("more than it may store")
def _(arena):
    answer = arena.ask(bare(b"POST /v1/meshes", arena.service.small_key.strip(), body=b"#" * 200_000), 403, 429)
    demand(answer.status != 403 or answer.json()["type"].endswith("quota-exceeded"), answer.body)
