#!/usr/bin/python3
"""Measures the service under load: docs/benchmarks.md, "Under load". `./dev load` builds what is needed."""
import argparse
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/bench"))  # its meshes, its tables

from harness import side  # noqa: E402
from loadtest import report, requests, soak  # noqa: E402
from loadtest.phases import Phases  # noqa: E402
from loadtest.service import Service  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(
        prog="./dev load", description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("verb", nargs="?", choices=("run", "report"), default="run", help="measure and report, or report")
    parser.add_argument("--quick", action="store_true", help="5 s a phase: does all of it work?")
    parser.add_argument("--pairs", default=",".join(requests.MIXES), metavar="A,B", help="of " + ", ".join(requests.MIXES))
    parser.add_argument("--multiples", default="0.5,1,2,10", metavar="X,Y", help="of the capacity, for the open loop")
    parser.add_argument("--seconds", type=float, metavar="S", help="of the heaviest phase, the others are shorter; 60, or 5 with --quick")
    parser.add_argument("--soak", type=float, metavar="MINUTES", help="instead: so long, and a tenth before, at a share of the capacity; fails if anything grows")
    parser.add_argument("--share", type=float, default=0.7, help="of the soak")
    parser.add_argument("--sources", type=int, default=64, help="addresses that the clients come from")
    parser.add_argument("--serve", default="", metavar="FLAGS", help="further flags of meshgauge serve")
    parser.add_argument("--key", help="bearer key that the requests carry")
    parser.add_argument("--out", type=pathlib.Path, metavar="FOLDER", help="the default is in build/load")
    parser.add_argument("--to", type=pathlib.Path, metavar="FOLDER", help="`docs` makes it the project's page")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help=argparse.SUPPRESS)
    args = parser.parse_args()
    for mix in args.pairs.split(","):
        if mix not in requests.MIXES:
            raise SystemExit(f"load: no such pairs: {mix}")
    args.seconds = args.seconds or (5 if args.quick else 60)
    args.out = args.out or args.build / "load" / ("quick" if args.quick else "record")
    return args


def say(run):
    print(
        f"load: {run['name']:22} {run['offered']:9.1f}/s offered {run['throughput']:8.1f}/s answered  "
        f"p99 {(run['p99'] or 0) * 1000:8.1f} ms  {run['refused']} refused  {run['others'] or ''}",
        file=sys.stderr,
    )


def load_of(mix, phases, files, args, record):
    """Closed loops find the capacity; open loops are multiples of it."""
    chosen = requests.arguments(files, mix)
    workers = record["workers"]
    closed = []
    for clients in sorted({1, workers, 2 * workers, 4 * workers}):
        run = phases.run(f"{mix}-closed-{clients}", mix, chosen, seconds=max(5, args.seconds / 4), warm_up=1, connections=clients)
        closed.append(run)
        say(run)
    capacity = max(run["throughput"] for run in closed)
    record["capacity"][mix] = capacity
    record["runs"] += closed
    for multiple in record["multiples"]:
        # The heaviest is the one that has to last.
        seconds = args.seconds if multiple == max(record["multiples"]) else max(5, args.seconds / 3)
        run = phases.run(f"{mix}-open-{multiple:g}x", mix, chosen, seconds=seconds, warm_up=seconds / 6, rate=multiple * capacity)
        run["multiple"] = multiple
        record["runs"].append(run)
        say(run)


def soak_of(phases, files, args, record):
    chosen = requests.arguments(files, "mixed")
    probe = phases.run("soak-capacity", "mixed", chosen, seconds=15, warm_up=3, connections=2 * record["workers"])
    say(probe)
    record["soak"] = soak.run(phases.client, phases.service, args.out, phases.settings, chosen, args.share * probe["throughput"], args.soak)


def saved(path):
    return json.loads(path.read_text()) if path.exists() else {}


def queue_of(binary, flags):
    """The limit of the comparisons that wait with their client; asynchronous ones have a limit of their own."""
    settings = subprocess.run([binary, "serve", "--print-config", *flags], check=True, capture_output=True, text=True).stdout
    return int(re.search(r"^queue = (\d+)$", settings, re.M)[1])


def split():
    """The processors of the service: all but one, which this process and its client keep; all where there is one."""
    *service, client = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {client})
    return service or [client]


def measure(args, path):
    args.out.mkdir(parents=True, exist_ok=True)
    files = requests.make(args.out / "requests", args.key)
    flags = [*(soak.KEPT if args.soak else ()), *shlex.split(args.serve)]
    log = args.out / "service.log"
    before, machine, processors = os.getloadavg()[0], side.session_facts(), split()
    service = Service(args.build / "meshgauge", flags, log, lambda: os.sched_setaffinity(0, processors))
    try:
        requests.store(service.port, args.key)
        numbers = service.numbers()
        workers, queue = int(numbers["meshgauge_workers"]), queue_of(args.build / "meshgauge", flags)
        record = {"machine": machine, "processors": processors, "flags": flags, "workers": workers, "places": workers + queue,
                  "load_before": before, "multiples": [float(m) for m in args.multiples.split(",")],
                  "capacity": {}, "runs": []}  # fmt: skip
        settings = {"sources": args.sources, "patience": 60, "seed": time.strftime("%Y%m%d")}
        phases = Phases(args.build / "tests/load/load_client", service, args.out, settings)
        if args.soak:
            # Beside the phases that were measured before.
            record = saved(path) or record
            record.setdefault("workers", workers)
            soak_of(phases, files, args, record)
        else:
            record["soak"] = saved(path).get("soak")
            for mix in args.pairs.split(","):
                load_of(mix, phases, files, args, record)
        path.write_text(json.dumps(record, indent=1) + "\n")
    finally:
        code = service.stop()
        log.unlink()  # a line for every request
    if code != 0:
        raise SystemExit(f"load: the service ended with {code}")
    return record


def main():
    args = arguments()
    path = args.out / "record.json"
    try:
        record = saved(path) if args.verb == "report" else measure(args, path)
    except KeyboardInterrupt:
        raise SystemExit("\nload: stopped") from None
    if not record:
        raise SystemExit(f"load: nothing measured in {args.out}")
    report.render(record, args.out, args.to, ROOT / "docs/benchmarks.md")
    print(f"load: {args.out / 'load.md'}", file=sys.stderr)
    if args.soak and (found := soak.faults(record["soak"])):
        raise SystemExit("\n".join(f"load: {fault}" for fault in found))


if __name__ == "__main__":
    main()
