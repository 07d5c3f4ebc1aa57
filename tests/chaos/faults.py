#!/usr/bin/env python3
"""Fails each call that the service makes of the system, one after the other, while clients use it, and checks that it
lives on, keeps what it promised, and gives no wrong answer (docs/testing.md).

A point is a place in the program from which a call is made (faults.cpp). The load is run until it finds no new points;
then each point fails once, and from then on until it is well again; a point that was not reached then is tried in a life
of its own, and counted when it never was. Then the n-th call of each kind fails, wherever it is.
"""

import argparse
import collections
import contextlib
import ctypes
import errno
import json
import mmap
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import load
import victim
from ledger import Ledger
from load import Client
from victim import FORM, Gone, Victim, ask, multipart, square, until

SHIM = os.environ.get("MESHGAUGE_FAULTS_LIBRARY", str(victim.ROOT / "build/tests/chaos/libfaults.so"))
KINDS = ("read", "write", "sync", "map", "rename", "allocation", "thread", "connect")
ERRORS = {"read": errno.EIO, "write": errno.ENOSPC, "sync": errno.EIO, "map": errno.ENOMEM, "rename": errno.EIO,
          "allocation": errno.ENOMEM, "thread": errno.EAGAIN, "connect": errno.ECONNREFUSED}
ORDERS = struct.Struct("iiiiqQq8q")
SITE = struct.Struct("QiiQ")
SITES = 1 << 14
NO_RANDOM_ADDRESSES = 0x0040000
HONEST = (429, 500, 503, 507)
ANSWER_SECONDS = 20
SHORT_SECONDS = 3  # while calls fail: the service waits for memory, too
TRIES = 4  # to reach a point


class Faults:
    """The orders to the shim, and what it counts."""

    def __init__(self, path):
        path.write_bytes(bytes(ORDERS.size + SITES * SITE.size))
        with open(path, "r+b") as file:
            self.table = mmap.mmap(file.fileno(), 0)
        self.path = path
        self.process = 0

    def _write(self, kind, error=0, lasting=0, after=0, place=0):
        struct.pack_into("i", self.table, 4, -1)  # first: the others belong together
        struct.pack_into("iiqQq", self.table, 8, error, lasting, after, place, 0)
        struct.pack_into("i", self.table, 0, self.process)
        struct.pack_into("i", self.table, 4, kind)

    def watch(self, process):
        self.process = process
        self._write(-1)

    def fail(self, kind, lasting, after=0, place=0):
        self._write(KINDS.index(kind), ERRORS[kind], int(lasting), after, place)

    def lift(self):
        """Ends the failures; returns how many there were."""
        struct.pack_into("i", self.table, 4, -1)
        return ORDERS.unpack_from(self.table)[6]

    def calls(self):
        return dict(zip(KINDS, ORDERS.unpack_from(self.table)[7:]))

    def points(self):
        """The places seen so far: (kind, place) to calls."""
        sites = (SITE.unpack_from(self.table, ORDERS.size + i * SITE.size) for i in range(SITES))
        return {(KINDS[kind], place): calls for place, kind, failed, calls in sites if place}


CUT_CONNECTIONS = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE backend_type = 'client backend' " \
                  "AND pid <> pg_backend_pid()"
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
        if document["state"] == "failed" and document["problem"]["type"].rsplit(":", 1)[1] in ("internal", "storage-unavailable"):
            self.count("failed honestly")
            return True
        return super()._may_end(job, document)


class User(Client):
    """Does everything once, in the same order each time."""

    def __init__(self, ledger, seed):
        super().__init__(ledger, "user", seed)
        self.last_result = None

    def walk(self, port, most_silent=2):
        """Returns how many requests had no answer. Ends after so many: the rest would only wait as long."""
        self.port = port
        silent = 0
        for act in (self.store_mesh, self.store_mesh, self.submit, self.submit_with_key, self.repeat, self.compare_now,
                    self.compare_large, self.compare_by_id, self.map_of_last, self.batch, self.wait_a_little, self.look,
                    self.ready, self.remove_job, self.delete_mesh):
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


