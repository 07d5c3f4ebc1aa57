"""All attacks on one service after the other: a warm-up, rounds until the time is over, and what it has cost."""

import collections
import concurrent.futures
import contextlib
import os
import random
import threading
import time
import traceback

from clients.arena import Arena
from clients.attack import Skipped
from clients.health import KINDS, Health, percentile
from clients.honest import Honest
from clients.service import IDLE, SANITIZED, Service

AT_ONCE, ATTACKERS_NICE = 6, 5
QUIET, BESIDE, NEITHER = 0, 1, 2  # phases of Health
QUIET_SECONDS = 10
MOST_MS, MOST_RATIO = 100, 5  # p99 of a health check beside attacks; on a machine with other load: times that without
MOST_KB, MOST_SHARE = 16 << 10, 0.1  # that the memory may grow from the warm-up to the end
SETTLE_SECONDS = 90  # what is freed goes back to the system every 30 s
OWN_CONNECTIONS = 4
MOST_DESCRIPTORS = 24  # the store keeps up to eight connections for reading, of three files each
LEAST_SERVED, LEAST_ACTS = 0.5, 10


class Report:
    """What all services did."""

    def __init__(self):
        self.broken, self.skipped, self.statuses, self.honest = [], set(), collections.Counter(), collections.Counter()
        self.tried = collections.Counter()  # by the name of the attack

    def fails(self, variant, name, text):
        self.broken.append("%s: %s: %s" % (variant.name, name, text))
        print("BROKEN: " + self.broken[-1], flush=True)


class Campaign:
    """`short`: for a machine of which nothing is known: neither times nor memory are judged, nothing is repeated."""

    def __init__(self, variant, attacks, seconds, dice, report, short):
        self.variant, self.dice, self.report, self.short = variant, dice, report, short
        self.attacks = [attack for attack in attacks if attack.is_for(variant)]
        self.seconds, self.number = seconds, 0

    def run(self):
        self.began = time.monotonic()
        self.service = Service(self.variant)
        self.health = Health(self.service.port, self.variant.tls)
        try:
            self.rounds()
        except Exception:
            self.fails("the campaign", traceback.format_exc())
        finally:
            self.health.process.kill()
            code = self.service.stop()
            if code != 0:
                self.fails("the end", "exit %d\n%s" % (code, "".join(self.service.server.log[-20:])))
            self.report.statuses.update(self.service.statuses)

    def fails(self, name, text):
        self.report.fails(self.variant, name, text)

    def rounds(self):
        self.quiet()
        if not self.short:
            self.once("warm-up")
            self.settle()
            self.before = self.service.sizes()
        while True:
            self.once("round")
            if self.short or time.monotonic() - self.began > self.seconds - QUIET_SECONDS:
                break
        self.quiet()
        self.judge_times(self.health.end())
        self.settle()
        if not self.short:
            self.judge_growth(self.service.sizes())
        for text in self.service.trouble():
            self.fails("the service", text)

    def quiet(self):
        self.health.phase.value = QUIET
        time.sleep(0 if self.short else QUIET_SECONDS)

    # --- attacks ---

    def once(self, what):
        """Each attack once, in an order of its own: many at once, then those that others would disturb."""
        self.health.phase.value, began = BESIDE, time.monotonic()
        honest = Honest(self.service, random.Random(self.dice.random()))
        attacks = list(self.attacks)
        self.dice.shuffle(attacks)
        for at_once in (AT_ONCE, 1):
            with concurrent.futures.ThreadPoolExecutor(at_once, initializer=lower_priority) as pool:
                list(pool.map(self.attack, [attack for attack in attacks if attack.alone == (at_once == 1)]))
        honest.end()
        self.health.phase.value = NEITHER
        self.report.honest.update(honest.counts)
        for text in honest.broken:
            self.fails("an honest client", text)
        served, acts = honest.counts["served"], sum(honest.counts.values())
        if acts >= LEAST_ACTS and served < LEAST_SERVED * acts and not self.variant.descriptors:
            self.fails("an honest client", "is served %d times of %d" % (served, acts))
        print("%s, %s: %d attacks in %.0f s, beside them an honest client %s" % (
            self.variant.name, what, len(attacks), time.monotonic() - began, dict(honest.counts)), flush=True)

    def attack(self, attack):
        self.number += 1
        self.report.tried[attack.name] += 1
        try:
            attack.act(Arena(self.service, self.number, self.dice))
        except Skipped as reason:
            self.report.skipped.add("%s: %s" % (attack.name, reason))
        except Exception as error:
            if self.service.process.poll() is None or not self.report.broken:
                text = str(error) if isinstance(error, AssertionError) else traceback.format_exc(limit=-3)
                self.fails(attack.name, text[:1500] or repr(error))

    # --- judgements ---

    def settle(self):
        """Waits until nothing runs, arrives or is followed, and all that attackers held is given back."""
        end, left = time.monotonic() + SETTLE_SECONDS, "no answer"
        while time.monotonic() < end and left:
            with contextlib.suppress(OSError, AttributeError):
                levels = self.service.levels(*IDLE, "connections")
                levels["connections"] = max(0, levels["connections"] - OWN_CONNECTIONS)
                levels["files"] = self.service.sizes().files
                left = {name: value for name, value in levels.items() if value}
            time.sleep(0.1 if left else 0)
        if left:
            self.fails("afterwards", "it is not idle again: %s" % left)

    def judge_times(self, times):
        for kind in KINDS:
            quiet, beside = times.get((QUIET, kind), []), times.get((BESIDE, kind), [])
            alone, attacked = percentile(quiet, 0.99), percentile(beside, 0.99)
            print("%s: health on %s connections: %s; beside the attacks %s" % (self.variant.name, kind, figures(quiet),
                    figures(beside)), flush=True)
            judged = beside and not self.short and not self.variant.descriptors
            if judged and not attacked <= max(MOST_MS, MOST_RATIO * alone):
                self.fails("health", "p99 on %s connections is %.1f ms beside the attacks, and %.1f ms without" % (kind,
                        attacked, alone))

    def judge_growth(self, after):
        end = time.monotonic() + SETTLE_SECONDS
        while self.grown(after) and time.monotonic() < end:
            time.sleep(1)
            after = self.service.sizes()
        print("%s: after the warm-up %s; at the end %s" % (self.variant.name, self.before, after), flush=True)
        for text in self.grown(after):
            self.fails("growth", text)

    def grown(self, after):
        before, found = self.before, []
        if not SANITIZED and after.resident_kb > before.resident_kb + max(MOST_KB, MOST_SHARE * before.resident_kb):
            found.append("%d kB became %d" % (before.resident_kb, after.resident_kb))
        if after.descriptors > before.descriptors + MOST_DESCRIPTORS:
            found.append("%d descriptors became %d" % (before.descriptors, after.descriptors))
        if after.threads > before.threads:
            found.append("%d threads became %d" % (before.threads, after.threads))
        if after.files:
            found.append("%d temporary files" % after.files)
        return found


def lower_priority():
    """Of this thread: attackers must not take the time of the service, nor of what measures it."""
    thread = threading.get_native_id()
    os.setpriority(os.PRIO_PROCESS, thread, max(ATTACKERS_NICE, os.getpriority(os.PRIO_PROCESS, thread)))


def figures(times):
    return "p50 %.1f ms, p99 %.1f ms, of %d" % (percentile(times, 0.5), percentile(times, 0.99),
                                                len(times)) if times else "not measured"
