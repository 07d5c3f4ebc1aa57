"""Attacks a service as hostile clients do, by 1,500 attacks that each have a name, and checks that it answers each
as it may, serves honest clients rightly, answers health checks in time, and has grown by nothing (docs/testing.md)."""

import argparse
import collections
import fnmatch
import importlib
import random
import sys
import time

from clients import service  # first: it names the folders of the other tests  # noqa: F401
from clients.campaign import Campaign, Report
from seeds import seed

FAMILIES = ("heads", "targets", "bodies", "forms", "meshes", "work", "slow", "strangers", "secured")
LEAST = 400  # attacks of a whole run
WHOLE_SECONDS = 600


def all_attacks():
    families = [family for name in FAMILIES for family in importlib.import_module("clients." + name).FAMILIES]
    attacks = [attack for family in families for attack in family.attacks]
    names = collections.Counter(attack.name for attack in attacks)
    assert names.total() == len(names), "names that stand there twice: %s" % names.most_common(3)
    return attacks


def chosen(attacks, arguments, dice):
    """Variants with their attacks. Of a slice each attack is tried on one variant that it is for."""
    variants = [one for one in service.VARIANTS if not arguments.variants or one.name in arguments.variants]
    attacks = [attack for attack in attacks if not arguments.only or any(fnmatch.fnmatchcase(attack.name,
            glob) for glob in arguments.only)]
    if not arguments.attacks:
        return [(variant, attacks) for variant in variants]
    found = {variant.name: [] for variant in variants}
    for attack in dice.sample(attacks, min(arguments.attacks, len(attacks))):
        places = [variant.name for variant in variants if attack.is_for(variant)]
        if places:
            found[dice.choice(places)].append(attack)
    return [(variant, found[variant.name]) for variant in variants if found[variant.name]]


def run(arguments):
    dice, report, began = random.Random(arguments.seed), Report(), time.monotonic()
    plan = chosen(all_attacks(), arguments, dice)
    for variant, attacks in plan:
        Campaign(variant, attacks, arguments.seconds / len(plan), dice, report, arguments.short).run()
    for text in sorted(report.skipped):
        print("skipped: " + text)
    seconds, listed = time.monotonic() - began, lambda pairs: ", ".join("%s %s" % one for one in sorted(pairs.items()))
    print("clients: seed %d, %d attacks by name, tried %d times on %d services in %.0f s; answers by status: %s; "
          "an honest client: %s; broken: %d" % (
              arguments.seed, len(report.tried), report.tried.total(), len(plan), seconds, listed(report.statuses),
              listed(report.honest), len(report.broken)))
    least = 1 if arguments.only or arguments.variants or arguments.attacks else LEAST
    if len(report.tried) < least:
        print("fewer than %d attacks were tried" % least)
    return 1 if report.broken or len(report.tried) < least else 0


def main():
    parser = argparse.ArgumentParser(prog="./dev chaos clients", description=__doc__)
    parser.add_argument("--seconds", type=float,
                        help="for all services together; each gets a warm-up and a round at least (600; with --only 0)")
    parser.add_argument("--seed", type=seed, default=random.SystemRandom().randrange(1 << 30), help="`today`: the date")
    parser.add_argument("--only", nargs="+", metavar="GLOB", help="attacks whose names match")
    parser.add_argument("--variants", nargs="+", choices=[one.name for one in service.VARIANTS],
                        help="these services only")
    parser.add_argument("--attacks", type=int, metavar="N", help="only so many, drawn by the seed")
    parser.add_argument("--short", action="store_true", help="once, and without a judgement of times and memory")
    parser.add_argument("--list", action="store_true", help="the names of all attacks")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(attack.name for attack in all_attacks()))
        return 0
    if arguments.seconds is None:
        arguments.seconds = 0 if arguments.only else WHOLE_SECONDS
    print("seed %d" % arguments.seed, flush=True)
    return run(arguments)


if __name__ == "__main__":
    sys.exit(main())
