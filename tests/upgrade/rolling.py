#!/usr/bin/env python3
"""Replaces two front ends and three workers of an older version, one after the other, by the present program while clients
submit, and checks what was promised: rolling.py --old PROGRAM.

The migration comes first, by the command or by the first new process. Then the front ends are replaced and then the workers,
or all in any order. A process of the older version that starts after the migration must refuse the schema.
"""

import argparse
import random
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cluster"))
from crowd import Crowd, works  # noqa: E402
from documents import lost  # noqa: E402
from fixture import pairs  # noqa: E402
from postgres import Postgres, or_skip  # noqa: E402
from processes import BINARY, ENVIRONMENT, Fleet, migrate, until  # noqa: E402
from promises import SECOND_RESULTS, Ledger, longest_stall  # noqa: E402
from sweeps import Sweeper, sweeps  # noqa: E402

DATABASE = "rolling"
FLAGS = ("--lease-ms", "5000", "--heartbeat-ms", "1000", "--log-requests", "problems")
WORKER = ("--workers", "2", "--grace-ms", "100")  # what runs longer at its end is handed over, perhaps to the other version
STALL_SECONDS = 5
BATCHED = 5          # one of so many comparisons comes with a batch
MOST_IN_BATCH = 50


def agree(one, other):
    """Whether two documents say the same. Front ends of both versions answer, and one may have more members."""
    return not list(lost(one, other)) or not list(lost(other, one))


