"""Renders docs/benchmarks.md: the prose is written by hand, what stands between two markers is made of the figures.

    <!-- figures: NAME -->
    ...
    <!-- end -->
"""
import csv
import math
import re
import sys

from . import paper, series_tables, side, store, tables, targets, text
from .results import Results

MARKED = re.compile(r"(<!-- figures: (\w+) -->\n)(?:(?!<!--).)*(<!-- end -->)", re.DOTALL)
NO_RECORD = "*No record of runs made elsewhere was given (`--rival-record`).*"
PAGE = side.ROOT / "docs/benchmarks.md"


def fragments(results, folder, sessions, record=None):
    made = {
        name: (lambda make=make: make(results))
        for name, make in {
            "targets": targets.table,
            "mixed": tables.mixed,
            "finished": tables.finished,
            "process": tables.process,
            "speedups": tables.speedups,
            "by_kind": tables.by_kind,
            "losses": tables.losses,
            "failures": tables.failures,
            "samples": tables.samples,
            "table1": paper.table1,
            "placement": lambda results: paper.stage_table(results, "placement"),
            "resolution": lambda results: paper.stage_table(results, "resolution"),
            "subdivisions": paper.subdivisions,
            "sharing": paper.sharing,
            "gate": series_tables.gate,
            "growth": series_tables.growth,
            "zero": series_tables.zero,
            "memory": series_tables.memory,
            "tolerance": series_tables.tolerance,
            "reading": series_tables.reading,
        }.items()
    }
    made["rivals"] = lambda: record.table() if record else NO_RECORD
    made["rivals_by_kind"] = lambda: record.by_kind() if record else NO_RECORD
    made["machine"] = lambda: tables.machine(results, sessions)
    made["micro"] = lambda: series_tables.micro(side.micro_report(folder))
    made["distances"] = lambda: paper.distances(side.micro_report(folder))
    made["tightness"] = lambda: paper.tightness(side.tightness_rows(folder))
    return made


def fill(page, made):
    def replace(match):
        if match[2] not in made:
            raise SystemExit(f"bench: docs/benchmarks.md asks for figures that nothing makes: {match[2]}")
        figures = text.with_handicap(made[match[2]]())
        return match[1] + text.wrapped(figures) + "\n" + match[3]

    return MARKED.sub(replace, page)


def render(folder, to, record=None):
    """Writes TO/benchmarks.md from the runs in `folder`, and into TO/benchmarks/ pictures, every pair and every result."""
    runs = store.Store(folder).open()
    if not runs.rows:
        raise SystemExit(f"bench: no runs in {folder}")
    results = Results(runs.rows)
    aside = to / "benchmarks"
    aside.mkdir(parents=True, exist_ok=True)
    (to / "benchmarks.md").write_text(fill(PAGE.read_text(), fragments(results, folder, runs.sessions(), record)))
    (aside / "pairs.md").write_text(tables.all_pairs(results))
    _write_results(results, aside / "results.csv")
    _draw(results, folder, aside)
    print(f"bench: {to / 'benchmarks.md'}", file=sys.stderr)
    return results


RESULT_COLUMNS = (
    "experiment",
    "pair",
    "contender",
    "tolerance",
    "gate",
    "status",
    "repetitions",
    "seconds",
    "spread",
    "build",
    "traverse",
    "reduce",
    "read_a",
    "read_b",
    "wall",
    "user",
    "peak_bytes",
    "triangles_a",
    "triangles_b",
    "survivors",
    "culling",
    "queries",
    "cache_hits",
    "subdivisions",
    "lower",
    "upper",
    "threads",
    "simd",
)


# Columns of more than four digits.
_WHOLE = ("lower", "upper", "peak_bytes", "triangles_a", "triangles_b", "survivors", "queries", "cache_hits", "subdivisions")


def _write_results(results, path):
    """Every result, its times to four digits; runs.csv, where the runs are, has all."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, RESULT_COLUMNS, lineterminator="\n", extrasaction="ignore")
        writer.writeheader()
        for by_name in [*results.cases.values(), *results.samplers.values()]:
            for result in by_name.values():
                row = result.best | {
                    "status": result.status,
                    "repetitions": len(result.rows),
                    "peak_bytes": result.peak_bytes(),
                    "spread": result.spread if result.finished else None,
                    "culling": None if math.isnan(result.culling()) else result.culling(),
                }
                writer.writerow({name: _short(name, row[name]) for name in RESULT_COLUMNS})


def _short(name, value):
    return (
        f"{value:.12g}"
        if name in _WHOLE and value is not None
        else f"{value:.4g}"
        if isinstance(value, float)
        else value
    )


def _draw(results, folder, aside):
    try:
        from . import plots
    except ImportError:
        print("bench: no matplotlib, no pictures (./dev setup bench)", file=sys.stderr)
        return
    drawn = plots.all_of(results, side.tightness_rows(folder), aside)
    print(f"bench: {len(drawn)} pictures in {aside}", file=sys.stderr)
