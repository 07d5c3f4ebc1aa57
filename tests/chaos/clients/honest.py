"""A client that uses the service as it is meant beside all attacks, and knows what each answer has to be."""

import collections
import contextlib
import hashlib
import json
import threading
import traceback

from clients.arena import comparison, holds
from clients.attack import JSON, KEY, demand, post, request
from contract import events_of
from victim import square

SOURCE = "127.0.0.4"
BUSY = (408, 429, 503)
PAUSE = 0.1


class Busy(Exception):
    """Refused with a time to come back, or closed."""


class Honest(threading.Thread):
    """Runs until end(). `counts`: of acts by outcome; `broken`: what was wrong, as texts."""

    def __init__(self, service, dice):
        super().__init__(daemon=True)
        self.service, self.dice, self.over = service, dice, threading.Event()
        self.counts, self.broken = collections.Counter(), []
        self.key = service.other_key
        self.start()

    def end(self):
        self.over.set()
        self.join()

    def run(self):
        acts = (self.compare, self.compare, self.repeat, self.follow, self.store)
        ended = False
        while not ended:
            act = self.dice.choice(acts)
            try:
                act()
                self.counts["served"] += 1
            except (Busy, OSError):
                self.counts["refused"] += 1
            except Exception:
                self.broken.append("%s: %s" % (act.__name__, traceback.format_exc(limit=3)))
            ended = self.over.wait(PAUSE)

    def ask(self, data, *allowed):
        with self.service.connect(SOURCE) as connection:
            connection.sendall(data.replace(KEY, self.key))
            answer = self.service.read(connection.makefile("rb"))
        if answer is None or answer.status in BUSY:
            raise Busy
        demand(answer.status in allowed, answer.status, answer.body)
        return answer

    def pair(self):
        low, high = self.dice.randrange(64) / 8, self.dice.randrange(64) / 8
        return low, high, self.dice.choice((1, 2, 8))

    def compare(self):
        low, high, n = self.pair()
        holds(self.ask(comparison(low, high, n), 200).json(), abs(high - low))

    def repeat(self):
        """The same request twice is one job, which is kept until it is deleted."""
        low, high, n = self.pair()
        data = comparison(low, high, n, None, b"Idempotency-Key: honest-%x" % self.dice.randrange(1 << 60))
        first, again = self.ask(data, 200), self.ask(data, 200)
        demand(first.json() == again.json(), "two answers to one key")
        path = first.headers["location"].encode()
        kept = self.ask(request(b"GET " + path), 200).json()
        demand(kept["result"] == first.json(), "another result is kept")
        self.ask(request(b"DELETE " + path), 204)

    def follow(self):
        low, high, n = self.pair()
        path = self.ask(comparison(low, high, n, None, b"Prefer: respond-async"), 202).headers["location"].encode()
        name, document = list(events_of(self.ask(request(b"GET %s/events" % path), 200).body))[-1]
        demand((name, document["state"]) == ("end", "done"), name, document)
        holds(document["result"], abs(high - low))
        self.ask(request(b"DELETE " + path), 204)

    def store(self):
        low, high, n = self.pair()
        meshes = [square(height, n, "honest %x" % self.dice.randrange(1 << 60)) for height in (low, high)]
        ids = [hashlib.sha256(mesh).hexdigest() for mesh in meshes]
        try:
            for identity, mesh in zip(ids, meshes):
                self.ask(request(b"PUT /v1/meshes/" + identity.encode(), body=mesh), 200, 201)
            answer = self.ask(post(json.dumps({"a": ids[0], "b": ids[1]}).encode(), kind=JSON), 200)
            holds(answer.json(), abs(high - low))
        finally:
            for identity in ids:
                with contextlib.suppress(Busy):
                    self.ask(request(b"DELETE /v1/meshes/" + identity.encode()), 204, 404)
