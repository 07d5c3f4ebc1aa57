"""Clients that use all of the service at once, and note in a ledger what the service promises."""

import hashlib
import json
import random
import threading

from victim import ASYNC, ENDLESS, FORM, JSON, Gone, ask, multipart, square

REFUSED = (429, 503, 507)


class Client:
    """A client that sends one request at a time; the next begins after the answer, or after the service's end."""

    def __init__(self, ledger, name, seed):
        self.ledger, self.name, self.dice = ledger, name, random.Random(seed)
        self.serial = 0
        self.port = None
        self.own_meshes = {}  # id to height, of meshes that no other client deletes
        self.own_jobs = []
        self.unsure = []      # of Idempotency-Keys that may have been seen: headers, body, distance
        self.acts = [(8, self.submit), (4, self.submit_with_key), (3, self.repeat), (2, self.wait_a_little),
                     (2, self.submit_endless), (2, self.compare_now), (5, self.store_mesh), (5, self.compare_by_id),
                     (1, self.delete_mesh), (3, self.look), (3, self.remove_job)]

    def act(self, port):
        self.port = port
        weights, acts = zip(*self.acts)
        self.dice.choices(acts, weights)[0]()

    def new_name(self):
        self.serial += 1
        return "%s-%d" % (self.name, self.serial)

    def pair(self):
        """Two meshes that no client has sent before, and their distance."""
        low, high = self.dice.randrange(64) / 8, self.dice.randrange(64) / 8
        n = self.dice.choice((1, 1, 2, 8, 30))
        return square(low, n, self.new_name()), square(high, n, self.new_name()), abs(high - low)

    def post(self, body, headers, distance, key=None, brief=False):
        answer = ask(self.port, "POST", "/v1/comparisons", body, headers)
        self.ledger.count("requests")
        if answer.status in (200, 202) and "location" in answer.headers:
            identity = answer.headers["location"].rsplit("/", 1)[1]
            self.ledger.accepted(identity, distance, key, brief)
            self.own_jobs.append(identity)
        if answer.status == 200:
            self.ledger.check_interval(answer.json(), distance)
        elif answer.status == 202:
            self.ledger.count("accepted")
        elif answer.status in REFUSED:
            self.ledger.count("refused")
        else:
            self.ledger.violated("POST: %d %s" % (answer.status, answer.body[:300]))
        return answer

    def submit(self):
        a, b, distance = self.pair()
        self.post(multipart(a, b, self.options()), {**FORM, **ASYNC}, distance)

    def options(self):
        return self.dice.choice(({}, {"tolerance": {"absolute": 1e-6}}, {"gate": {"max_distance": 2}},
                                 {"direction": "a_to_b"}))

    def submit_endless(self):
        body = multipart(square(1, 20, self.new_name()), square(1, 23, self.new_name()), {**ENDLESS, "timeout_ms": 300})
        return self.post(body, {**FORM, **ASYNC}, 0, brief=True)

    def submit_with_key(self):
        a, b, distance = self.pair()
        key = self.new_name()
        headers = {**FORM, "Idempotency-Key": key, **self.dice.choice(({}, ASYNC))}
        promise = (headers, multipart(a, b, self.options()), distance, key)
        self.unsure.append(promise)
        del self.unsure[:-20]
        self.post_with_key(promise)

    def post_with_key(self, promise):
        headers, body, distance, key = promise
        self.post(body, headers, distance, key)

    def repeat(self):
        """Repeats a request, as a client that saw no answer does: it must be the same job."""
        if not self.unsure:
            return
        promise = self.dice.choice(self.unsure)
        identity = self.ledger.keys.get(promise[3])
        if identity is None or self.ledger.jobs[identity].state == "accepted":
            self.post_with_key(promise)
            self.ledger.count("repeated")

    def wait_a_little(self):
        a, b, distance = self.pair()
        self.post(multipart(a, b, {}), {**FORM, "Prefer": "wait=1"}, distance)

    def compare_now(self):
        a, b, distance = self.pair()
        self.post(multipart(a, b, self.options()), FORM, distance)

    def store_mesh(self):
        height = self.dice.randrange(64) / 8
        mesh = square(height, self.dice.choice((1, 4, 60)), self.new_name())
        identity = hashlib.sha256(mesh).hexdigest()
        self.ledger.meshes[identity] = "arriving"
        answer = ask(self.port, "PUT", "/v1/meshes/" + identity, mesh, {"Content-Type": "model/obj"})
        if answer.status in (200, 201):
            self.ledger.meshes[identity] = "stored"
            self.own_meshes[identity] = height
            self.ledger.count("meshes")
        elif answer.status not in REFUSED:
            self.ledger.violated("PUT: %d %s" % (answer.status, answer.body[:300]))

    def compare_by_id(self):
        if len(self.own_meshes) < 2:
            return
        a, b = self.dice.choices(list(self.own_meshes), k=2)
        body = json.dumps({"a": a, "b": b, "options": self.options()}).encode()
        self.post(body, {**JSON, **self.dice.choice(({}, ASYNC))}, abs(self.own_meshes[a] - self.own_meshes[b]))

    def delete_mesh(self):
        if not self.own_meshes:
            return
        identity = self.dice.choice(list(self.own_meshes))
        del self.own_meshes[identity]
        self.ledger.meshes[identity] = "removing"
        answer = ask(self.port, "DELETE", "/v1/meshes/" + identity)
        if answer.status == 204:
            self.ledger.meshes[identity] = "deleted"
            self.ledger.count("deleted")
        elif answer.status not in REFUSED:
            self.ledger.violated("DELETE of a mesh: %d %s" % (answer.status, answer.body[:300]))

    def look(self):
        if self.own_jobs:
            identity = self.dice.choice(self.own_jobs)
            job = self.ledger.jobs[identity]
            ended = job.document
            self.ledger.check_answer(identity, job, ask(self.port, "GET", "/v1/comparisons/" + identity), ended)

    def remove_job(self):
        if self.own_jobs:
            self.remove(self.dice.choice(self.own_jobs))

    def remove(self, identity):
        self.own_jobs.remove(identity)
        job = self.ledger.jobs[identity]
        if job.state == "forgotten":
            return
        job.state, ended = "removing", job.document
        answer = ask(self.port, "DELETE", "/v1/comparisons/" + identity)
        if answer.status == 204:
            job.state = "forgotten"
            self.ledger.count("forgotten")
        elif answer.status == 200:
            self.ledger.check_answer(identity, job, answer, ended)
        elif answer.status not in (404, *REFUSED):
            self.ledger.violated("DELETE of a job: %d %s" % (answer.status, answer.body[:300]))


class Crowd:
    """Runs all clients at once, until the service is gone."""

    def __init__(self, clients, port):
        self.over = threading.Event()
        self.failures = []
        self.threads = [threading.Thread(target=self._run, args=(client, port)) for client in clients]
        for thread in self.threads:
            thread.start()

    def _run(self, client, port):
        try:
            while not self.over.is_set():
                client.act(port)
        except Gone:
            pass
        except Exception as error:  # a defect of ours: it must not pass as quiet
            self.failures.append(repr(error))

    def end(self):
        self.over.set()
        for thread in self.threads:
            thread.join()
        assert not self.failures, self.failures


