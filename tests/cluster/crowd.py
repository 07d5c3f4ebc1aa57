"""Clients of a cluster whose parts die: they repeat a request with the same Idempotency-Key until it is accepted."""

import hashlib
import json
import random
import sys
import threading
import time

from processes import Gone, ask
from promises import Work
from scratch import ROOT

sys.path.insert(0, str(ROOT / "tests/chaos"))
from victim import ASYNC, FORM, JSON, multipart  # noqa: E402

REFUSED = (429, 503, 507)
PAUSE = 0.05          # before a client comes again; it need not obey Retry-After
MESH = {"Content-Type": "model/obj"}


def works(dice, pairs, number):
    """The works of all clients together: many small, some large."""
    weights = [8 if len(pair.a) < 10000 else 4 if len(pair.a) < 200000 else 1 for pair in pairs]
    for i in range(number):
        pair = dice.choices(pairs, weights)[0]
        yield Work(i, pair, dice.choice(({}, {"tolerance": {"diagonal": 1e-4}}, {"direction": "a_to_b"}, {"direction": "b_to_a"},
                                         {"gate": {"max_distance": dice.choice((0.01, 0.1, 1, 3))}}, {"statistics": True})))


class Crowd:
    """Submits works at front ends, looks after them, and notes in the ledger what it sees. `may`: how many works may be begun so far."""

    def __init__(self, ledger, ports, works, seed, clients=6, lookers=2, most_waiting=100):
        self.ledger, self.ports, self.most_waiting = ledger, ports, most_waiting
        self.works, self.taken, self.may = list(works), 0, 0
        self.salt, self.lock, self.over, self.failures = "%x" % seed, threading.Lock(), threading.Event(), []
        runs = [self._submit] * clients + [self._look] * lookers
        self.threads = [threading.Thread(target=self.guarded, args=(run, random.Random(seed + i)), daemon=True)
                        for i, run in enumerate(runs)]

    def start(self):
        for thread in self.threads:
            thread.start()

    def end(self):
        self.over.set()
        for thread in self.threads:
            thread.join(180)
        assert not self.failures, self.failures

    def guarded(self, run, dice):
        try:
            run(dice)
        except BaseException as error:  # a defect of ours: it must not pass as quiet
            self.failures.append(repr(error))
            raise

    def ask(self, dice, *request):
        """The answer of any front end; None: no answer, or an expected refusal."""
        try:
            answer = ask(dice.choice(self.ports), *request)
        except Gone:
            self.ledger.count("broken")
            return None
        if answer.status in REFUSED:
            self.ledger.count("refused")
            if answer.status == 503 and "retry-after" not in answer.headers:
                self.ledger.violated("503 without Retry-After: %s" % answer.body[:300])
            return None
        self.ledger.answered.mark()
        return answer

    def insist(self, dice, *request):
        while not self.over.is_set():
            answer = self.ask(dice, *request)
            if answer is not None:
                return answer
            time.sleep(PAUSE)
        return None

    def _take(self):
        with self.lock:
            if self.taken < min(self.may, len(self.works)) and len(self.ledger.waiting) < self.most_waiting:
                self.taken += 1
                return self.works[self.taken - 1]
        return None

    def _submit(self, dice):
        while not self.over.is_set():
            work = self._take()
            if work is None:
                time.sleep(0.02)
                continue
            self.promise(dice, work)

    def promise(self, dice, work):
        way = dice.random()
        if way < 0.1:
            return self.compare_plainly(dice, work)
        headers, body = self.by_id(dice, work) if way < 0.5 else self.by_files(work)
        headers = {**headers, "Idempotency-Key": "%s-%d" % (self.salt, work.number), **(ASYNC if dice.random() < 0.8 else {})}
        answer = self.insist(dice, "POST", "/v1/comparisons", body, headers)
        if answer is None:
            return None
        if answer.status not in (200, 202):
            return self.ledger.violated("POST: %d %s" % (answer.status, answer.body[:500]))
        self.ledger.accept(work, answer.headers["location"].rsplit("/", 1)[1])
        if answer.status == 200:
            self.ledger.check_result(work, answer.json())
        return None

    def by_files(self, work):
        """Small ones are new to the service each time."""
        salt = b"# %d\n" % work.number if len(work.pair.a) < 10000 else b""
        return FORM, multipart(salt + work.pair.a, work.pair.b, work.options)

    def by_id(self, dice, work):
        meshes = [work.pair.a, work.pair.b]
        for mesh in meshes:
            self.store(dice, mesh)
        a, b = map(identity_of, meshes)
        return JSON, json.dumps({"a": a, "b": b, "options": work.options}).encode()

    def store(self, dice, mesh):
        answer = self.insist(dice, "PUT", "/v1/meshes/" + identity_of(mesh), mesh, MESH)
        if answer is not None and answer.status not in (200, 201):
            self.ledger.violated("PUT: %d %s" % (answer.status, answer.body[:500]))

    def compare_plainly(self, dice, work):
        """A client without a key and without an answer was promised nothing: it tries again until it has an answer."""
        headers, body = self.by_files(work)
        answer = self.insist(dice, "POST", "/v1/comparisons", body, headers)
        if answer is None:
            return
        if answer.status != 200:
            return self.ledger.violated("POST: %d %s" % (answer.status, answer.body[:500]))
        self.ledger.count("plain")
        self.ledger.check_result(work, answer.json())

    def _look(self, dice):
        """Looks at jobs that wait, and now and then at one that has ended."""
        while not self.over.is_set():
            with self.ledger.lock:
                waiting, known = list(self.ledger.waiting), list(self.ledger.accepted)
            for identity in dice.sample(waiting, min(20, len(waiting))) + dice.sample(known, min(5, len(known))):
                self.look_at(dice, identity)
            time.sleep(PAUSE)

    def look_at(self, dice, identity):
        had_ended = self.ledger.accepted[identity].document is not None
        answer = self.ask(dice, "GET", "/v1/comparisons/" + identity)
        if answer is not None:
            self.ledger.check(identity, had_ended, answer)


def identity_of(mesh):
    return hashlib.sha256(mesh).hexdigest()
