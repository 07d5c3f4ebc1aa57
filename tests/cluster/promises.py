"""A ledger of what a cluster has promised to its clients, checks of it, and the times in which nothing happened."""

import operator
import threading
import time

from rig import ENDED

# A write to a job that has ended, other than its removal, is a second result that was accepted.
SECOND_RESULTS = """
CREATE TABLE second_results (job text, before text, after text);
CREATE FUNCTION note_second_result() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO second_results VALUES (OLD.id, OLD::text, NEW::text);
  RETURN NEW;
END $$;
CREATE TRIGGER second_results AFTER UPDATE ON jobs FOR EACH ROW
  WHEN (OLD.state >= 2 AND (OLD.state, OLD.document, OLD.tries) IS DISTINCT FROM (NEW.state, NEW.document, NEW.tries))
  EXECUTE FUNCTION note_second_result();
"""


class Work:
    """One wanted comparison, and all that is known of it. Its identity is known once it is accepted."""

    def __init__(self, number, pair, options):
        self.number, self.pair, self.options = number, pair, options
        self.identity = None
        self.document = None  # once it has ended


class Ledger:
    """`same`: whether two documents of a job or batch that has ended are one."""

    def __init__(self, same=operator.eq):
        self.same = same
        self.lock = threading.Lock()
        self.violations, self.counts = [], {}
        self.accepted = {}                 # id to Work
        self.waiting = set()               # ids of comparisons that are not known to have ended
        self.answered = Gaps()             # any answer but a refusal

    def count(self, what, number=1):
        with self.lock:
            self.counts[what] = self.counts.get(what, 0) + number

    def violated(self, text):
        with self.lock:
            self.violations.append(text)
        print("VIOLATION: " + text[:2000], flush=True)

    def accept(self, work, identity):
        """A 202, or the 200 of a durable one. The same work is accepted again when its client saw no answer before."""
        with self.lock:
            known = self.accepted.setdefault(identity, work)
            if work.identity is None and known is work:
                work.identity = identity
                self.waiting.add(identity)
        if known is not work or work.identity != identity:
            self.violated("one Idempotency-Key is the jobs %s and %s" % (work.identity, identity))

    def check(self, identity, had_ended, answer):
        """Checks the answer to GET of an accepted job. `had_ended`: known before the request."""
        if answer.status == 404:
            return self.violated("lost: the job " + identity)
        if answer.status != 200:
            return self.violated("%d for the job %s: %s" % (answer.status, identity, answer.body[:500]))
        work, document = self.accepted[identity], answer.json()
        if document["id"] != identity:
            return self.violated("another job than %s: %s" % (identity, document))
        if document["state"] in ENDED:
            self._check_end(work, document)
        elif had_ended:
            self.violated("the end of the job %s was taken back: %s" % (identity, document))

    def _check_end(self, work, document):
        with self.lock:
            first = work.document is None
            if first:
                work.document = document
                self.waiting.discard(work.identity)
        if not first:
            if not self.same(work.document, document):
                self.violated("the job %s has two ends: %s and %s" % (work.identity, work.document, document))
            return
        self.count(document["state"])
        self.count("tries", document["tries"])
        if document["state"] != "done" or document["result"]["id"] != work.identity:
            return self.violated("the job %s ended so: %s" % (work.identity, document))
        self.check_result(work, document["result"])

    def check_result(self, work, result):
        self.count("intervals")
        direction, gate = work.options.get("direction", "symmetric"), work.options.get("gate")
        if result["status"] not in ("converged", "gate_decided", "precision_floor") or work.pair.contradicts(result, direction):
            self.violated("%s, %s: %s is not %s" % (work.pair.name, work.options, result, work.pair.truth[direction]))
        if gate and work.pair.contradicts_verdict(result["verdict"], gate["max_distance"], direction):
            self.violated("%s: %s, but %s" % (work.options, result["verdict"], work.pair.truth[direction]))


class Gaps:
    """The gaps of half a second and more between marks."""

    def __init__(self):
        self.lock = threading.Lock()
        self.last = None
        self.found = []  # (from, to), of half a second and more

    def mark(self, now=None):
        now = now or time.monotonic()
        with self.lock:
            if self.last is not None and now - self.last >= 0.5:
                self.found.append((self.last, now))
            self.last = now

    def pause(self):
        """Ends the current gap; the next one begins with the next mark."""
        with self.lock:
            self.last = None


def longest_stall(gaps, outages):
    """The longest gap, without the part of it in an outage of the database."""
    return max([0.0, *(end - start - sum(max(0, min(end, over) - max(start, began)) for began, over in outages)
                       for start, end in gaps)])
