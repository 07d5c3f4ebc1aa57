#!/usr/bin/env python3
"""Kills the service at random moments while clients use it, starts it again, and checks that it kept its promises.

The moments are random for real: the seed decides what clients do and how long each life lasts, not when their requests
meet. A failing run prints its seed, which is likely to find the same again.
"""

import argparse
import concurrent.futures
import contextlib
import os
import random
import re
import shutil
import sqlite3
import sys
import tempfile
import time
from pathlib import Path

from ledger import ENDED, MAX_TRIES, Ledger, is_given_up
from load import Client, Crowd
from seeds import seed
from victim import ASYNC, ENDLESS, FORM, Victim, ask, multipart, square, until

CLIENTS = 6
LONGEST_LIFE = 0.8
SAMPLE = 25          # of what has ended before, looked at again after each start
AGE_SECONDS = 3600   # older than any blob that is kept for its own sake


class Campaign:
    def __init__(self, seed, folder, verbose):
        self.dice = random.Random(seed)
        self.ledger = Ledger()
        self.data, self.temporary, self.verbose = folder / "data", folder / "tmp", verbose
        self.temporary.mkdir()
        self.clients = [Client(self.ledger, "client%d" % i, self.dice.random()) for i in range(CLIENTS)]

    def start(self):
        self.ledger.lives += 1
        return Victim("--data-dir", str(self.data), "--temp-dir", str(self.temporary), "--workers", "2",
                      "--max-queued-jobs", "200", "--log-requests", "problems")

    def make_database_old(self):
        """A new one that does not know a file may have lost it: sweeps would leave it alone for a day."""
        self.start().stop()
        with contextlib.closing(sqlite3.connect(self.data / "jobs.sqlite")) as database, database:
            database.execute("UPDATE origin SET born = 0")

    def life(self):
        """Runs the service once: checks it while clients use it, until it is killed."""
        victim = self.start()
        crowd = Crowd(self.clients, victim.port)
        try:
            if self.dice.random() < 0.5:  # else it may be killed while it finds its way back
                self.check_some(victim.port)
            time.sleep(self.dice.uniform(0, LONGEST_LIFE))
        finally:
            victim.kill()
            crowd.end()
        self.check_folders()

    def check_some(self, port):
        ledger = self.ledger
        jobs = list(ledger.jobs.items())
        ended = [one for one in jobs if one[1].document]
        waiting = [one for one in jobs if not one[1].document and one[1].state != "forgotten"]
        for identity, job in waiting + self.dice.sample(ended, min(SAMPLE, len(ended))):
            self.check_job(port, identity, job)
        meshes = list(ledger.meshes)
        for identity in self.dice.sample(meshes, min(SAMPLE, len(meshes))):
            self.check_mesh(port, identity)

    def check_job(self, port, identity, job):
        known, ended = job.state, job.document  # before the answer: it may end or be removed meanwhile
        answer = ask(port, "GET", "/v1/comparisons/" + identity)
        if known == job.state:
            self.ledger.check_answer(identity, job, answer, ended)

    def check_mesh(self, port, identity):
        known = self.ledger.meshes[identity]
        answer = ask(port, "GET", "/v1/meshes/" + identity)
        if known != self.ledger.meshes[identity] or known not in ("stored", "deleted"):
            return
        if (answer.status, known) not in ((200, "stored"), (404, "deleted")):
            self.ledger.violated("the mesh %s, %s: %d" % (identity, known, answer.status))

    def check_folders(self):
        """Checks the folders between two runs, and makes unused files old, so that the next run must remove them."""
        if list(self.temporary.iterdir()):
            self.ledger.violated("left behind: %s" % list(self.temporary.iterdir()))
        arriving = list((self.data / "blobs" / "incoming").glob("*"))
        if len(arriving) > 2 * CLIENTS + 2:  # of this life alone: the next one removes them
            self.ledger.violated("temporary files pile up: %d" % len(arriving))
        past = time.time() - AGE_SECONDS
        for blob in self.blobs():
            os.utime(blob, (past, past))

    def blobs(self):
        return [path for path in (self.data / "blobs").rglob("*") if re.fullmatch("[0-9a-f]{64}", path.name) and path.is_file()]

    def finish(self):
        """Waits for every promised result, and checks it for the last time."""
        victim = self.start()
        for identity, job in self.ledger.jobs.items():
            until(lambda: self.has_ended(victim.port, identity, job), 300)
        for identity, job in self.ledger.jobs.items():
            self.check_job(victim.port, identity, job)
        for identity in self.ledger.meshes:
            self.check_mesh(victim.port, identity)
        self.compare_all_meshes(victim.port)
        victim.stop()
        self.check_folders()

    def has_ended(self, port, identity, job):
        answer = ask(port, "GET", "/v1/comparisons/" + identity)
        return answer.status != 200 or answer.json()["state"] in ENDED

    def compare_all_meshes(self, port):
        """Reads the stored meshes: the service reports when their bytes do not match their digests."""
        stored = [identity for identity, state in self.ledger.meshes.items() if state == "stored"]
        for a, b in zip(stored[::2], stored[1::2]):
            body = ('{"a": "%s", "b": "%s"}' % (a, b)).encode()
            answer = ask(port, "POST", "/v1/comparisons", body, {"Content-Type": "application/json"})
            meshes = answer.json().get("meshes", {})
            if answer.status != 200 or (meshes["a"]["sha256"], meshes["b"]["sha256"]) != (a, b):
                self.ledger.violated("the bytes of %s or %s: %d %s" % (a, b, answer.status, answer.body[:300]))

    def tidy_up(self):
        """Deletes everything, and checks that no file is left."""
        victim = self.start()
        paths = ["/v1/comparisons/" + one for one, job in self.ledger.jobs.items() if job.state != "forgotten"]
        paths += ["/v1/meshes/" + one for one in self.ledger.meshes]
        with concurrent.futures.ThreadPoolExecutor(CLIENTS) as pool:
            list(pool.map(lambda path: ask(victim.port, "DELETE", path), paths))
        victim.stop()
        self.check_folders()
        victim = self.start()
        try:
            until(lambda: not self.blobs(), 60)
        except AssertionError:
            self.ledger.violated("blobs that belong to no mesh stay: %d" % len(self.blobs()))
        victim.stop()
        log = self.data / "jobs.sqlite-wal"
        if log.exists() and log.stat().st_size > 128 << 20:
            self.ledger.violated("the log of the database has %d bytes" % log.stat().st_size)

    def poison(self):
        """A job whose every try kills the service fails as given up."""
        victim = self.start()
        body = multipart(square(0, 40), square(0, 43), {**ENDLESS, "timeout_ms": 100000})
        path = ask(victim.port, "POST", "/v1/comparisons", body, {**FORM, **ASYNC}).headers["location"]
        for tries in range(1, MAX_TRIES + 1):
            until(lambda: self.is_running(victim.port, path, tries), 60)
            victim.kill()
            victim = self.start()
        document = ask(victim.port, "GET", path).json()
        if not is_given_up(document):
            self.ledger.violated("the poison is not given up: %s" % document)
        self.ledger.count("given up")
        victim.stop()

    @staticmethod
    def is_running(port, path, tries):
        document = ask(port, "GET", path).json()
        return document["state"] == "running" and document["tries"] == tries


