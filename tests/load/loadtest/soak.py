"""The soak: hours of ordinary load, and whether memory or descriptors grow."""
import math
import subprocess
import time

from .phases import figures, rows_of
from .service import Watch


def slope(times, values):
    """Least squares: (slope, its standard error). The error takes neighbours into account, which are alike: as many
    values as are worth one are found from their correlation."""
    n = len(times)
    if n < 3:
        return 0.0, math.inf
    mean_t, mean_v = sum(times) / n, sum(values) / n
    spread = sum((t - mean_t) ** 2 for t in times)
    rise = sum((t - mean_t) * (v - mean_v) for t, v in zip(times, values)) / spread
    rest = [v - mean_v - rise * (t - mean_t) for t, v in zip(times, values)]
    variance = sum(r * r for r in rest) / (n - 2)
    return rise, math.sqrt(variance / spread * correlation_time(rest))


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


def verdict(rise, error):
    """The verdict: within two standard errors of zero no growth is seen."""
    return "none seen" if rise <= 2 * error else "**grows**"


def run(client, service, folder, settings, requests, rate, minutes):
    """An open loop at `rate`. The first half is left out: caches fill, and the allocator's arenas
    grow to what each of the threads needs at most, which some come to late."""
    out = folder / "soak.csv"
    seconds = 60 * minutes
    command = [client, "--port", service.port, "--seconds", seconds, "--rate", rate, "--out", out]
    command += ["--sources", settings["sources"], "--patience", settings["patience"], *requests]
    start = time.monotonic()
    with Watch(service.process.pid, period=max(1.0, seconds / 1000)) as watch:
        subprocess.run(list(map(str, command)), check=True)
    warm_up = seconds / 2
    kept = [row for row in watch.rows if warm_up <= row["at"] <= seconds]
    hours = [row["at"] / 3600 for row in kept]
    growth = {}
    for what in ("memory", "alone", "descriptors", "processes"):
        values = [row[what] for row in kept]
        rise, error = slope(hours, values)
        growth[what] = {"slope": rise, "error": error, "mean": sum(values) / max(1, len(values))}
    return {
        "minutes": minutes,
        "rate": rate,
        "elapsed": time.monotonic() - start,
        **figures(rows_of(out), warm_up, seconds),
        "growth": growth,
        "watched": watch.rows,
    }
