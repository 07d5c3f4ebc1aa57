"""One phase: runs the client, samples the service, and computes figures from the client's rows."""
import csv
import math
import subprocess
import time

from .service import Watch, look

REFUSED = ("503", "429")
MEANING = {"-1": "not connected", "-2": "connection broke", "-3": "no answer", "-4": "client out of connections"}


def quantile(values, q):
    """The smallest value that at least a part `q` of the values does not exceed; None without values."""
    if not values:
        return None
    ordered = sorted(values)
    return ordered[max(0, math.ceil(q * len(ordered)) - 1)]


def rows_of(path):
    with path.open(newline="") as file:
        return [
            {
                "due": float(row["due"]),
                "latency": float(row["latency"]),
                "service": float(row["service"]),
                "status": row["status"],
                "request": int(row["request"]),
            }
            for row in csv.DictReader(file)
        ]


def figures(rows, warm_up, seconds):
    """The figures of the requests that were due after the warm-up."""
    kept = [row for row in rows if row["due"] >= warm_up]
    accepted = [row for row in kept if row["status"] == "200"]
    refused = [row for row in kept if row["status"] in REFUSED]
    others = {}
    for row in kept:
        if row["status"] != "200" and row["status"] not in REFUSED:
            name = MEANING.get(row["status"], row["status"])
            others[name] = others.get(name, 0) + 1
    latencies = [row["latency"] for row in accepted]
    # From the sending: the time that the client itself took to get there is not the service's.
    refusals = [row["service"] for row in refused]
    late = [row["latency"] - row["service"] for row in kept]
    return {
        "requests": len(kept),
        "offered": len(kept) / (seconds - warm_up),
        "throughput": len(accepted) / (seconds - warm_up),
        "accepted": len(accepted),
        "refused": len(refused),
        "others": others,
        **{f"p{name}": quantile(latencies, q) for name, q in (("50", 0.5), ("99", 0.99))},
        "max": max(latencies, default=None),
        **{f"refusal_p{name}": quantile(refusals, q) for name, q in (("50", 0.5), ("99", 0.99))},
        "refusal_max": max(refusals, default=None),
        "late_p99": quantile(late, 0.99),
    }


def by_second(rows, seconds):
    """[{accepted, refused, p99}] for the picture, by the second in which the requests were due."""
    bins = [[] for _ in range(math.ceil(seconds))]
    for row in rows:
        if row["due"] < len(bins):
            bins[int(row["due"])].append(row)
    made = []
    for of in bins:
        latencies = [row["latency"] for row in of if row["status"] == "200"]
        made.append(
            {
                "accepted": len(latencies),
                "refused": sum(row["status"] in REFUSED for row in of),
                "p99": quantile(latencies, 0.99),
            }
        )
    return made


class Phases:
    """Runs phases against one service, and notes each in `runs`."""

    def __init__(self, client, service, folder, settings):
        self.client, self.service, self.folder, self.settings = client, service, folder, settings

    def run(self, name, mix, requests, *, seconds, warm_up, connections=None, rate=None):
        out = self.folder / f"{name}.csv"
        load = ["--connections", str(connections)] if connections else ["--rate", repr(rate)]
        command = [self.client, "--port", str(self.service.port), "--seconds", str(seconds), "--out", out, *load]
        command += ["--sources", str(self.settings["sources"]), "--patience", str(self.settings["patience"]), *requests]
        before = look(self.service.process.pid)
        start = time.monotonic()
        with Watch(self.service.process.pid) as watch:
            subprocess.run(list(map(str, command)), check=True)
        elapsed = time.monotonic() - start
        rows = rows_of(out)
        run = {"name": name, "mix": mix, "connections": connections, "rate": rate, "seconds": seconds, "warm_up": warm_up}
        run |= figures(rows, warm_up, seconds)
        run["memory"] = watch.most("memory")
        run["descriptors"] = watch.most("descriptors")
        run["cpu"] = (look(self.service.process.pid)["cpu"] - before["cpu"]) / elapsed
        run["seconds_by"] = by_second(rows, seconds)
        run["idle_after"] = self.idle_within(60)
        after = look(self.service.process.pid)
        run["memory_after"], run["descriptors_after"] = after["memory"], after["descriptors"]
        return run

    def idle_within(self, seconds):
        """The time until nothing runs, waits or is held; None: not in time."""
        start = time.monotonic()
        while time.monotonic() - start < seconds:
            if self.service.is_idle():
                return time.monotonic() - start
            time.sleep(0.1)
        return None
