#!/usr/bin/python3
"""Measures meshgauge against its baselines and CGAL: docs/benchmarks.md. `./dev bench` builds what is needed."""
import argparse
import fnmatch
import os
import pathlib
import sys

from harness import campaign, contenders, page, pairs, plan, rivals, side, store
from harness.contenders import Limits

ROOT = pathlib.Path(__file__).resolve().parents[2]


def arguments():
    parser = argparse.ArgumentParser(
        prog="./dev bench", description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument(
        "verb",
        nargs="?",
        choices=("run", "report", "micro"),
        default="run",
        help="measure and report; report again from the runs there are; Google Benchmark's micro-benchmarks",
    )
    parser.add_argument(
        "--quick", action="store_true", help="small made meshes, one repetition, 5 s a run: does all of it work?"
    )
    parser.add_argument(
        "--pairs",
        type=pathlib.Path,
        metavar="FOLDER",
        help="instead of the corpus: a folder with pairs.tsv, or with one sub-folder a pair of two meshes",
    )
    parser.add_argument("--only", metavar="GLOB", help="pairs whose name matches")
    parser.add_argument("--experiments", metavar="A,B", help="of " + ", ".join((*plan.EXPERIMENTS, "tightness")))
    parser.add_argument(
        "--contenders",
        metavar="A,B",
        help="STRATEGY[@THREADS][+SIMD] or cgal; the default is auto, auto on all cores, "
        "four_point, triangle_set, cgal",
    )
    parser.add_argument(
        "--rival",
        action="append",
        default=[],
        metavar="NAME=COMMAND",
        help="a contender more: called with A.obj B.obj TOLERANCE LIMIT_S, prints one line of JSON (docs/benchmarks.md)",
    )
    parser.add_argument(
        "--rival-record",
        type=pathlib.Path,
        metavar="FILE",
        help="a table of runs of rivals that were made elsewhere, to be shown on the page (docs/benchmarks.md)",
    )
    parser.add_argument(
        "--repetitions", type=int, metavar="N", help="the default is 3; what takes 10 s is not repeated"
    )
    parser.add_argument("--limit-seconds", type=float, metavar="S", help="of one run; the default is 60")
    parser.add_argument("--limit-gib", type=float, default=6, metavar="G", help="address space of one run")
    parser.add_argument(
        "--out", type=pathlib.Path, metavar="FOLDER", help="runs and report; the default is in build/bench"
    )
    parser.add_argument(
        "--fresh", action="store_true", help="forget the runs there are; without it a stopped benchmark goes on"
    )
    parser.add_argument(
        "--to", type=pathlib.Path, metavar="FOLDER", help="where the report goes; `docs` makes it the project's page"
    )
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help=argparse.SUPPRESS)
    return parser.parse_known_args()


def listed(text, known, what):
    names = text.split(",")
    for name in names:
        if not known(name):
            raise SystemExit(f"bench: no such {what}: {name}")
    return names


def chosen_contenders(args, programs):
    cores = side.cores()
    names = [
        "auto",
        *([f"auto@{n}" for n in sorted({2, cores})] if cores > 1 else []),
        "four_point",
        "triangle_set",
        "cgal",
    ]
    if args.contenders:
        names = listed(args.contenders, lambda name: contenders.is_name(name) or name in programs.rivals, "contender")
    names += [name for name in programs.rivals if name not in names]
    for name in names:
        if not programs.has(name):
            print(f"bench: {programs.of(name)} is not built: no {name}", file=sys.stderr)
    return [name for name in names if programs.has(name)]


def chosen_pairs(args, made, profile):
    """The pairs of the corpus or of the given folder; without both, a few that the harness makes."""
    corpus = pathlib.Path(os.environ.get("MESHGAUGE_CORPUS", ROOT / "../shared/corpus"))
    if args.pairs:
        if not args.pairs.is_dir():
            raise SystemExit(f"bench: {args.pairs} is no folder (a relative path starts at {pathlib.Path.cwd()})")
        found = pairs.in_folder(args.pairs, made.folder)
    elif args.quick or not (corpus / "pairs.tsv").exists():
        found = [made.near(n) for n in profile.sizes[:5]] + [
            made.placed(profile.placement_size, d) for d in profile.displacements[:3]
        ]
    else:
        found = pairs.in_folder(corpus, made.folder)
    found = [pair for pair in found if not args.only or fnmatch.fnmatch(pair.name, args.only)]
    if not found:
        raise SystemExit("bench: no pairs")
    return found


def chosen_experiments(args):
    every = [*plan.EXPERIMENTS, "tightness"]
    if args.experiments:
        return listed(args.experiments, every.__contains__, "experiment")
    # With named pairs the generated series are left out.
    return ["pairs", "gate"] if args.pairs or args.only else every


def run(args, out):
    programs = contenders.Programs(args.build, [rivals.parsed(text, contenders.is_own) for text in args.rival])
    profile = plan.QUICK if args.quick else plan.Profile()
    limits = Limits(args.limit_seconds or (5 if args.quick else 60), int(args.limit_gib * (1 << 30)))
    runs = store.Store(out)
    if args.fresh:
        runs.path.unlink(missing_ok=True)
        (out / "tightness.csv").unlink(missing_ok=True)
    runs.open()
    facts = side.session_facts()
    runs.add_session(facts)
    made = pairs.Made(args.build / "bench/meshes", programs.obj_files)
    chosen = chosen_pairs(args, made, profile)
    measured = campaign.Campaign(runs, programs, limits, args.repetitions or (1 if args.quick else 3), facts["session"])
    schedule = plan.Plan(profile, chosen, made, chosen_contenders(args, programs), side.cores(), runs)
    for experiment in chosen_experiments(args):
        if experiment == "tightness":
            small = [
                pair
                for pair in sorted(chosen, key=lambda pair: pair.name != plan.TIGHTNESS_PAIR)
                if pair.a.stat().st_size + pair.b.stat().st_size <= profile.most_bytes_of_tightness
            ]
            side.measure_tightness(programs, small, out, profile.tightness_sample)
        else:
            measured.run(experiment, schedule.rounds(experiment))


def main():
    args, rest = arguments()
    if rest and args.verb != "micro":
        raise SystemExit(f"bench: unknown arguments: {' '.join(rest)}")
    name = "quick" if args.quick else args.pairs.resolve().name if args.pairs else "record"
    out = args.out or args.build / "bench" / name
    if args.verb == "micro":
        side.run_micro(args.build, out, rest)
        return
    if args.verb == "run":
        try:
            run(args, out)
        except KeyboardInterrupt:
            raise SystemExit("\nbench: stopped; the same command goes on from here") from None
    page.render(out, args.to or out, args.rival_record and rivals.Record.read(args.rival_record))


if __name__ == "__main__":
    main()
