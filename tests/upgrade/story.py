"""What clients ask of a service before it is killed in mid-work, and a record of what they were promised."""

import hashlib
import json
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/cluster"), str(ROOT / "tests/chaos")]
from processes import until  # noqa: E402
from victim import ASYNC, ENDLESS, FORM, JSON, ask, multipart, square  # noqa: E402

ENDED = ("done", "failed", "cancelled")
ENDLESS_MS = 4000     # the running comparison's time limit: it must outlast the requests that come after it
BROKEN = b"v 0 0 nan\n"
BROWN, STEADY = square(0, 12), square(0, 13)  # at distance 0, which bisection approaches for ever


class Refused(AssertionError):
    """An answer that the story does not have."""


class Client:
    """A client of one service. `promised` is what it was told, with all that is needed to ask again."""

    def __init__(self, port, token=None):
        self.port, self.head = port, {"Authorization": "Bearer " + token} if token else {}
        self.promised = {"meshes": [], "ended": [], "unended": [], "batches": [], "keys": []}

    def ask(self, method, path, body=None, headers=None, expected=(200,)):
        answer = ask(self.port, method, path, body, {**self.head, **(headers or {})})
        if answer.status not in expected:
            raise Refused("%s %s: %d %s" % (method, path, answer.status, answer.body[:500]))
        return answer

    def store(self, mesh, name, height):
        headers = {"Content-Type": "model/obj", "Content-Disposition": 'attachment; filename="%s"' % name}
        path = "/v1/meshes/" + hashlib.sha256(mesh).hexdigest()
        self.ask("PUT", path, mesh, headers, (201,))
        self.promised["meshes"].append({"height": height, "document": self.ask("GET", path).json()})

    def compare(self, a, b, options, distance, key=None, stored=False, wait=False):
        """Begins a comparison, or waits for its result. Returns its path."""
        if stored:
            ids = [hashlib.sha256(mesh).hexdigest() for mesh in (a, b)]
            headers, body = JSON, json.dumps({"a": ids[0], "b": ids[1], "options": options}).encode()
        else:
            headers, body = FORM, multipart(a, b, options)
        headers = {**headers, **({} if wait else ASYNC), **({"Idempotency-Key": key} if key else {})}
        answer = self.ask("POST", "/v1/comparisons", body, headers, (200, 202))
        identity = answer.headers["x-request-id"] if wait and not key else answer.headers["location"].rsplit("/", 1)[1]
        if key:
            self.remember("/v1/comparisons", key, headers, body, identity)
        self.promised["unended"].append({"id": identity, "distance": distance})
        return "/v1/comparisons/" + identity

    def remember(self, path, key, headers, body, identity):
        self.promised["keys"].append({"path": path, "key": key, "headers": headers, "body": body.decode(), "id": identity})

    def batch(self, key, name, comparisons, files=()):
        """`comparisons`: (name, a, b, distance) with ids of stored meshes or names of files that come along. Returns its path."""
        manifest = {"name": name, "comparisons": [{"name": each, "a": a, "b": b} for each, a, b, _ in comparisons]}
        parts = [(b'name="manifest"', json.dumps(manifest).encode())]
        parts += [(b'name="%s"; filename="%s.obj"' % (part, part), mesh) for part, mesh in files]
        body = b"".join(b"--xyz\r\nContent-Disposition: form-data; %s\r\n\r\n%s\r\n" % part for part in parts) + b"--xyz--\r\n"
        answer = self.ask("POST", "/v1/batches", body, {**FORM, "Idempotency-Key": key}, (202,))
        identity = answer.headers["location"].rsplit("/", 1)[1]
        self.remember("/v1/batches", key, FORM, body, identity)
        self.promised["batches"].append({"id": identity, "distances": [distance for *_, distance in comparisons]})
        return "/v1/batches/" + identity

    def wait(self, path, *states):
        return until(lambda: self.state(path) in states, what="%s to be %s" % (path, states))

    def state(self, path):
        return self.ask("GET", path).json()["state"]

    def settle(self):
        """Files what has ended by now under what has ended, with its document."""
        documents = [(one, self.ask("GET", "/v1/comparisons/" + one["id"]).json()) for one in self.promised["unended"]]
        self.promised["unended"] = [{**one, "state": document["state"]} for one, document in documents if document["state"] not in ENDED]
        self.promised["ended"] += [{**one, "document": document} for one, document in documents if document["state"] in ENDED]
        for batch in self.promised["batches"]:
            path = "/v1/batches/" + batch["id"]
            batch["document"] = self.ask("GET", path).json()
            batch["results"] = [json.loads(line) for line in self.ask("GET", path + "/results.jsonl").body.splitlines()]


def briefly(client):
    """A short story: all of it ends."""
    a, b = square(0), square(3)
    client.store(a, "low.obj", 0)
    client.store(b, "high.obj", 3)
    client.compare(a, b, {}, 3, key="nightly", stored=True, wait=True)
    client.wait(client.compare(a, BROKEN, {}, None), "failed")
    ids = [hashlib.sha256(mesh).hexdigest() for mesh in (a, b)]
    client.wait(client.batch("nightly-batch", "nightly", [("there", *ids, 3), ("back", *reversed(ids), 3)]), "done")
    client.settle()


def until_killed(client):
    """The long story. At its end a comparison runs, and others wait for it. The service has one worker."""
    low, high, top = square(0), square(2, 2), square(5, 3)
    for mesh, name, height in ((low, "low.obj", 0), (high, "square two.obj", 2), (top, "top.obj", 5)):
        client.store(mesh, name, height)
    ids = [hashlib.sha256(mesh).hexdigest() for mesh in (low, high, top)]
    client.compare(low, high, {}, 2, wait=True)
    client.compare(low, high, {"gate": {"max_distance": 1}, "statistics": True}, 2, key="kept", wait=True)
    for path in (client.compare(low, top, {"direction": "a_to_b", "gate": {"max_distance": 6}}, 5, stored=True),
                 client.compare(low, BROKEN, {}, None)):
        client.wait(path, *ENDED)
    mixed = [("stored", ids[0], ids[1], 2), ("file", {"part": "new"}, ids[2], 4), ("broken", {"part": "nan"}, ids[2], None),
             ("the same again", ids[0], ids[1], 2)]
    client.wait(client.batch("ended-batch", "ended", mixed, ((b"new", square(1)), (b"nan", BROKEN))), "done")
    stopped = client.compare(BROWN, STEADY, {**ENDLESS, "timeout_ms": 60000}, 0)
    client.wait(stopped, "running")
    time.sleep(0.3)  # for an interval that its end can have
    client.ask("DELETE", stopped)
    running = client.compare(BROWN, STEADY, {**ENDLESS, "timeout_ms": ENDLESS_MS}, 0, key="running")
    client.wait(running, "running")
    given_up = client.compare(low, high, {}, 2)
    client.ask("DELETE", given_up)
    client.compare(square(7), low, {"gate": {"max_distance": 8}}, 7, key="waiting")
    client.compare(high, top, {}, 3, stored=True)
    client.batch("waiting-batch", "waits", [("stored", ids[0], ids[2], 5), ("file", {"part": "new"}, ids[0], 9)], ((b"new", square(9)),))
    client.settle()
    states = sorted(one["state"] for one in client.promised["unended"])
    assert states == ["queued", "queued", "running"], states
    return running
