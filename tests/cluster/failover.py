#!/usr/bin/env python3
"""Kills the leader of three PostgreSQL while front ends and workers start on an empty database and bring its schema up,
each statement of which takes a while. Then all of them must run, on the schema that one gets without a kill."""

import argparse
import concurrent.futures
import random
import re
import subprocess
import time
import types

from patroni import Cluster
from postgres import or_skip
from processes import Ended, Fleet, migrate, until
from rig import Client, holds
from schemas import MIGRATING, SHAPE, SLOWLY

START_SECONDS = 180
LONGEST = 2.5  # seconds into the migration


def bring_up(process):
    """Starts a process again and again, as a supervisor does, until it is ready. Returns how many starts ended, each of
    them by a line and code 3."""
    ended, end = 0, time.monotonic() + START_SECONDS
    while True:
        process.start(wait=False)
        try:
            process.wait_ready()
            return ended
        except Ended:
            said, code = process.tail(), process._ended()
            assert code == 3 and re.search("(?m)^meshgauge: .", said), "exit %d: %s" % (code, said)
            assert time.monotonic() < end, said
            ended += 1
        time.sleep(0.2)


def is_migrating(cluster, database):
    try:
        return int(cluster.query(MIGRATING, database)) > 0
    except subprocess.CalledProcessError:
        return False


def once(cluster, number, dice, shape):
    """One kill on a database of its own; a line of figures."""
    name = "failover%d" % number
    cluster.wait_whole()
    cluster.ask("CREATE DATABASE " + name)
    cluster.ask(SLOWLY, name)
    fleet = Fleet(types.SimpleNamespace(path=cluster.scratch.folder(name)), cluster.url(name))
    processes = [fleet.add(verb) for verb in ("serve", "serve", "worker", "worker")]
    with concurrent.futures.ThreadPoolExecutor(len(processes)) as pool:
        starts = [pool.submit(bring_up, process) for process in processes]
        until(lambda: is_migrating(cluster, name), what="the migration to begin")
        seconds = dice.uniform(0, LONGEST)
        time.sleep(seconds)
        began, leader = time.monotonic(), until(cluster.leader)
        leader.kill()
        ended = sum(start.result() for start in starts)
        taken = time.monotonic() - began
    leader.start()
    found = cluster.ask(SHAPE, name)
    assert found == shape, "another schema than without a kill:\n%s\n---\n%s" % (found, shape)
    client = Client(fleet.front_ends[0])
    document = client.wait_for(client.begin(0, 3), "done")
    assert holds(document, 3), document
    for process in processes:
        process.stop()
    return "killed after %.1f s of the migration: %d starts ended, all run %.1f s later, on the whole schema" % (
        seconds, ended, taken)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 30))
    arguments = parser.parse_args()
    print("seed %d" % arguments.seed, flush=True)
    dice = random.Random(arguments.seed)
    with or_skip():
        cluster = Cluster()
    with cluster:
        cluster.ask("CREATE DATABASE whole")
        migrate(cluster.url("whole"))
        shape = cluster.ask(SHAPE, "whole")
        for number in range(1, arguments.kills + 1):
            print("failover: " + once(cluster, number, dice, shape), flush=True)


if __name__ == "__main__":
    main()
