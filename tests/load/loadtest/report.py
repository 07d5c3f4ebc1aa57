"""The section of docs/benchmarks.md about load: tables between markers, pictures beside.

    <!-- load: NAME -->
    ...
    <!-- end of load -->
"""
import math
import re
import sys

from harness import text

MARKED = re.compile(r"(<!-- load: (\w+) -->\n).*?(<!-- end of load -->)", re.DOTALL)
SECOND, MEBIBYTE = 1.0, 1 << 20
MOST_TO_REFUSE = 0.020
LEAST_GOODPUT = 0.9  # of the closed loop's


def _mib(value):
    return f"{value / MEBIBYTE:.0f} MiB"


def _seconds(value):
    return text.seconds(math.nan if value is None else value)


def _others(run):
    return ", ".join(f"{n} {name}" for name, n in sorted(run["others"].items())) or "0"


def _label(run):
    if run["connections"]:
        return f"closed, {run['connections']} clients"
    return f"open, {run['multiple']:g}x"


def loads(record):
    header = (
        "pairs", "load", "offered a second", "answered a second", "p50", "p99", "refused", "time to 503: p50", "p99",
        "memory", "after", "idle after", "processors", "neither 200 nor 503",
    )  # fmt: skip
    rows = [
        (
            run["mix"], _label(run), text.rounded(run["offered"]), text.rounded(run["throughput"]),
            _seconds(run["p50"]), _seconds(run["p99"]), text.percent(run["refused"] / max(1, run["requests"])),
            _seconds(run["refusal_p50"]), _seconds(run["refusal_p99"]), _mib(run["memory"]), _mib(run["memory_after"]),
            "never" if run["idle_after"] is None else _seconds(max(run["idle_after"], 0.001)),
            f"{run['cpu']:.2f}", _others(run),
        )  # fmt: skip
        for run in record["runs"]
    ]
    return text.table(header, rows)


def _at(record, mix, multiple):
    return next((run for run in record["runs"] if run["mix"] == mix and run.get("multiple") == multiple), None)


def verdicts(record):
    """What the service promises under load, against what was seen."""
    rows = []
    if stored := record["capacity"].get("stored"):
        rows.append(("small comparisons a second of stored meshes, keep-alive", "≥ 1000", text.rounded(stored),
                     _met(stored >= 1000)))  # fmt: skip
    if small := record["capacity"].get("small"):
        rows.append(("the same, both meshes uploaded each time", "", text.rounded(small), ""))
    for mix, capacity in record["capacity"].items():
        most, least = max(record["multiples"]), _at(record, mix, 1.0)
        top = _at(record, mix, most)
        if not top or not least or not least["p99"]:
            continue
        bound = 2 * least["p99"] + record["places"] / capacity
        rows.append((f"{mix} at {most:g}x: p99 of what was accepted", f"≤ {_seconds(bound)} (twice the p99 at 1x, and the "
                     "time of a full queue)", _seconds(top["p99"]), _met((top["p99"] or math.inf) <= bound)))  # fmt: skip
        goodput = top["throughput"] / capacity
        rows.append((f"{mix} at {most:g}x: answered, of the closed loop's capacity", f"≥ {LEAST_GOODPUT}", f"{goodput:.2f}",
                     _met(goodput >= LEAST_GOODPUT)))  # fmt: skip
        if top["refusal_p99"] is not None:
            rows.append((f"{mix} at {most:g}x: p99 of the time to 503", f"≤ {_seconds(MOST_TO_REFUSE)}",
                         _seconds(top["refusal_p99"]), _met(top["refusal_p99"] <= MOST_TO_REFUSE)))  # fmt: skip
        rows.append((f"{mix}: requests that got neither 200 nor 503", "0", _others(top), _met(not top["others"])))
        idle = all(run["idle_after"] is not None for run in record["runs"] if run["mix"] == mix)
        rows.append((f"{mix}: back to idle after each phase", "yes", "yes" if idle else "no", _met(idle)))
    return text.table(("what", "target", "measured", "verdict"), rows)


