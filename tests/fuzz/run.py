#!/usr/bin/python3
"""Runs fuzz targets: ./dev fuzz NAME|all [--seconds N] [--jobs J], which builds them first.

N seconds of a processor are spread evenly over the targets, J of which run at once: beside other work a run takes longer, and
tries as much. What a target has learned is kept in build/fuzz/corpus/NAME
and used again; what breaks it goes to build/fuzz/found/NAME, made as small as possible. Prints a table for docs/fuzzing.md; exit
code 1 when something was found.
"""
import argparse
import concurrent.futures
import contextlib
import dataclasses
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = ROOT / "build-fuzz/tests/fuzz/targets"
KEPT = ROOT / "build/fuzz"
DICTIONARIES = ROOT / "tests/fuzz/targets/dictionaries"
FOUND = ROOT / "tests/fuzz/found"  # earlier findings

MOST_BYTES = 1 << 14  # of an input: no reader has a limit that a larger one would reach
# What an input may cost. The sanitizers alone take some 100 MB, and make everything several times slower.
LIMITS = ["-timeout=10", "-rss_limit_mb=1024", "-malloc_limit_mb=256"]
MINIMISE_SECONDS = 30
INTERRUPTED = 72  # libFuzzer's exit code after SIGINT


@dataclasses.dataclass
class Target:
    name: str
    dictionaries: list[str]
    corpus: list[str]  # ends of file names

    @property
    def program(self):
        return BUILT / f"fuzz_{self.name}"


@dataclasses.dataclass
class Run:
    target: Target
    seconds: float
    executions: int
    edges: int
    inputs: int
    peak_mb: int
    findings: list[pathlib.Path]
    failed: bool


def targets():
    lines = (BUILT / "targets.tsv").read_text().splitlines()
    rows = [line.split("\t") for line in lines]
    return [Target(name, *([item for item in cell.split(";") if item] for cell in cells)) for name, *cells in rows]


def write_dictionary(target):
    """The target's dictionaries as one file: libFuzzer takes one."""
    path = KEPT / f"{target.name}.dict"
    path.write_text("".join((DICTIONARIES / f"{name}.dict").read_text() for name in target.dictionaries))
    return path


def write_seed_list(target):
    """Seeds, earlier findings and the corpus' files, by name: nothing is copied."""
    files = [*(BUILT / "seeds" / target.name).glob("*"), *(FOUND / target.name).glob("*")]
    corpus = os.environ.get("MESHGAUGE_CORPUS")
    for folder in ("formats", "formats/real", "malformed", "malformed/real", "wild/*") if corpus else ():
        for file in sorted(pathlib.Path(corpus).glob(folder + "/*")):
            if file.name.lower().endswith(tuple(target.corpus)) and 0 < file.stat().st_size <= MOST_BYTES:
                files.append(file)
    path = KEPT / f"{target.name}.seeds"
    path.write_text(",".join(map(str, files)))
    return path


def environment():
    env = dict(os.environ)
    env["ASAN_OPTIONS"] = "quarantine_size_mb=32:" + env.get("ASAN_OPTIONS", "")
    env["UBSAN_OPTIONS"] = "print_stacktrace=1:" + env.get("UBSAN_OPTIONS", "")
    env.setdefault("ASAN_SYMBOLIZER_PATH", "/usr/bin/llvm-symbolizer-14")
    return env


def last_number(pattern, log, otherwise=0):
    found = re.findall(pattern, log)
    return int(found[-1]) if found else otherwise


def minimised(target, finding):
    """The smallest input that still breaks the target; a time-out or too much memory stays as it is."""
    smaller = finding.with_name(finding.name + ".min")
    # Each step that succeeds starts its time anew: the last one is ended.
    with contextlib.suppress(subprocess.TimeoutExpired):
        subprocess.run([target.program, *LIMITS, "-minimize_crash=1", f"-max_total_time={MINIMISE_SECONDS}",
                        f"-exact_artifact_path={smaller}", finding],
                       env=environment(), capture_output=True, check=False, timeout=3 * MINIMISE_SECONDS)
    return smaller if smaller.exists() else finding


def processor_seconds(process):
    """What a process that has not been waited for has used."""
    user, system = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def interrupt_after(program, seconds):
    """Interrupts a program that has used so many seconds of a processor, waits for its end, and returns what it used."""
    while os.waitid(os.P_PID, program.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
        if processor_seconds(program.pid) >= seconds:
            program.send_signal(signal.SIGINT)
            os.waitid(os.P_PID, program.pid, os.WEXITED | os.WNOWAIT)
        time.sleep(0.5)
    used = processor_seconds(program.pid)
    program.wait()
    return used


def fuzz(target, seconds):
    corpus, found = KEPT / "corpus" / target.name, KEPT / "found" / target.name
    for folder in (corpus, found):
        folder.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    command = [target.program, *LIMITS, f"-max_len={MOST_BYTES}", "-print_final_stats=1",
               f"-artifact_prefix={found}/", f"-seed_inputs=@{write_seed_list(target)}"]
    if target.dictionaries:
        command.append(f"-dict={write_dictionary(target)}")
    path = KEPT / f"{target.name}.log"
    with path.open("wb") as log:
        program = subprocess.Popen([*command, corpus], env=environment(), stdout=log, stderr=subprocess.STDOUT)
        used = interrupt_after(program, seconds)
    log = path.read_text(errors="replace")
    findings = [minimised(target, path) for path in sorted(set(found.iterdir()) - before) if not path.name.startswith("slow-")]
    return Run(target, used, last_number(r"stat::number_of_executed_units:\s*(\d+)", log),
               last_number(r" cov: (\d+) ", log), last_number(r" corp: (\d+)/", log),
               last_number(r"stat::peak_rss_mb:\s*(\d+)", log), findings, program.returncode not in (0, INTERRUPTED))


def report(run):
    print(f"{run.target.name}: {run.executions} runs in {run.seconds:.0f} s", file=sys.stderr)
    if not run.failed:
        return
    print(f"{run.target.name} ended by itself; its log is {(KEPT / run.target.name).relative_to(ROOT)}.log", file=sys.stderr)
    for path in run.findings:
        program = run.target.program.relative_to(ROOT)
        print(f"  found: {path.relative_to(ROOT)}; again by\n    {program} {path.relative_to(ROOT)}", file=sys.stderr)


def table(runs):
    print("| target | seconds | runs | runs/s | edges | inputs kept | peak MB | found |\n|---|--:|--:|--:|--:|--:|--:|--:|")
    for run in runs:
        print(f"| {run.target.name} | {run.seconds:.0f} | {run.executions:,} | {run.executions / run.seconds:,.0f} | {run.edges:,} "
              f"| {run.inputs:,} | {run.peak_mb} | {len(run.findings)} |")
    print(f"| all | {sum(run.seconds for run in runs):,.0f} | {sum(run.executions for run in runs):,} | | | | "
          f"| {sum(len(run.findings) for run in runs)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", help="a target, or all")
    parser.add_argument("--seconds", type=int, default=60, help="of a processor, spread over the targets (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="targets at once (default: one a processor)")
    arguments = parser.parse_args()
    chosen = [target for target in targets() if arguments.name in ("all", target.name)]
    seconds = max(1, arguments.seconds // len(chosen))
    KEPT.mkdir(parents=True, exist_ok=True)
    runs = []
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for run in pool.map(lambda target: fuzz(target, seconds), chosen):
            report(run)
            runs.append(run)
    table(runs)
    return 1 if any(run.failed for run in runs) else 0


if __name__ == "__main__":
    sys.exit(main())
