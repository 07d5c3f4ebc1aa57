"""The soak: hours of even load and of all that clients do beside it, and whether anything grows."""
import contextlib
import math
import pathlib
import sqlite3
import subprocess
import time

from .company import Company
from .phases import figures, rows_of
from .service import Watch

# Results and meshes expire soon, and caches are small, so that as much goes as comes long before the first quarter ends.
KEPT = ("--result-ttl-s", "300", "--mesh-ttl-s", "300", "--max-cache-bytes", "16000000", "--map-cache-bytes", "16000000")
WATCHED = ("memory", "alone", "descriptors", "threads", "processes", "rows", "blobs", "log", "temporary")
MOST_GROWTH = 0.02
ROWS = "SELECT (SELECT count(*) FROM jobs) + (SELECT count(*) FROM meshes) + (SELECT count(*) FROM batches)"


def correlation_time(rest):
    """1 + 2 (r1 + r2 + ...), as long as the correlations are positive: how many values are worth one."""
    n, total = len(rest), sum(r * r for r in rest)
    if total == 0:
        return 1.0
    time_ = 1.0
    for lag in range(1, n // 2):
        r = sum(a * b for a, b in zip(rest, rest[lag:])) / total
        if r <= 0:
            break
        time_ += 2 * r
    return time_


def stored(data):
    """What the service keeps in its folder: rows, files of meshes, the bytes of the database's log, and what else lies there."""
    database = data / "jobs.sqlite"
    with contextlib.closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True, timeout=10)) as connection:
        rows = connection.execute(ROWS).fetchone()[0]
    files = [path for path in data.rglob("*") if path.is_file()]
    log = data / "jobs.sqlite-wal"
    blobs = sum(path.is_relative_to(data / "blobs") for path in files)
    return {"rows": rows, "blobs": blobs, "log": log.stat().st_size, "temporary": len(files) - blobs}


def quarters(rows, what, warm_up, seconds):
    """The mean over the first and over the last quarter after the warm-up, and the standard error of their difference."""
    length = (seconds - warm_up) / 4
    means, variance = [], 0.0
    for begin in (warm_up, seconds - length):
        values = [row[what] for row in rows if begin <= row["at"] <= begin + length]
        mean = sum(values) / len(values)
        rest = [value - mean for value in values]
        means.append(mean)
        variance += sum(r * r for r in rest) / len(values) ** 2 * correlation_time(rest)
    return means[0], means[1], math.sqrt(variance)


def is_flat(first, last, error):
    """Whether the last quarter is at most 2 % above the first, or by what chance alone explains."""
    return last - first <= max(MOST_GROWTH * first, 2 * error)


def run(client, service, folder, settings, requests, rate, minutes):
    """An open loop at `rate`, and company(). The first eleventh is a warm-up beyond `minutes`: caches fill, and results
    begin to expire."""
    out, data = folder / "soak.csv", pathlib.Path(service.data.name)
    seconds, warm_up = 66 * minutes, 6 * minutes
    command = [client, "--port", service.port, "--seconds", seconds, "--rate", rate, "--out", out]
    command += ["--sources", settings["sources"], "--patience", settings["patience"], *requests]
    start = time.monotonic()
    with Watch(service.process.pid, max(1.0, seconds / 2000), lambda: stored(data)) as watch:
        with Company(service, settings["seed"]) as company:
            subprocess.run(list(map(str, command)), check=True)
    growth = {}
    for what in WATCHED:
        first, last, error = quarters(watch.rows, what, warm_up, seconds)
        growth[what] = {"first": first, "last": last, "error": error, "flat": is_flat(first, last, error)}
    return {
        "minutes": minutes,
        "rate": rate,
        "elapsed": time.monotonic() - start,
        **figures(rows_of(out), warm_up, seconds),
        "growth": growth,
        "company": company.counts,
        "promised": company.ledger.counts,
        "violations": company.ledger.violations,
        "watched": watch.rows,
    }


def faults(soak):
    """What a soak found, a sentence each."""
    grown = [f"{what} grew from {growth['first']:g} to {growth['last']:g}" for what, growth in soak["growth"].items() if not growth["flat"]]
    return [*grown, *soak["violations"], *(f"{number} requests: {name}" for name, number in soak["others"].items())]
