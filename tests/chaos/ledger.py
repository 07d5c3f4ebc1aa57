"""What the service has promised to its clients, and whether it keeps it."""

import json
import threading

ENDED = ("done", "failed", "cancelled")
MAX_TRIES = 5  # of a job during which the service ends


def is_given_up(document):
    return (document["state"] == "failed" and document["tries"] == MAX_TRIES and document["result"] is None
            and "the service ended while it ran" in document["problem"]["detail"])


class Job:
    def __init__(self, distance, brief, accepted_in):
        self.distance = distance    # the true one
        self.brief = brief          # ends by its time, which may be over before it has read its meshes, on a slow machine
        self.accepted_in = accepted_in  # this life of the service
        self.state = "accepted"     # or "removing": its DELETE may have counted; "forgotten": it did
        self.document = None        # once it had ended


class Ledger:
    def __init__(self):
        self.lock = threading.Lock()
        self.lives = 0       # that the service has begun
        self.jobs = {}       # by id
        self.keys = {}       # Idempotency-Key to id
        self.meshes = {}     # id to "arriving", "stored", "removing" or "deleted"
        self.violations = []
        self.counts = {}

    def count(self, what, number=1):
        with self.lock:
            self.counts[what] = self.counts.get(what, 0) + number

    def violated(self, text):
        with self.lock:
            self.violations.append(text)

    def accepted(self, identity, distance, key=None, brief=False):
        with self.lock:
            if key and self.keys.setdefault(key, identity) != identity:
                self.violations.append("the Idempotency-Key %s became %s and %s" % (key, self.keys[key], identity))
            if identity in self.jobs and self.jobs[identity].distance != distance:
                self.violations.append("two jobs have the id " + identity)
            return self.jobs.setdefault(identity, Job(distance, brief, self.lives))

    def check_answer(self, identity, job, answer, ended):
        """GET of a job: whether it is known, whole, right, and the same as before. `ended`: it had been seen to have ended
        before it was asked for; another thread may see that meanwhile."""
        if answer.status == 404:
            if job.state == "accepted":
                self.violated("lost: the job " + identity)
            return
        if answer.status != 200:
            return self.violated("%d for the job %s: %s" % (answer.status, identity, answer.body[:200]))
        if job.state == "forgotten":
            return self.violated("back again: the job " + identity)
        try:
            document = json.loads(answer.body)
        except ValueError:
            return self.violated("half a document: the job %s: %s" % (identity, answer.body[:200]))
        if document["state"] in ENDED:
            self._check_end(identity, job, document)
        elif ended:
            self.violated("the end of the job %s was taken back: %s" % (identity, document["state"]))

    def _check_end(self, identity, job, document):
        if job.document is None:
            job.document = document
            self.count("given up" if is_given_up(document) else document["state"])
            self.check_result(identity, job.distance, document)
            if not self._may_end(job, document):
                self.violated("the job %s ended as %s: %s" % (identity, document["state"], document["problem"]))
        elif job.document != document:
            self.violated("the job %s has two ends: %s and %s" % (identity, job.document, document))

    def _may_end(self, job, document):
        if is_given_up(document):  # what runs for a good part of a life may be met by the ends of five
            return job.brief and self.lives - job.accepted_in >= MAX_TRIES
        if document["state"] == "failed":
            return job.brief and document["problem"]["type"].endswith("/out-of-time")
        return document["state"] == "done" or job.state == "removing"

    def check_result(self, identity, distance, document):
        result = document["result"]
        if result is None:
            if document["state"] == "done":
                self.violated("the job %s is done without a result" % identity)
            return
        if result["id"] != identity:
            self.violated("the job %s has the result of %s" % (identity, result["id"]))
        self.check_interval(result, distance)

    def check_interval(self, result, distance):
        lower, upper = result["distance"]["lower"], result["distance"]["upper"]
        self.count("intervals")
        if not (lower <= distance <= (upper if upper is not None else float("inf"))):
            self.violated("[%r, %r] does not hold %r" % (lower, upper, distance))
