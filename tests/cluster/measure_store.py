#!/usr/bin/env python3
"""What one PostgreSQL does for a fleet of workers: the figures that docs/scaling.md reckons with.

    measure_store.py [--seconds N] [--clients N] [--workers N]

On a private server with the settings that docs/scaling.md names: first the calls that workers make (build/tests/bench/fleet_bench), then by
pgbench signals, and a heartbeat of each of so many workers every 10 s, all connected. No worker runs, no mesh is read. The rates are
for client and server together on the processors of this machine.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

from postgres import ENVIRONMENT, Postgres, or_skip
from scratch import ROOT, servant

FLEET = Path(os.environ.get("MESHGAUGE_FLEET_BENCH", ROOT / "build/tests/bench/fleet_bench"))
SETTINGS = {"shared_buffers": "1GB", "max_wal_size": "4GB"}
NOW = "(extract(epoch FROM clock_timestamp()) * 1000)::bigint"
# Each worker runs one job, the row of its number.
FILL = f"""
TRUNCATE jobs RESTART IDENTITY CASCADE;
INSERT INTO jobs (owner, id, state, tries, worker, lease_until, mesh_a, mesh_b, hints, options, cost, rank, fingerprint, trace, created,
                  expires_if_never_run)
SELECT 'owner', i::text::bytea, 1, 1, ('worker' || i)::bytea, {NOW} + 75000, '', '', '{{}}', '{{}}', 1, i, '', '', {NOW}, {NOW} + 86400000
FROM generate_series(1, %d) AS i;
ANALYZE jobs
"""
BEAT = f"""
\\set worker random(1, %d)
SET synchronous_commit = off;
UPDATE jobs SET lease_until = {NOW} + 75000 WHERE number = :worker AND state = 1 AND worker = 'worker:worker' AND tries = 1
  RETURNING cancel_requested;
"""
SIGNAL = "\\set worker random(1, 1000)\nSET synchronous_commit = off;\nSELECT pg_notify('meshgauge', 'owner/:worker');\n"


def pgbench(server, script, clients, *flags):
    """Transactions a second, and their mean time in ms."""
    file = server.folder / "script.sql"
    file.write_text(script)
    file.chmod(0o644)
    done = subprocess.run([server.binaries / "pgbench", "-n", "-c", str(clients), "-j", "2", "-f", file, *flags,
                           server.socket_url()], capture_output=True, text=True, env=ENVIRONMENT, cwd=server.folder, check=False,
                          **servant())  # fmt: skip
    if done.returncode != 0 or "tps = " not in done.stdout:
        sys.exit(f"pgbench: {done.stdout}{done.stderr}")
    return float(re.search(r"tps = ([\d.]+)", done.stdout)[1]), float(re.search(r"latency average = ([\d.]+)", done.stdout)[1])


def row(what, rate, ms):
    print(f"| {what} | {rate:,.0f} | {ms:.1f} |", flush=True)


def measure(server, options):
    subprocess.run([FLEET, str(options.seconds), str(options.clients), str(options.workers)], check=True,
                   env={**os.environ, "MESHGAUGE_DATABASE": server.url()})  # fmt: skip
    server.query("DELETE FROM jobs WHERE state < 2")
    server.query("VACUUM FULL jobs")
    size = server.query("SELECT pg_total_relation_size('jobs') / count(*) FROM jobs")
    row(f"signals, {options.clients} at a time", *pgbench(server, SIGNAL, options.clients, "-T", str(options.seconds)))
    server.query(FILL % options.workers)
    beats = pgbench(server, BEAT % options.workers, options.workers, "-t", "3", "-R", str(options.workers / 10))
    row(f"{options.workers:,} connections, a heartbeat of each every 10 s", *beats)
    print(f"| bytes of a job that has ended, with its indexes | {int(size):,} | |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=10, help="for each figure")
    parser.add_argument("--clients", type=int, default=32, help="connections that ask at the same time")
    parser.add_argument("--workers", type=int, default=1000, help="workers with running jobs, a connection each")
    options = parser.parse_args()
    if not FLEET.exists():
        sys.exit(f"there is no {FLEET}: cmake --build build --target fleet_bench")
    with or_skip():
        server = Postgres(max_connections=options.workers + options.clients + 20, **SETTINGS)
    with server:
        print(f"{os.cpu_count()} processors, PostgreSQL {server.query('SHOW server_version')}\n")
        print("| what | a second | ms |\n|---|--:|--:|", flush=True)
        measure(server, options)


if __name__ == "__main__":
    main()
