#!/usr/bin/env python3
"""Fails each call that the service makes of the system, one after the other, while clients use it, and checks that it
lives on, keeps what it promised, and gives no wrong answer (docs/testing.md).

A point is a place in the program from which a call is made (faults.cpp). The load is run until it finds no new points;
then each point fails once, and from then on until it is well again; a point that was not reached then is tried in a life
of its own, in walk after walk until the sweeps have come, and counted when it never was. Then the n-th call of each kind
fails, wherever it is.
"""

import argparse
import collections
import contextlib
import ctypes
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

import load
import victim
from seeds import seed
from shim import KINDS, SHIM, Faults, Maps
from victim import Gone, Victim, ask, until
from walk import HONEST, HonestLedger, User

NO_RANDOM_ADDRESSES = 0x0040000
ANSWER_SECONDS = 20
SHORT_SECONDS = 3  # while calls fail: the service waits for memory, too
TRIES = 4  # to reach a point
LIVES = 3  # for a point that is rarely reached
CUT_CONNECTIONS = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE backend_type = 'client backend' " \
                  "AND pid <> pg_backend_pid()"


class Campaign:
    """`database`: a PostgreSQL of a front end and a worker, of which `fails` is the one whose calls fail; else one service does all."""

    def __init__(self, folder, seed, patience, verbose, database=None, fails="serve"):
        self.database, self.fails, self.patience = database, fails, patience
        self.folder, self.verbose, self.dice = folder, verbose, random.Random(seed)
        (folder / "tmp").mkdir()
        self.faults = Faults(folder / "faults")
        self.ledger = HonestLedger()
        self.user = User(self.ledger, seed)
        self.deaths, self.chosen, self.reached, self.unreached, self.silent = [], [], set(), set(), 0
        self.promised = self.quiet_faults = 0
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
        self.maps = Maps(self.server.process.pid)
        self.faults.watch(self.server.process.pid)

    def stack(self):
        """The functions of ours and of libraries in which the service died, the innermost first."""
        frames = re.findall(r"^(\S+)\((?:[^)+]*)\+?(0x[0-9a-f]+)?\) ?\[(0x[0-9a-f]+)\]", "".join(self.server.log), re.M)
        return [self.maps.name_of(int(address, 16)) + "\n" for path, offset, address in frames]

    def discover(self):
        """Runs the load until it finds no new points, and all sweeps have come: self.seen."""
        known, quiet, end = 0, 0, time.monotonic() + self.patience
        while quiet < 3 or time.monotonic() < end:
            self.user.walk(self.port)
            self.settle()
            found = len(self.faults.points())
            quiet = 0 if found > known else quiet + 1
            known = found
        self.seen = self.faults.points()

    def settle(self):
        """Waits until the service is well again, and checks every promise of the last steps."""
        if self.other and self.other.process.poll() is not None:
            self.ledger.violated("the other process ended, after %s: %s" % (self.newest_failure(), "".join(self.other.log[-20:])))
            sys.exit("there is no service without it")
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

    def strike(self, kind, lasting, after=0, place=0, patience=0):
        """One failure, or many from one on, in one walk or until some are reached, for `patience` seconds; returns how many
        there were."""
        lines, refusals = self.server.lines, self.refusals()
        self.newest = kind, lasting, after, place
        self.faults.fail(kind, lasting, after, place)
        victim.ANSWER_SECONDS = SHORT_SECONDS
        end, walks = time.monotonic() + patience, 0
        while walks == 0 or not (self.faults.failed() or time.monotonic() > end or self.server.process.poll() is not None):
            if self.database and (kind == "connect" or walks % 2 == 1):  # much is called for new connections alone
                self.database.query(CUT_CONNECTIONS)
            self.silent += self.user.walk(self.port, 1 if kind == "allocation" else 2)
            walks += 1
        victim.ANSWER_SECONDS = ANSWER_SECONDS
        self.faults.lift()
        failed = self.faults.failed()
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
        return "%s %s %s" % (kind, "lasting" if lasting else "once", self.maps.name_of(place) if place else "call %d" % after)

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
                    number + 1, len(self.deaths), len(self.ledger.violations), self.maps.name_of(place)), flush=True)

    def fail_rare_points(self, points):
        """Fails each point in lives of its own: the first requests of a life fill tables that last, and its first second
        sweeps all. All lives but the first begin with an empty store: tables of what it holds grow by steps."""
        for number, (kind, place) in enumerate(points):
            for lasting in (False, True):
                hits = 0
                for life in range(LIVES):
                    if not hits:
                        self.restart(anew=life > 0)
                        hits = self.strike(kind, lasting, place=place, patience=self.patience)
                (self.reached if hits else self.unreached).add((kind, place))
                if self.verbose:
                    print("%5d of %d alone, %s, %s: %d" % (number + 1, len(points), kind, self.maps.name_of(place), hits), flush=True)

    def fail_calls(self, kind, most):
        """Fails the n-th call of a kind, for each n, until the load makes no more."""
        for after in range(most):
            if not self.strike(kind, False, after=after):
                break
            self.strike(kind, True, after=after)

    def restart(self, anew=False):
        """`anew`: on an empty data directory, after a look at all that the old one promises."""
        if anew and not self.database:
            self.check_promises()
            self.promised += len(self.ledger.jobs)
            self.ledger.jobs, self.ledger.meshes, self.ledger.keys, self.user = {}, {}, {}, User(self.ledger, self.dice.random())
        try:
            self.server.stop()
        except AssertionError:
            return self.bury()
        except subprocess.TimeoutExpired:
            self.ledger.violated("it does not end, after " + self.newest_failure())
            self.server.kill()
        if anew:
            shutil.rmtree(self.folder / ("data-" + self.fails))
        self.start()

    def check_all(self):
        """Every promise of the whole campaign, after a restart."""
        self.restart()
        self.check_promises()
        self.restart()

    def check_promises(self):
        for identity, job in self.ledger.jobs.items():
            if job.state == "accepted" and not job.document:
                try:
                    until(lambda: self.has_ended(identity, job), 60)
                except AssertionError:
                    self.ledger.violated("it never ends: the job " + identity)
        for identity, state in self.ledger.meshes.items():
            self.check_mesh(identity, state)

    def attack(self, arguments):
        """Everything: the points chosen, those that were not reached alone, the n-th calls."""
        part, parts = arguments.part
        self.discover()
        if arguments.only:
            named = re.findall(r"^not reached: (\w+) (\S+)\+([0-9a-f]+) ", Path(arguments.only).read_text(), re.M)
            places = ((kind, self.maps.place_of(name, int(offset, 16))) for kind, name, offset in named)
            self.chosen = sorted({(kind, place) for kind, place in places if place and place % parts == part})
            return self.fail_rare_points(self.chosen)
        kinds = arguments.kinds or KINDS
        seen = [(kind, place) for kind, place in sorted(self.seen) if kind in kinds and place % parts == part]
        self.dice.shuffle(seen)
        for kind in kinds:
            self.chosen += [one for one in seen if one[0] == kind][:arguments.points]
        self.fail_points(self.chosen)
        self.fail_rare_points(sorted(self.unreached - self.reached))
        for kind in kinds[part::parts]:
            self.fail_calls(kind, arguments.calls)

    def close(self):
        for process in (self.server, self.other):
            if process:
                process.process.kill()
                process.process.wait()


