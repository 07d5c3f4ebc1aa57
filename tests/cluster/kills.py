#!/usr/bin/env python3
"""Kills workers, front ends and the leader of the database at random moments while clients submit, and checks what was promised.

The moments are random for real: the seed decides what is asked for and which processes are killed in which order, not when their requests meet. A
failing run prints its seed, which is likely to find the same again.
"""

import argparse
import concurrent.futures
import random
import sys
import threading
import time

import psycopg2

from crowd import Crowd, works
from fixture import pairs
from patroni import Cluster, Node
from postgres import or_skip
from processes import Fleet, migrate, until
from promises import SECOND_RESULTS, Gaps, Ledger, longest_stall
from scratch import inside
from sweeps import Sweeper, sweeps

FLAGS = ("--lease-ms", "5000", "--heartbeat-ms", "1000", "--max-queued-jobs", "1000", "--log-requests", "problems")
STALL_SECONDS = 5     # beyond the time in which the database takes no writes
ENDED_STATES = "(2, 3, 4)"
BATCHED = 5           # one of so many comparisons comes with a batch
MOST_IN_BATCH = 50

PULSE = """
CREATE TABLE pulse (n bigint);
INSERT INTO pulse VALUES (0);
"""


def comes_true(condition, seconds=10):
    """Whether it holds within a moment: killed processes may take one to be gone on a busy machine."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


class Pulse:
    """Writes to the database all the time, and counts jobs: when it could not, and when none ended though some were queued."""

    def __init__(self, url):
        self.url = url
        self.writes, self.ends, self.over, self.ended = Gaps(), Gaps(), threading.Event(), -1
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self):
        while not self.over.is_set():
            try:
                with psycopg2.connect(self.url) as connection:
                    connection.autocommit = True
                    self._beat(connection.cursor())
            except psycopg2.Error:
                time.sleep(0.05)

    def _beat(self, cursor):
        while not self.over.is_set():
            cursor.execute("UPDATE pulse SET n = n + 1")
            self.writes.mark()
            cursor.execute("SELECT count(*) FILTER (WHERE state IN %s), count(*) FILTER (WHERE state = 0) FROM jobs" % ENDED_STATES)
            ended, queued = cursor.fetchone()
            if ended != self.ended or not queued:
                self.ended = ended
                self.ends.mark()
            time.sleep(0.05)

    def end(self):
        self.over.set()
        self.thread.join(60)


class Campaign:
    def __init__(self, cluster, kills, jobs, seed):
        self.cluster, self.kills, self.dice, self.killed = cluster, kills, random.Random(seed), {}
        self.ledger, self.returns = Ledger(), []
        url = cluster.url()
        migrate(url)
        cluster.ask(SECOND_RESULTS + PULSE)
        self.fleet = Fleet(cluster.scratch, url, FLAGS)
        for _ in range(2):
            self.fleet.add_front_end()
        for _ in range(3):
            self.fleet.add_worker("--workers", "2")
        self.fleet.wait()
        self.back = set(self.fleet.all())  # processes that run, and that no other thread will start
        known = pairs(cluster.scratch.path)
        size = min(MOST_IN_BATCH, jobs // BATCHED)
        batches = jobs // BATCHED // size if size else 0
        plan = list(works(self.dice, known, jobs - batches * size))
        self.crowd = Crowd(self.ledger, [one.port for one in self.fleet.front_ends], plan, seed)
        self.sweeper = Sweeper(self.crowd, list(sweeps(self.dice, known, batches, size, seed)), seed)
        self.pool = concurrent.futures.ThreadPoolExecutor(8)
        self.pulse = Pulse(url)

    def run(self):
        jobs, began = len(self.crowd.works), time.monotonic()
        self.crowd.start()
        self.sweeper.start()
        victims = [("leader", "worker", "front end")[i % 3] for i in range(self.kills)]
        self.dice.shuffle(victims)
        for number, victim in enumerate(victims, 1):
            self.crowd.may = jobs * (number + 1) // (self.kills + 1)  # so many that some wait while a process is dead
            due = jobs * (number - 1) // (self.kills + 1)
            until(lambda: self.crowd.taken >= due, 600, "%d works to be begun" % due)
            time.sleep(self.dice.uniform(0, 2))
            self.kill(victim)
            print("%4.0f s: %d kills (%s), %d jobs accepted singly, %d wait, %d violations" % (
                time.monotonic() - began, number, victim, len(self.ledger.accepted), len(self.ledger.waiting), len(self.ledger.violations)), flush=True)
        self.crowd.may = jobs
        until(lambda: self.crowd.taken == jobs, 600, "all works to be begun")
        for back in self.returns:
            back.result()
        until(lambda: not self.ledger.waiting and self.is_promised(), 600, "%s" % self.ledger.waiting)
        until(lambda: not self.sweeper.waiting() or self.ledger.violations or self.crowd.failures, 600, "the batches' ends")

    def is_promised(self):
        """Whether no client still tries to submit."""
        return self.ledger.counts.get("plain", 0) + len(self.ledger.accepted) >= len(self.crowd.works) or self.ledger.violations

    def kill(self, kind):
        if kind == "leader":
            self.cluster.wait_whole()  # two dead of three is more than the cluster promises to survive
            victim = until(self.cluster.leader)
        else:
            kin = self.fleet.workers if kind == "worker" else self.fleet.front_ends
            victim = self.dice.choice(until(lambda: [one for one in kin if one in self.back], what="a %s that is back" % kind))
            self.back.remove(victim)
        victim.kill()
        self.killed[kind] = self.killed.get(kind, 0) + 1
        self.returns.append(self.pool.submit(self._bring_back, victim, self.dice.uniform(0.2, 3)))

    def _bring_back(self, victim, seconds):
        time.sleep(seconds)
        try:
            (victim.start if isinstance(victim, Node) else victim.start_again)()
            self.back.add(victim)
        except AssertionError as error:
            self.ledger.violated("%s does not come back: %s" % (victim.name, error))

    def look_again(self):
        """Checks everything at both front ends, when nothing runs any more."""
        self.fleet.wait()
        self.cluster.wait_whole()
        self.crowd.end()
        self.sweeper.end()
        self.pulse.end()
        for identity, work in self.ledger.accepted.items():
            for front_end in self.fleet.front_ends:
                self.ledger.check(identity, True, front_end.ask("GET", "/v1/comparisons/" + identity))
        known = self.sweeper.look_again(self.fleet.front_ends)
        kept = set(self.cluster.ask("SELECT convert_from(id, 'UTF8') FROM jobs WHERE batch <> ''").split())
        if known != kept:
            self.ledger.violated("comparisons that are no batch's, or are not there: %s" % (known ^ kept))
        found = self.cluster.ask("SELECT * FROM second_results")
        if found:
            self.ledger.violated("second results: " + found)
        rows = self.cluster.ask("SELECT count(*) FROM jobs WHERE state NOT IN " + ENDED_STATES)
        if rows != "0":
            self.ledger.violated("%s jobs that have not ended" % rows)
        self.check_times()
        for one in self.fleet.all():
            one.stop()
            if not comes_true(lambda one=one: not inside(one.folder)):
                self.ledger.violated("%s left processes behind" % one.name)
            if list((one.folder / "tmp").iterdir()):
                self.ledger.violated("%s left files behind: %s" % (one.name, list((one.folder / "tmp").iterdir())))

    def check_times(self):
        self.outages = [gap for gap in self.pulse.writes.found if gap[1] - gap[0] > 1]
        self.stalls = {"finishes": longest_stall(self.pulse.ends.found, self.outages),
                       "answers": longest_stall(self.ledger.answered.found, self.outages)}
        for what, seconds in self.stalls.items():
            if seconds > STALL_SECONDS:
                self.ledger.violated("no %s for %.1f s beyond the database's own" % (what, seconds))

    def figures(self, seconds):
        longest = max((end - start for start, end in self.outages), default=0)
        of_batches = sum(len(sweep.works) for sweep in self.sweeper.accepted())
        wanted = len(self.crowd.works) + of_batches  # look_again() found all of them, except the cancelled ones
        return ("%d jobs in %.0f s, of them %d accepted singly and %d in batches, %s killed; %s; "
                "database away %d times, %.1f s at most; stalls beyond that: %s") % (
            wanted, seconds, len(self.ledger.accepted), of_batches, ", ".join("%d %ss" % (n, kind) for kind, n in sorted(self.killed.items())),
            ", ".join("%s %d" % one for one in sorted(self.ledger.counts.items())), len(self.outages), longest,
            ", ".join("%s %.1f s" % one for one in self.stalls.items()))


def run(kills, jobs, seed):
    with Cluster() as cluster:
        began = time.monotonic()
        campaign = Campaign(cluster, kills, jobs, seed)
        try:
            campaign.run()
            campaign.look_again()
        except BaseException:
            campaign.fleet.print_tails()
            raise
        ledger = campaign.ledger
        print("cluster: seed %d, %s; violations: %d" % (seed, campaign.figures(time.monotonic() - began), len(ledger.violations)))
        return 1 if ledger.violations or not ledger.accepted else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--jobs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 30))
    arguments = parser.parse_args()
    print("seed %d" % arguments.seed, flush=True)
    with or_skip():
        sys.exit(run(arguments.kills, arguments.jobs, arguments.seed))


if __name__ == "__main__":
    main()