class Upgrade:
    def __init__(self, postgres, old, seconds, jobs, seed):
        self.postgres, self.old, self.seconds, self.dice = postgres, old, seconds, random.Random(seed)
        self.ledger = Ledger(agree)
        self.url = postgres.new_database(DATABASE)
        subprocess.run([old, "migrate"], env={**ENVIRONMENT, "MESHGAUGE_DATABASE": self.url}, check=True, capture_output=True)
        self.fleet = Fleet(postgres.scratch, self.url, FLAGS)
        for verb in ("serve", "serve", "worker", "worker", "worker"):
            self.add_old(verb)
        self.query(SECOND_RESULTS)
        size = min(MOST_IN_BATCH, jobs // BATCHED)
        batches = jobs // BATCHED // size
        known = pairs(postgres.scratch.path)
        self.crowd = Crowd(self.ledger, [one.port for one in self.fleet.front_ends], works(self.dice, known, jobs - batches * size), seed)
        self.sweeper = Sweeper(self.crowd, list(sweeps(self.dice, known, batches, size, seed)), seed)

    def query(self, sql):
        return self.postgres.query(sql, DATABASE)

    def add_old(self, verb):
        one = self.fleet.add(verb, *(() if verb == "serve" else WORKER))
        one.command[0] = self.old
        one.start()

    def run(self):
        self.crowd.start()
        self.sweeper.start()
        self.began = time.monotonic()
        threading.Thread(target=self.pace, daemon=True).start()
        order = self.fleet.all()
        if self.dice.random() < 0.5:
            self.dice.shuffle(order)
        by_command = self.dice.random() < 0.5
        pause = self.seconds / (len(order) + 2)
        self.sleep_until(pause)
        if by_command:
            migrate(self.url)
        for number, one in enumerate(order, 1):
            self.replace(one)
            if number == 1:
                self.say("the schema is new, by the %s" % ("command" if by_command else "first new process"))
                self.check_refusal()
            self.say("%s is new" % one.name)
            self.sleep_until(pause * (number + 1))
        self.sleep_until(self.seconds)
        until(lambda: self.crowd.taken == len(self.crowd.works), 600, "all works to be begun")
        until(lambda: not self.ledger.waiting and self.is_promised(), 600, "%s" % self.ledger.waiting)
        until(lambda: not self.sweeper.waiting() or self.ledger.violations or self.crowd.failures, 600, "the batches' ends")

    def pace(self):
        """Lets clients begin works at an even rate."""
        while self.crowd.may < len(self.crowd.works):
            share = min(1, (time.monotonic() - self.began) / self.seconds)
            self.crowd.may = int(len(self.crowd.works) * share)
            time.sleep(0.1)

    def sleep_until(self, seconds):
        time.sleep(max(0, self.began + seconds - time.monotonic()))

    def say(self, text):
        print("%4.0f s: %s; %d jobs accepted singly, %d wait, %d violations" % (
            time.monotonic() - self.began, text, len(self.ledger.accepted), len(self.ledger.waiting), len(self.ledger.violations)), flush=True)

    def is_promised(self):
        """Whether no client still tries to submit."""
        return self.ledger.counts.get("plain", 0) + len(self.ledger.accepted) >= len(self.crowd.works) or self.ledger.violations

    def replace(self, one):
        one.stop()
        one.command[0] = BINARY
        one.start()

    def check_refusal(self):
        """The older version does not start on the new schema, and says why."""
        done = subprocess.run([self.old, "worker", "--port", "0", "--data-dir", self.postgres.scratch.path / "refused"], timeout=60,
                              env={**ENVIRONMENT, "MESHGAUGE_DATABASE": self.url}, capture_output=True, text=True)
        if done.returncode != 3 or "later version" not in done.stderr:
            self.ledger.violated("an old worker on the new schema: exit %d, %s" % (done.returncode, done.stderr))

    def look_again(self):
        """Checks everything at both front ends, when nothing runs any more."""
        self.crowd.end()
        self.sweeper.end()
        for identity in self.ledger.accepted:
            for front_end in self.fleet.front_ends:
                self.ledger.check(identity, True, front_end.ask("GET", "/v1/comparisons/" + identity))
        self.sweeper.look_again(self.fleet.front_ends)
        for what, sql in (("second results", "SELECT * FROM second_results"),
                          ("jobs that have not ended", "SELECT id FROM jobs WHERE state < 2")):
            found = self.query(sql)
            if found:
                self.ledger.violated("%s: %s" % (what, found))
        self.handed_over = self.query("SELECT count(*) FROM jobs WHERE excused > 0")
        self.stall = longest_stall(self.ledger.answered.found, [])
        if self.stall > STALL_SECONDS:
            at = [round(start - self.began) for start, end in self.ledger.answered.found if end - start > STALL_SECONDS]
            self.ledger.violated("no answers for %.1f s, at %s s" % (self.stall, at))
        for one in self.fleet.all():
            one.stop()

    def figures(self):
        of_batches = sum(len(sweep.works) for sweep in self.sweeper.accepted())
        return "%d jobs in %.0f s, of them %d accepted singly and %d in batches, %s handed over; %s; longest time without an answer %.1f s" % (
            len(self.crowd.works) + of_batches, time.monotonic() - self.began, len(self.ledger.accepted), of_batches, self.handed_over,
            ", ".join("%s %d" % one for one in sorted(self.ledger.counts.items())), self.stall)


def run(old, seconds, jobs, seed):
    with Postgres() as postgres:
        upgrade = Upgrade(postgres, old, seconds, jobs, seed)
        try:
            upgrade.run()
            upgrade.look_again()
        except BaseException:
            upgrade.fleet.print_tails()
            raise
        finally:
            upgrade.fleet.kill_all()
        ledger = upgrade.ledger
        print("upgrade: seed %d, %s; violations: %d" % (seed, upgrade.figures(), len(ledger.violations)))
        return 1 if ledger.violations or not ledger.accepted else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--old", type=Path, required=True, help="the older version's program")
    parser.add_argument("--seconds", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 30))
    arguments = parser.parse_args()
    print("seed %d" % arguments.seed, flush=True)
    with or_skip():
        sys.exit(run(str(arguments.old.resolve()), arguments.seconds, arguments.jobs, arguments.seed))


if __name__ == "__main__":
    main()