class Campaign:
    """`database`: a PostgreSQL of a front end and a worker, of which `fails` is the one whose calls fail; else one service does all."""

    def __init__(self, folder, seed, verbose, database=None, fails="serve"):
        self.database, self.fails = database, fails
        self.folder, self.verbose, self.dice = folder, verbose, random.Random(seed)
        (folder / "tmp").mkdir()
        self.faults = Faults(folder / "faults")
        self.ledger = HonestLedger()
        self.user = User(self.ledger, seed)
        self.deaths, self.reached, self.unreached, self.silent = [], set(), set(), 0
        self.quiet_faults = 0
        self.newest = self.waits_for = None
        self.server = self.other = None
        if database:
            self.other = self.run({"serve": "worker", "worker": "serve"}[fails])
        self.start()

    def run(self, command):
        store = ("--database", self.database.url(), "--lease-ms", "4000", "--heartbeat-ms", "500") if self.database else ()
        return Victim("--data-dir", str(self.folder / ("data-" + command)), "--temp-dir", str(self.folder / "tmp"), *store,
                      "--workers", "2", "--max-cache-bytes", "1000000", "--grace-ms", "2000", "--log-requests", "none", command=command)

    def start(self):
        victim.ENVIRONMENT.update(LD_PRELOAD=SHIM, MESHGAUGE_FAULTS=str(self.faults.path))
        self.ledger.lives += 1
        self.server = self.run(self.fails)
        self.port = (self.other if self.fails == "worker" else self.server).port
        [victim.ENVIRONMENT.pop(name) for name in ("LD_PRELOAD", "MESHGAUGE_FAULTS")]
        self.maps = Path("/proc/%d/maps" % self.server.process.pid).read_text()
        self.faults.watch(self.server.process.pid)

    def name_of(self, place):
        """The function of a place."""
        for line in self.maps.splitlines():
            fields = line.split()
            begin, end = (int(one, 16) for one in fields[0].split("-"))
            if begin <= place < end and len(fields) > 5:
                offset = place - begin + int(fields[2], 16)
                names = subprocess.run(["addr2line", "-Cfpie", fields[5], hex(offset - 1)], capture_output=True, text=True)
                return "%s+%x %s" % (Path(fields[5]).name, offset, names.stdout.splitlines()[0][:160] if names.stdout else "")
        return hex(place)

    def stack(self):
        """The functions of ours and of libraries in which the service died, the innermost first."""
        frames = re.findall(r"^(\S+)\((?:[^)+]*)\+?(0x[0-9a-f]+)?\) ?\[(0x[0-9a-f]+)\]", "".join(self.server.log), re.M)
        return [self.name_of(int(address, 16)) + "\n" for path, offset, address in frames]

    def discover(self):
        """Runs the load until it finds no new points: self.seen."""
        known, quiet = 0, 0
        while quiet < 3:
            self.user.walk(self.port)
            self.settle()
            found = len(self.faults.points())
            quiet = 0 if found > known else quiet + 1
            known = found
        self.seen = self.faults.points()

    def settle(self):
        """Waits until the service is well again, and checks every promise of the last steps."""
        port, self.waits_for = self.port, "readiness"
        try:
            until(lambda: ask(port, "GET", "/readyz").status == 200, 30)
            for identity, job in list(self.ledger.jobs.items())[-12:]:
                if job.state == "accepted":
                    self.waits_for = "the job " + identity
                    until(lambda: self.has_ended(identity, job), 30)
            for identity, state in list(self.ledger.meshes.items())[-6:]:
                self.check_mesh(identity, state)
        except AssertionError:
            self.ledger.violated("it does not recover from %s: %s\n%s" % (self.newest_failure(), self.waits_for, "".join(self.server.log[-5:])))
        except Gone:
            if self.server.process.poll() is None:
                self.ledger.violated("no answer though nothing fails, after %s: %s" % (self.newest_failure(), "".join(self.server.log[-5:])))

    def has_ended(self, identity, job):
        answer = ask(self.port, "GET", "/v1/comparisons/" + identity)
        self.ledger.check_answer(identity, job, answer, job.document)
        return answer.status == 404 or job.document is not None

    def check_mesh(self, identity, state):
        answer = ask(self.port, "GET", "/v1/meshes/" + identity)
        if (state, answer.status) in (("stored", 404), ("deleted", 200)):
            self.ledger.violated("the mesh %s, %s: %d" % (identity, state, answer.status))

    def strike(self, kind, lasting, after=0, place=0):
        """One failure, or many from one on, under the load; returns how many there were."""
        lines, refusals = self.server.lines, self.refusals()
        self.newest = kind, lasting, after, place
        self.faults.fail(kind, lasting, after, place)
        if kind == "connect" and self.database:
            self.database.query(CUT_CONNECTIONS)
        victim.ANSWER_SECONDS = SHORT_SECONDS
        self.silent += self.user.walk(self.port, 1 if kind == "allocation" else 2)
        victim.ANSWER_SECONDS = ANSWER_SECONDS
        failed = self.faults.lift()
        if failed and self.refusals() == refusals and self.server.lines == lines:
            self.quiet_faults += 1
        if self.server.process.poll() is None:
            self.settle()
        if self.server.process.poll() is not None:
            self.bury()
        return failed

    def refusals(self):
        return sum(self.ledger.counts.get(name, 0) for name in ("refused", "honest", "failed honestly"))

    def newest_failure(self):
        if not self.newest:
            return "nothing"
        kind, lasting, after, place = self.newest
        return "%s %s %s" % (kind, "lasting" if lasting else "once", self.name_of(place) if place else "call %d" % after)

    def bury(self):
        self.server.reader.join()
        log = "".join(self.stack())
        self.deaths.append("%s: exit %s\n%s" % (self.newest_failure(), self.server.process.returncode, log))
        print("DEATH: " + self.deaths[-1], flush=True)
        self.start()
        self.settle()

    def fail_points(self, points):
        """Fails each point once, and from then on."""
        for number, (kind, place) in enumerate(points):
            for lasting in (False, True):
                hits = any(self.strike(kind, lasting, place=place) for _ in range(TRIES))
                (self.reached if hits else self.unreached).add((kind, place))
            if self.verbose and (number % 50 == 49 or kind != "allocation"):
                print("%5d points, %d deaths, %d violations, %s" % (
                    number + 1, len(self.deaths), len(self.ledger.violations), self.name_of(place)), flush=True)

    def fail_first_calls(self):
        """Fails each point that was not reached in a life of its own: the first requests of a life fill tables that last."""
        for kind, place in sorted(self.unreached - self.reached):
            for lasting in (False, True):
                self.restart()
                if self.strike(kind, lasting, place=place):
                    self.reached.add((kind, place))

    def fail_calls(self, kind, most):
        """Fails the n-th call of a kind, for each n, until the load makes no more."""
        for after in range(most):
            if not self.strike(kind, False, after=after):
                break
            self.strike(kind, True, after=after)

    def restart(self):
        self.server.stop()
        self.start()

    def check_all(self):
        """Every promise of the whole campaign, after a restart."""
        self.restart()
        for identity, job in self.ledger.jobs.items():
            if job.state == "accepted" and not job.document:
                until(lambda: self.has_ended(identity, job), 60)
        for identity, state in self.ledger.meshes.items():
            self.check_mesh(identity, state)
        self.server.stop()
        if self.other:
            self.other.stop()


