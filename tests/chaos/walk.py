"""The load of the campaign of failing calls: one client that does everything, and what it is promised."""

import json
import time

from ledger import Ledger
from load import Client
from victim import FORM, Gone, ask, multipart, square

HONEST = (429, 500, 503, 507)
MOST_LOOKS = 50
CUT_OFF = "the connection was closed before the body was complete"


class HonestLedger(Ledger):
    """A ledger that allows what a service may say whose system fails: that it could not."""

    def violated(self, text):
        if CUT_OFF not in text:  # what a failed read of a connection looks like
            super().violated(text)

    def check_answer(self, identity, job, answer, ended):
        if answer.status in HONEST:
            return self.count("honest")
        super().check_answer(identity, job, answer, ended)

    def _may_end(self, job, document):
        if document["state"] == "failed" and document["problem"]["type"].rpartition("/")[2] in ("internal", "storage-unavailable"):
            self.count("failed honestly")
            return True
        return super()._may_end(job, document)


class User(Client):
    """Does everything once, in the same order each time."""

    def __init__(self, ledger, seed, name="user"):
        super().__init__(ledger, name, seed)
        self.last_result = None

    def walk(self, port, most_silent=2):
        """Returns how many requests had no answer. Ends after so many: the rest would only wait as long."""
        self.port = port
        silent = 0
        for act in (self.store_mesh, self.store_mesh, self.submit, self.submit_with_key, self.repeat, self.compare_now,
                    self.compare_large, self.compare_by_id, self.compare_grids, self.follow_endless, self.map_of_last, self.batch,
                    self.wait_a_little, self.look, self.unknown, self.ready, self.remove_job, self.delete_mesh):
            try:
                act()
            except Gone:
                silent += 1
                if silent == most_silent:
                    return silent
        return silent

    def compare_large(self):
        """An upload that is a file, and a reader that it keeps busy."""
        a, b = square(1, 60, self.new_name()), square(3, 60, self.new_name())
        answer = self.post(multipart(a, b, {}), FORM, 2)
        if answer.status == 200:
            self.last_result = answer.json()["id"]

    def compare_grids(self):
        """Brings the search into its last phase."""
        self.post(multipart(square(1, 20, self.new_name()), square(1, 23, self.new_name()),
                            {"strategy": "four_point", "tolerance": {"absolute": 0.01}}), FORM, 0)

    def follow_endless(self):
        """Looks at a job that runs until it tells of its progress, and then removes it, or not."""
        answer = self.submit_endless()
        if answer.status != 202:
            return
        identity = answer.json()["id"]
        for _ in range(MOST_LOOKS):
            seen = ask(self.port, "GET", "/v1/comparisons/" + identity)
            if seen.status == 200 and (seen.json()["progress"] or seen.json()["state"] not in ("queued", "running")):
                break
            time.sleep(0.02)
        if self.dice.choice((True, False)):
            self.remove(identity)

    def unknown(self):
        answer = ask(self.port, "GET", "/v1/comparisons/" + "0" * 32)
        if answer.status not in (404, *HONEST):
            self.ledger.violated("a job that is none: %d %s" % (answer.status, answer.body[:200]))

    def map_of_last(self):
        if self.last_result:
            answer = ask(self.port, "GET", "/v1/comparisons/%s/deviation.ply" % self.last_result)
            if answer.status == 200 and not answer.body.startswith(b"ply"):
                self.ledger.violated("a map that is none: %r" % answer.body[:100])
            elif answer.status not in (200, 404, 409, 410, *HONEST):
                self.ledger.violated("a map: %d %s" % (answer.status, answer.body[:200]))

    def batch(self):
        pairs = [{"name": "p", "a": {"part": "a"}, "b": {"part": "b"}}]
        body = b""
        for name, filename, data in (("manifest", "", json.dumps({"comparisons": pairs}).encode()),
                                     ("a", "a.obj", square(1, 1, self.new_name())), ("b", "b.obj", square(2, 1, self.new_name()))):
            extra = '; filename="%s"' % filename if filename else ""
            body += b'--xyz\r\nContent-Disposition: form-data; name="%s"%s\r\n\r\n%s\r\n' % (name.encode(), extra.encode(), data)
        answer = ask(self.port, "POST", "/v1/batches", body + b"--xyz--\r\n", FORM)
        self.ledger.count("batches" if answer.status == 202 else "batches refused")

    def ready(self):
        for path in ("/readyz", "/healthz", "/metrics"):
            answer = ask(self.port, "GET", path)
            if answer.status not in (200, *HONEST):
                self.ledger.violated("%s: %d" % (path, answer.status))
