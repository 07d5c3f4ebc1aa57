#!/usr/bin/env python3
"""All pairs of the corpus as one manifest, measured by `meshgauge check` in process and by a service.

usage: corpus_gates.py [--most-triangles N] [--server] [--keep FOLDER] MESHGAUGE

Each pair is a gate with 1.01 times the upper end of reference.tsv, which must pass, and one with 0.99 times the lower
end, which must fail. With --server the same gates go through a service started for it, and every comparison must be the
same but for its id and its times. The corpus: environment variable MESHGAUGE_CORPUS. Exit 77 without one.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

CORPUS = pathlib.Path(os.environ.get("MESHGAUGE_CORPUS", "../shared/corpus"))
SKIPPED = 77
# The service is on this machine: no proxy stands between.
for variable in [name for name in os.environ if name.lower().endswith("_proxy")]:
    del os.environ[variable]
MOST_TOLD = 30  # problems


def rows(name):
    lines = (CORPUS / name).read_text().splitlines()
    return [line.split("\t") for line in lines if line and not line.startswith("#")]


def made(recipe, name, folder):
    """`gen:PROGRAM MESH ARGUMENT` is made by scripts/PROGRAM.py of the corpus."""
    program, mesh, argument = recipe[len("gen:"):].split()
    out = folder / (name.replace("/", "_") + ".obj")
    subprocess.run([sys.executable, CORPUS / "scripts" / (program + ".py"), CORPUS / mesh, argument, out], check=True,
                   stdout=subprocess.DEVNULL)
    return out


def gates_of(row, reference, folder):
    """(name, candidate, baseline, limit, verdict that is due)"""
    name, a, b, *_ = row
    _, lower, upper = map(float, reference[1:4])
    candidate = CORPUS / a
    baseline = made(b, name, folder) if b.startswith("gen:") else CORPUS / b
    yield name + " above", candidate, baseline, 1.01 * upper, "pass"
    if lower > 0:
        yield name + " below", candidate, baseline, 0.99 * lower, "fail"


def all_gates(most_triangles, folder):
    references = {row[0]: row for row in rows("reference.tsv")}
    chosen = [row for row in rows("pairs.tsv") if int(row[4]) + int(row[5]) <= most_triangles]
    return [gate for row in chosen for gate in gates_of(row, references[row[0]], folder)]


def write_manifest(gates, path):
    """The direction is that of reference.tsv. Numbers in all digits; one thread a gate, so that bits can be compared."""
    lines = ["version: 1", "defaults: {direction: candidate_to_baseline, timeout: 60 s, threads: 1}", "gates:"]
    for name, candidate, baseline, limit, _ in gates:
        lines += ["  - name: " + json.dumps(name), "    candidate: " + json.dumps(str(candidate.resolve())),
                  "    baseline: " + json.dumps(str(baseline.resolve())), "    max_distance: %r" % limit]
    path.write_text("\n".join(lines) + "\n")


def run(binary, manifest, out, *flags):
    start = time.monotonic()
    done = subprocess.run([binary, "check", manifest, "--quiet", "--fast", "--json=%s" % out, *flags], capture_output=True,
                          text=True, check=False)
    seconds = time.monotonic() - start
    if not out.exists():
        sys.exit("check ended with %d and without a report:\n%s" % (done.returncode, done.stderr))
    report = json.loads(out.read_text())
    print("%s: %d gates in %.1f s, %s" % (out.stem, len(report["gates"]), seconds, report["counts"]), flush=True)
    return report


def verdict_problems(gates, report, where):
    problems = []
    for (name, *_, due), gate in zip(gates, report["gates"], strict=True):
        if (gate["name"], gate["verdict"]) != (name, due):
            problems.append("%s: %s: %s instead of %s: %s, %s" % (where, name, gate["verdict"], due, gate["distance"],
                                                                  gate["advice"]))
    return problems


def steady(gate):
    """What must be the same whether this process or a service measured."""
    comparison = {k: v for k, v in (gate["comparison"] or {}).items() if k not in ("id", "timings_ms")}
    return {**{k: v for k, v in gate.items() if k not in ("wall_ms", "link")}, "comparison": comparison}


def differences(one, other):
    for a, b in zip(one["gates"], other["gates"], strict=True):
        a, b = steady(a), steady(b)
        if a != b:
            members = [k for k in a if a[k] != b[k]]
            members += [k for k in a["comparison"] if a["comparison"].get(k) != b["comparison"].get(k)]
            yield "%s: in process and through the service differ in %s" % (a["name"], ", ".join(members))


class Service:
    """A service on a free port, without keys."""

    def __init__(self, binary, folder):
        kept = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_")}
        self.process = subprocess.Popen([binary, "serve", "--port", "0", "--data-dir", folder / "data"], env=kept,
                                        text=True, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        started = json.loads(self.process.stderr.readline())
        self.url = "http://127.0.0.1:" + started["detail"].rsplit(":", 1)[1]

    def __enter__(self):
        threading.Thread(target=lambda: list(self.process.stderr), daemon=True).start()  # its log must not fill the pipe
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(60)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--most-triangles", type=int, default=10**9, help="of both meshes of a pair")
    parser.add_argument("--server", action="store_true")
    parser.add_argument("--keep", type=pathlib.Path, help="where the manifest and the reports stay")
    parser.add_argument("binary")
    arguments = parser.parse_args()
    if not (CORPUS / "pairs.tsv").exists():
        print("SKIP: no corpus: set MESHGAUGE_CORPUS")
        return SKIPPED
    with tempfile.TemporaryDirectory() as temporary:
        folder = (arguments.keep or pathlib.Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        gates = all_gates(arguments.most_triangles, folder)
        manifest = folder / "corpus.yaml"
        write_manifest(gates, manifest)
        here = run(arguments.binary, manifest, folder / "in_process.json")
        problems = verdict_problems(gates, here, "in process")
        if arguments.server:
            with Service(arguments.binary, folder) as service:
                there = run(arguments.binary, manifest, folder / "service.json", "--server", service.url)
            problems += verdict_problems(gates, there, "service")
            problems += differences(here, there)
    print("\n".join(problems[:MOST_TOLD]))
    print("%d problems" % len(problems) if problems else "every verdict is right" + (", and both say the same" if arguments.server else ""))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