def report(campaign, began, seen):
    by_kind = collections.Counter(kind for kind, place in seen)
    missed = campaign.unreached - campaign.reached
    for kind, place in sorted(missed)[:20]:
        print("not reached: %s %s" % (kind, campaign.name_of(place)))
    for text in campaign.ledger.violations[:20]:
        print("VIOLATION: " + text)
    print("faults: %d points (%s), %d reached, %d not; %d jobs promised, %s; %d requests without an answer, %d failures without "
          "a word; deaths: %d, violations: %d; %.0f s" % (
              len(seen), ", ".join("%s %d" % one for one in sorted(by_kind.items())), len(campaign.reached), len(missed),
              len(campaign.ledger.jobs), ", ".join("%s %d" % one for one in sorted(campaign.ledger.counts.items())),
              campaign.silent, campaign.quiet_faults, len(campaign.deaths), len(campaign.ledger.violations),
              time.monotonic() - began))
    return 1 if campaign.deaths or campaign.ledger.violations or not campaign.ledger.jobs else 0


@contextlib.contextmanager
def database_of(arguments):
    """A PostgreSQL of its own; None: not asked for."""
    if not arguments.distributed:
        yield None
        return
    sys.path.append(str(victim.ROOT / "tests/cluster"))
    import postgres  # pylint: disable=import-outside-toplevel
    server = postgres.Postgres()
    try:
        yield server
    finally:
        server.close()


def run(arguments, database):
    victim.ANSWER_SECONDS = ANSWER_SECONDS
    load.REFUSED = HONEST
    ctypes.CDLL(None).personality(ctypes.c_ulong(NO_RANDOM_ADDRESSES))
    folder = Path(tempfile.mkdtemp(prefix="meshgauge-faults-"))
    began = time.monotonic()
    try:
        campaign = Campaign(folder, arguments.seed, not arguments.quiet, database, arguments.fails)
        campaign.discover()
        seen = [one for one in sorted(campaign.seen) if not arguments.kinds or one[0] in arguments.kinds]
        campaign.dice.shuffle(seen)
        few = [one for one in seen if one[0] != "allocation"]
        allocations = [one for one in seen if one[0] == "allocation"]
        chosen = few + (allocations if arguments.points is None else allocations[:arguments.points])
        campaign.fail_points(chosen)
        campaign.fail_first_calls()
        for kind in arguments.kinds or KINDS:
            campaign.fail_calls(kind, arguments.calls)
        campaign.check_all()
        return report(campaign, began, chosen)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 30))
    parser.add_argument("--points", type=int, help="only so many of the places that allocate, drawn by the seed")
    parser.add_argument("--calls", type=int, default=200, help="the n-th call of a kind, up to this n")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, help="only these kinds of calls")
    parser.add_argument("--distributed", action="store_true", help="a front end and a worker on a PostgreSQL")
    parser.add_argument("--fails", choices=("serve", "worker"), default="serve", help="of these two, whose calls fail")
    parser.add_argument("--quiet", action="store_true", help="only what fails, and the last line")
    arguments = parser.parse_args()
    print("seed %d" % arguments.seed, flush=True)
    with database_of(arguments) as database:
        sys.exit(run(arguments, database))


if __name__ == "__main__":
    main()
