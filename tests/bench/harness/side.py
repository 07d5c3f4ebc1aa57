"""What is not a run of a contender: tightness of bounds, micro-benchmarks, facts about the machine."""
import csv
import io
import json
import os
import pathlib
import platform
import re
import subprocess
import sys
import time

from . import pairs
from .plan import TIGHTNESS_PAIR
from .progress import Progress

ROOT = pathlib.Path(__file__).resolve().parents[3]


def measure_tightness(programs, chosen, folder, sample):
    """Appends what tightness.csv does not have yet. The columns are bench_tightness's, and `meshes` before them."""
    if not programs.tightness.exists():
        print("bench: no bench_tightness, no tightness", file=sys.stderr)
        return
    path = folder / "tightness.csv"
    known = {row["meshes"] for row in tightness_rows(folder)}
    progress = Progress("tightness", len(chosen))
    for pair in chosen:
        meshes = pairs.content_hash(pair.a) + pairs.content_hash(pair.b)
        if meshes not in known:
            count = 1000 if pair.name == TIGHTNESS_PAIR else sample
            done = subprocess.run(
                [programs.tightness, pair.a, pair.b, "--pair", pair.name, "--sample", str(count)],
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode == 0:
                _append(path, meshes, list(csv.reader(io.StringIO(done.stdout))))
            else:
                print(f"bench: {pair.name}: {done.stderr.strip()}", file=sys.stderr)
        progress.step(pair.name, meshes not in known)
    progress.end()


def _append(path, meshes, rows):
    with path.open("a", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if file.tell() == 0:
            writer.writerow(["meshes", *rows[0]])
        writer.writerows([meshes, *row] for row in rows[1:])


def tightness_rows(folder):
    path = folder / "tightness.csv"
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def run_micro(build, folder, flags):
    program = pathlib.Path(build) / "tests/bench/engine_micro"
    if not program.exists():
        raise SystemExit("bench: no engine_micro: libbenchmark-dev is missing (./dev setup bench)")
    folder.mkdir(parents=True, exist_ok=True)
    out = folder / "micro.json"
    done = subprocess.run([program, f"--benchmark_out={out}", "--benchmark_out_format=json", *flags], check=False)
    if done.returncode != 0:
        raise SystemExit(done.returncode)
    # Google Benchmark also writes the machine's name and the program's path, which do not belong into a record.
    report = json.loads(out.read_text())
    for name in ("host_name", "executable"):
        report["context"].pop(name, None)
    out.write_text(json.dumps(report, indent=1) + "\n")


def micro_report(folder):
    path = folder / "micro.json"
    return json.loads(path.read_text()) if path.exists() else {}


def session_facts():
    """Facts about machine and sources, without anything that names the machine."""
    return {
        "session": time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime()),
        "processor": _processor(),
        "cores": cores(),
        "memory": _memory(),
        "kernel": platform.release().split("-")[0],
        "commit": _commit(),
        "cgal": _cgal(),
        "arguments": sys.argv[1:],
    }


def cores():
    return len(os.sched_getaffinity(0))


def _first(path, pattern):
    found = re.search(pattern, pathlib.Path(path).read_text(), re.MULTILINE)
    return found.group(1).strip() if found else "unknown"


def _processor():
    return " ".join(
        (
            _first("/proc/cpuinfo", r"^model name\s*: (.*)$"),
            "family",
            _first("/proc/cpuinfo", r"^cpu family\s*: (.*)$"),
            "model",
            _first("/proc/cpuinfo", r"^model\s*: (.*)$"),
        )
    )


def _memory():
    kib = int(_first("/proc/meminfo", r"^MemTotal:\s*([0-9]+)"))
    return f"{kib / (1 << 20):.0f} GiB"


def _commit():
    done = subprocess.run(
        ["git", "-C", ROOT, "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    return done.stdout.strip() or "unknown"


def _cgal():
    path = pathlib.Path("/usr/include/CGAL/version.h")
    return _first(path, r"^#define CGAL_VERSION (\S+)") if path.exists() else "none"