def _met(yes):
    return "met" if yes else "**missed**"


SOAKED = {
    "memory": ("memory of all processes, MiB", MEBIBYTE), "alone": ("memory of the service alone, MiB", MEBIBYTE),
    "descriptors": ("descriptors", 1), "threads": ("threads", 1), "processes": ("processes", 1),
    "rows": ("rows of jobs, meshes and batches", 1), "blobs": ("files of meshes", 1),
    "log": ("write-ahead log, MiB", MEBIBYTE), "temporary": ("other files", 1),
}  # fmt: skip


def soak(record):
    run = record["soak"]
    rows = []
    for name, (title, unit) in SOAKED.items():
        growth = run["growth"][name]
        first, last, error = (growth[which] / unit for which in ("first", "last", "error"))
        change = f"{100 * (last - first) / first:+.1f} %" if first else "0"
        rows.append((title, text.rounded(first), text.rounded(last), change, f"± {error:.2g}", "flat" if growth["flat"] else "**grows**"))
    table = text.table(("mean", "first quarter", "last quarter", "change", "standard error", "verdict"), rows)
    head = (f"{run['minutes']:g} minutes after a warm-up, mixed pairs, {text.rounded(run['rate'])} requests a second: "
            f"{text.count(run['accepted'])} answered, {text.count(run['refused'])} refused, neither: {_others(run)}; "
            f"p50 {_seconds(run['p50'])}, p99 {_seconds(run['p99'])}. Beside them {_counted(run['company'])}; "
            f"{text.count(run['promised'].get('intervals', 0))} intervals looked at; violations: {len(run['violations'])}.")  # fmt: skip
    return head + "\n\n" + table


def _counted(counts):
    return ", ".join(f"{text.count(number)} {what}" for what, number in counts.items())


def machine(record):
    facts = record["machine"]
    return (f"{facts['processor']}, {facts['cores']} cores, {facts['memory']}, Linux "
            f"{facts['kernel']}, commit {facts['commit']}, {facts['session']} UTC. "
            f"`meshgauge serve {' '.join(record['flags'])}`".rstrip(" `") + "`: "
            f"{record['workers']} workers, {record['places']} places{_split(record)}. Load of the machine before the start: "
            f"{record['load_before']:.1f}. The client was late by {_seconds(worst_late(record))} at the 99th percentile "
            "of its worst phase.")  # fmt: skip


def _split(record):
    shared = len(record.get("processors", ())) in (0, record["machine"]["cores"])
    return "; the client shares its processors" if shared else "; the client has a processor of its own"


def worst_late(record):
    return max((run["late_p99"] or 0 for run in record["runs"]), default=0)


MADE = {"machine": machine, "verdicts": verdicts, "loads": loads, "soak": soak}


def sections(record):
    """What was measured, by its name on the page."""
    return {name: make(record) for name, make in MADE.items() if record.get("soak" if name == "soak" else "runs")}


def fill(page, record):
    """What was not measured stays as it is."""
    made = sections(record)
    return MARKED.sub(lambda m: m[1] + text.wrapped(made[m[2]]) + "\n" + m[3] if m[2] in made else m[0], page)


def render(record, out, to, page):
    """Tables in OUT/load.md; with TO also in its benchmarks.md. Pictures go to benchmarks/ beside."""
    filled = fill(page.read_text(), record)
    if to:
        (to / "benchmarks.md").write_text(filled)
    (out / "load.md").write_text("\n\n".join(f"## {name}\n\n{made}" for name, made in sections(record).items()) + "\n")
    try:
        from . import pictures
    except ImportError:
        print("load: no matplotlib, no pictures (./dev setup bench)", file=sys.stderr)
        return
    pictures.all_of(record, (to or out) / "benchmarks")
