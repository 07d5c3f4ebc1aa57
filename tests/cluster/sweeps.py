"""Batches in a cluster whose parts die: sent, watched, some of them cancelled, and held against what was promised of them."""

import json
import random
import threading
import time

from crowd import JSON, PAUSE, identity_of, works

FORM = {"Content-Type": "multipart/form-data; boundary=xyz"}
REPEATS = 5   # one of so many items is the work of another one


class Sweep:
    """A wanted batch, and all that is known of it. `works`: the work of each item, in order; some occur more than once.

    `salt`: makes its work differ from the others' by files that come along; none: its meshes are stored."""

    def __init__(self, number, works, salt=""):
        self.number, self.works, self.salt, self.files = number, works, salt, {}
        self.identity, self.ended = None, 0  # how many items are known to have
        self.document = None                 # once all have
        self.cancelled = self.settled = self.forgotten = False  # by DELETE; `settled`: it was answered

    def meshes(self, work):
        a = b"# %s\n%s" % (self.salt.encode(), work.pair.a) if self.salt else work.pair.a
        return {"%s-a" % work.pair.name: a, "%s-b" % work.pair.name: work.pair.b}

    def all_meshes(self):
        return {name: mesh for work in self.works for name, mesh in self.meshes(work).items()}

    def manifest(self):
        def item(work):
            a, b = ({"part": name} if self.salt else identity_of(mesh) for name, mesh in self.meshes(work).items())
            return {"name": work.pair.name, "a": a, "b": b, "options": work.options}
        return json.dumps({"name": "sweep %d" % self.number, "comparisons": [item(work) for work in self.works]}).encode()

    def form(self):
        parts = [(b'"manifest"', self.manifest())]
        parts += [(b'"%s"; filename="%s.obj"' % (name.encode(), name.encode()), mesh) for name, mesh in self.all_meshes().items()]
        return b"".join(b"--xyz\r\nContent-Disposition: form-data; name=%s\r\n\r\n%s\r\n" % part for part in parts) + b"--xyz--\r\n"

    def measured(self, work):
        """A key that is the same for equal work of any batch."""
        return self.salt, work.pair.name, json.dumps(work.options, sort_keys=True)


