#!/usr/bin/env python3
"""What one PostgreSQL does for a fleet of workers: the figures that docs/scaling.md reckons with.

    measure_store.py [--seconds N] [--clients N] [--workers N] [--waiting N] [--schema FILE]

Runs pgbench on a private server with the settings that docs/scaling.md names, on the schema that `meshgauge migrate` makes (or on
that of a file), with statements like the store's: no worker runs, no mesh is read. The rates are those of pgbench and PostgreSQL on
the processors of this machine together.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

from postgres import ENVIRONMENT, SKIPPED, Missing, Postgres
from processes import migrate
from scratch import servant

SETTINGS = {"shared_buffers": "1GB", "max_wal_size": "4GB", "autovacuum_vacuum_scale_factor": "0.02"}
OWNERS = 10
# A comparison's result has about this size; a seed keeps PostgreSQL from compressing it to nothing.
DOCUMENT = "(SELECT string_agg(md5(i::text || number), '') FROM generate_series(1, 75) AS i)::bytea"
NOW = "(extract(epoch FROM clock_timestamp()) * 1000)::bigint"
LEASE = f"{NOW} + 75000"

FILL = f"""
INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, fingerprint, trace, created, expires_if_never_run)
SELECT ('owner' || mod(i, {OWNERS}))::bytea, md5(random()::text || i)::bytea, 0, (md5(i::text) || md5('a' || i))::bytea,
       (md5('b' || i) || md5('c' || i))::bytea, '{{"a":"left.stl","b":"right.stl"}}', '{{"tolerance":{{"relative":0.01}}}}', 100000, i,
       (md5('f' || i) || md5('g' || i))::bytea, '', {NOW}, {NOW} + 86400000
FROM generate_series(1, %d) AS i
"""
CLAIM = f"""
WITH next AS (
  SELECT number FROM jobs WHERE state = 0 AND awaits = 0 AND owner = 'owner:owner' AND batch = '' ORDER BY rank LIMIT %d FOR UPDATE SKIP LOCKED),
claimed AS (
  UPDATE jobs SET state = 1, tries = tries + 1, worker = 'worker:worker', started = {NOW}, lease_until = {LEASE}
  FROM next WHERE jobs.number = next.number RETURNING jobs.number)
SELECT coalesce(string_agg(number::text, ','), '0') AS numbers FROM claimed \\gset
"""
FINISH = f"""
UPDATE jobs SET state = 2, document = {DOCUMENT}, finished = {NOW}, expires = {NOW} + 86400000, lease_until = NULL
WHERE number IN (:numbers) AND state = 1 AND worker = 'worker:worker' AND tries = 1;
"""
DRAW = "\\set worker random(1, {workers})\n\\set owner random(0, %d)\n" % (OWNERS - 1)
SCRIPTS = {
    "life of a job": DRAW + CLAIM % 1 + FINISH,
    "32 jobs claimed and ended at once": DRAW + CLAIM % 32 + FINISH,
    "heartbeat of a worker": DRAW + f"UPDATE jobs SET lease_until = {LEASE} WHERE number = :worker AND state = 1 AND tries = 1;",
    "progress of a job": DRAW + f"UPDATE jobs SET lease_until = {LEASE}, lower = random(), upper = 1 WHERE state = 1 AND number = :worker;"
                         "SELECT pg_notify('meshgauge', 'owner/:worker');",
    "NOTIFY alone": DRAW + "SELECT pg_notify('meshgauge', 'owner/:worker');",
}  # fmt: skip


class Bench:
    def __init__(self, server, options):
        self.server, self.options = server, options

    def run(self, name, script, clients, *flags, seconds=None):
        """Transactions a second, and their mean time in ms."""
        file = self.server.folder / "script.sql"
        file.write_text(script.replace("{workers}", str(self.options.workers)))
        file.chmod(0o644)
        done = subprocess.run(
            [self.server.binaries / "pgbench", "-n", "-c", str(clients), "-j", "2", "-T", str(seconds or self.options.seconds), "-f", file, *flags,
             self.server.socket_url()],
            capture_output=True, text=True, env=ENVIRONMENT, cwd=self.server.folder, check=False, **servant())  # fmt: skip
        if done.returncode != 0 or "tps = " not in done.stdout:
            sys.exit(f"{name}: {done.stdout}{done.stderr}")
        return float(re.search(r"tps = ([\d.]+)", done.stdout)[1]), float(re.search(r"latency average = ([\d.]+)", done.stdout)[1])

    def count(self, condition):
        return int(self.server.query(f"SELECT count(*) FROM jobs WHERE {condition}"))

    def fill(self, waiting):
        self.server.query("TRUNCATE jobs RESTART IDENTITY CASCADE")
        self.server.query(FILL % waiting)
        self.server.query("VACUUM ANALYZE jobs")

    def lives(self, name, clients):
        """Jobs a second from the queue to their results."""
        self.fill(self.options.waiting)
        _, ms = self.run(name, SCRIPTS[name], clients)
        ended = self.count("state = 2")
        if self.count("state = 0") == 0:
            sys.exit(f"{name}: the queue ran empty; more --waiting")
        return ended / self.options.seconds, ms

    def beats(self, name, clients, *flags, **options):
        """The rate with one running job of each worker."""
        self.fill(self.options.workers)
        self.server.query(f"UPDATE jobs SET state = 1, tries = 1, worker = ('worker' || number)::bytea, lease_until = {LEASE}")
        self.server.query("VACUUM ANALYZE jobs")
        return self.run(name, SCRIPTS[name], clients, *flags, **options)

    def bytes_per_job(self):
        """Of jobs that have ended, their indexes and the room that updates left included."""
        return int(self.server.query("SELECT pg_total_relation_size('jobs') / count(*) FROM jobs WHERE state = 2"))


def measure(bench):
    clients, rows = bench.options.clients, []

    def row(what, rate, ms):
        rows.append(f"| {what} | {rate:,.0f} | {ms:.1f} |")
        print(rows[-1], flush=True)

    for name in list(SCRIPTS)[:2]:
        for of in (1, clients):
            row(f"{name}, {of} at a time", *bench.lives(name, of))
    size = bench.bytes_per_job()
    for name in list(SCRIPTS)[2:]:
        row(f"{name}, {clients} at a time", *bench.beats(name, clients))
    # What so many workers ask of it, each on a connection of its own that stays; making those takes a while.
    name, workers = "heartbeat of a worker", bench.options.workers
    beats = bench.beats(name, workers, "-R", str(workers / 10), seconds=bench.options.seconds + workers // 30)
    row(f"{name}, {workers:,} connections, one each 10 s", *beats)
    print(f"| bytes of a job that has ended, with its indexes | {size:,} | |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=10, help="for each figure")
    parser.add_argument("--clients", type=int, default=32, help="connections that ask at the same time")
    parser.add_argument("--workers", type=int, default=1000, help="whose jobs run, a connection each")
    parser.add_argument("--waiting", type=int, default=100_000, help="jobs that wait at first")
    parser.add_argument("--schema", type=Path, help="file of SQL in place of `meshgauge migrate`")
    options = parser.parse_args()
    try:
        server = Postgres(max_connections=options.workers + options.clients + 20, **SETTINGS)
    except Missing as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        sys.exit(SKIPPED)
    with server:
        if options.schema:
            server.query(options.schema.read_text())
        else:
            migrate(server.url())
        print(f"{os.cpu_count()} processors, PostgreSQL {server.query('SHOW server_version')}, {options.waiting:,} jobs wait\n")
        print("| what | a second | mean ms |\n|---|--:|--:|")
        measure(Bench(server, options))


if __name__ == "__main__":
    main()