def report(campaign, began):
    by_kind = collections.Counter(kind for kind, place in campaign.chosen)
    missed = campaign.unreached - campaign.reached
    for kind, place in sorted(missed):
        print("not reached: %s %s" % (kind, campaign.maps.name_of(place)))
    for text in campaign.ledger.violations[:20]:
        print("VIOLATION: " + text)
    print("faults: %d points (%s), %d reached, %d not; %d jobs promised, %s; %d requests without an answer, %d failures without "
          "a word; deaths: %d, violations: %d; %.0f s" % (
              len(campaign.chosen), ", ".join("%s %d" % one for one in sorted(by_kind.items())), len(campaign.reached), len(missed),
              campaign.promised + len(campaign.ledger.jobs), ", ".join("%s %d" % one for one in sorted(campaign.ledger.counts.items())),
              campaign.silent, campaign.quiet_faults, len(campaign.deaths), len(campaign.ledger.violations),
              time.monotonic() - began))
    return 1 if campaign.deaths or campaign.ledger.violations or not campaign.promised + len(campaign.ledger.jobs) else 0


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
    began, campaign = time.monotonic(), None
    try:
        campaign = Campaign(folder, arguments.seed, arguments.patience, not arguments.quiet, database, arguments.fails)
        campaign.attack(arguments)
        campaign.check_all()
        return report(campaign, began)
    except BaseException:  # of a signal, too: the report is what it has seen until then
        traceback.print_exc(file=sys.stdout)
        if campaign:
            report(campaign, began)
        print("ENDED EARLY", flush=True)
        return 1
    finally:
        if campaign:
            campaign.close()
        shutil.rmtree(folder, ignore_errors=True)


def part_of(text):
    """K/N as (K - 1, N)."""
    part, parts = (int(one) for one in text.split("/"))
    if not 1 <= part <= parts:
        raise ValueError
    return part - 1, parts


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seed", type=seed, default=random.SystemRandom().randrange(1 << 30), help="`today`: the date")
    parser.add_argument("--points", type=int, help="only so many places of each kind, drawn by the seed")
    parser.add_argument("--calls", type=int, default=200, help="the n-th call of a kind, up to this n")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, help="only these kinds of calls")
    parser.add_argument("--part", type=part_of, default=(0, 1), metavar="K/N", help="the K-th of N parts, which may run beside each other")
    parser.add_argument("--only", metavar="LOG", help="only the places not reached of an earlier log of this build")
    parser.add_argument("--patience", type=float, default=40, help="seconds for a place that is rarely reached; sweeps come each 30 s")
    parser.add_argument("--distributed", action="store_true", help="a front end and a worker on a PostgreSQL")
    parser.add_argument("--fails", choices=("serve", "worker"), default="serve", help="of these two, whose calls fail")
    parser.add_argument("--quiet", action="store_true", help="only what fails, and the last line")
    arguments = parser.parse_args()
    for one in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(one, lambda number, frame: sys.exit("signal %d" % number))
    print("seed %d" % arguments.seed, flush=True)
    with database_of(arguments) as database:
        sys.exit(run(arguments, database))


if __name__ == "__main__":
    main()