def sweeps(dice, pairs, number, size, seed):
    """Lists of batches that are sent one after the other. The second of two shares half of its work with the first, and is cancelled."""
    for i in range(number):
        if i % 3 == 1:
            yield [Sweep(i, repeating(dice, pairs, size))]
            continue
        salt = "%x-%d" % (seed, i)
        first = Sweep(i, repeating(dice, pairs, size), salt)
        shared = first.works[:size // 2]
        yield [first] + [Sweep(number + i, shared + repeating(dice, pairs, size - len(shared)), salt)] * (i % 3 == 0)


def repeating(dice, pairs, size):
    found = list(works(dice, pairs, max(1, size - size // REPEATS)))
    found += dice.choices(found, k=size - len(found))
    dice.shuffle(found)
    return found


class Sweeper:
    """Sends groups of sweeps at the pace of a crowd, and looks after them."""

    def __init__(self, crowd, groups, seed):
        self.crowd, self.ledger, self.groups, self.salt = crowd, crowd.ledger, groups, "sweep-%x" % seed
        self.sent = 0  # groups
        self.threads = [threading.Thread(target=crowd.guarded, args=(run, random.Random(seed - i)), daemon=True)
                        for i, run in enumerate((self._send_all, self._look))]

    def start(self):
        for thread in self.threads:
            thread.start()

    def end(self):
        for thread in self.threads:
            thread.join(180)

    def accepted(self):
        return [sweep for group in self.groups for sweep in group if sweep.identity]

    def waiting(self):
        """Batches that are not known to have ended. Not empty before all are sent."""
        waiting = ["sweep %d" % sweep.number for sweep in self.accepted() if not (sweep.document or sweep.forgotten)]
        return waiting + ["batches to be sent"] * (self.sent < len(self.groups))

    def _send_all(self, dice):
        for number, group in enumerate(self.groups):
            while self.crowd.taken < len(self.crowd.works) * number // len(self.groups):
                if self.crowd.over.is_set():
                    return
                time.sleep(PAUSE)
            for sweep in group:
                self.send(dice, sweep)
            if len(group) > 1 and group[1].identity:
                time.sleep(dice.uniform(0, 1))
                self.cancel(dice, group[1])
            self.sent += 1

    def send(self, dice, sweep):
        headers, body = (FORM, sweep.form()) if sweep.salt else (JSON, sweep.manifest())
        for mesh in () if sweep.salt else sweep.all_meshes().values():
            self.crowd.store(dice, mesh)
        key = {"Idempotency-Key": "%s-%d" % (self.salt, sweep.number)}
        answer = self.crowd.insist(dice, "POST", "/v1/batches", body, {**headers, **key})
        if answer is None:
            return
        if answer.status != 202 or answer.json()["counts"]["total"] != len(sweep.works):
            return self.ledger.violated("POST of a batch: %d %s" % (answer.status, answer.body[:500]))
        sweep.identity = answer.headers["location"].rsplit("/", 1)[1]
        self.ledger.count("batches")

    def cancel(self, dice, sweep):
        """Cancels a batch. DELETE forgets one that has ended, perhaps by an earlier DELETE whose answer was lost."""
        unanswered = False
        while not self.crowd.over.is_set():
            sweep.cancelled = True
            answer = self.crowd.ask(dice, "DELETE", "/v1/batches/" + sweep.identity)
            if answer is not None:
                break
            unanswered = True
            time.sleep(PAUSE)
        else:
            return
        sweep.forgotten = answer.status == 204 or answer.status == 404 and unanswered
        if answer.status != 200 and not sweep.forgotten:
            self.ledger.violated("DELETE of a batch: %d %s" % (answer.status, answer.body[:500]))
        sweep.document, sweep.settled = None, True
        self.ledger.count("forgotten batches" if sweep.forgotten else "cancelled batches")

    def _look(self, dice):
        while not self.crowd.over.is_set():
            for sweep in self.accepted():
                if not sweep.forgotten:
                    self.look_at(dice, sweep)
            time.sleep(4 * PAUSE)

    def look_at(self, dice, sweep):
        """Checks that its counts only grow, and that nothing changes after its end."""
        before, had_ended = sweep.ended, sweep.document
        answer = self.crowd.ask(dice, "GET", "/v1/batches/" + sweep.identity)
        if answer is None or sweep.cancelled and not sweep.settled or sweep.forgotten:
            return
        if answer.status != 200:
            return self.ledger.violated("%d for the batch %s: %s" % (answer.status, sweep.identity, answer.body[:500]))
        document = answer.json()
        counts = document["counts"]
        sweep.ended = counts["done"] + counts["failed"] + counts["cancelled"]
        if counts["total"] != len(sweep.works) or counts["gone"] or sweep.ended < before or had_ended and not self.ledger.same(had_ended, document):
            self.ledger.violated("the batch %s of %d: %s after %s" % (sweep.identity, len(sweep.works), document, had_ended or before))
        if document["finished"] and sweep.settled == sweep.cancelled:
            sweep.document = document

    def look_again(self, front_ends):
        """Checks every batch, when nothing runs any more; returns the ids of their comparisons."""
        jobs, known = {}, set()
        for sweep in self.accepted():
            for front_end in front_ends:
                if sweep.forgotten:
                    self._expect(front_end, sweep, 404)
                else:
                    lines = self._check(front_end, sweep)
                    known.update(line["comparison"] for line in lines)
                    if not sweep.cancelled:
                        self._check_sharing(sweep, lines, jobs)
        if len(set(jobs.values())) != len(jobs):
            self.ledger.violated("different work is one comparison: %s" % jobs)
        self.ledger.count("batches' comparisons", len(known))
        return known

    def _expect(self, front_end, sweep, status, place=""):
        answer = front_end.ask("GET", "/v1/batches/" + sweep.identity + place)
        if answer.status != status:
            self.ledger.violated("%d for the batch %s%s: %s" % (answer.status, sweep.identity, place, answer.body[:500]))
        return answer

    def _check(self, front_end, sweep):
        document = self._expect(front_end, sweep, 200).json()
        lines = [json.loads(line) for line in self._expect(front_end, sweep, 200, "/results.jsonl").body.splitlines()]
        if sweep.document and not self.ledger.same(sweep.document, document):
            self.ledger.violated("the batch %s has two ends: %s and %s" % (sweep.identity, sweep.document, document))
        sweep.document = document
        if document["id"] != sweep.identity or document["state"] != ("cancelled" if sweep.cancelled else "done"):
            self.ledger.violated("the batch %s ended so: %s" % (sweep.identity, document))
        if [(line["position"], line["name"]) for line in lines] != [(i, work.pair.name) for i, work in enumerate(sweep.works)]:
            self.ledger.violated("the batch %s has lost items, or has some twice: %s" % (sweep.identity, document))
            return []
        if document["counts"] != counts_of(lines):
            self.ledger.violated("the batch %s counts %s, but has %s" % (sweep.identity, document["counts"], counts_of(lines)))
        for work, line in zip(sweep.works, lines):
            self._check_line(sweep, work, line)
        return lines

    def _check_line(self, sweep, work, line):
        result = line["result"]
        if line["state"] == "done" and result["id"] == line["comparison"] and result["verdict"] == line["verdict"]:
            return self.ledger.check_result(work, result)
        if line["state"] != "cancelled" or not sweep.cancelled:
            return self.ledger.violated("an item of the batch %s ended so: %s" % (sweep.identity, line))
        if result and work.pair.contradicts(result, work.options.get("direction", "symmetric")):
            self.ledger.violated("%s, cancelled: %s is not %s" % (work.pair.name, result, work.pair.truth))

    def _check_sharing(self, sweep, lines, jobs):
        for work, line in zip(sweep.works, lines):
            if jobs.setdefault(sweep.measured(work), line["comparison"]) != line["comparison"]:
                self.ledger.violated("%s was measured twice, as %s" % (sweep.measured(work), line))


def counts_of(lines):
    states, verdicts = [line["state"] for line in lines], [line["verdict"] for line in lines if line["state"] == "done"]
    counts = {state: states.count(state) for state in ("queued", "running", "done", "failed", "cancelled", "gone")}
    return {"total": len(lines), **counts, **{verdict: verdicts.count(verdict) for verdict in ("pass", "fail", "undecided")}}