def run(kills, seed, verbose, short):
    folder = Path(tempfile.mkdtemp(prefix="meshgauge-chaos-"))
    campaign = Campaign(seed, folder, verbose)
    began = time.monotonic()
    try:
        campaign.make_database_old()
        for number in range(1, kills + 1):
            campaign.life()
            if verbose and number % 10 == 0:
                print("%4d kills, %d jobs, %d violations" % (number, len(campaign.ledger.jobs), len(campaign.ledger.violations)),
                      flush=True)
        campaign.finish()
        if not short:
            campaign.poison()
        campaign.tidy_up()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    ledger = campaign.ledger
    for text in ledger.violations[:20]:
        print("VIOLATION: " + text)
    print("chaos: seed %d, %d kills in %.0f s, %d jobs promised, %s; violations: %d" % (
        seed, kills, time.monotonic() - began, len(ledger.jobs),
        ", ".join("%s %d" % one for one in sorted(ledger.counts.items())), len(ledger.violations)))
    return 1 if ledger.violations or not ledger.jobs else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=seed, default=random.SystemRandom().randrange(1 << 30), help="`today`: the date")
    parser.add_argument("--quiet", action="store_true", help="only the last line")
    parser.add_argument("--short", action="store_true", help="without the job that kills its service")
    arguments = parser.parse_args()
    print("seed %d" % arguments.seed, flush=True)
    sys.exit(run(arguments.kills, arguments.seed, not arguments.quiet, arguments.short))


if __name__ == "__main__":
    main()
