"""Runs the rounds of a plan: interleaved, repeated, within limits, resumed."""
import json
import math
import os
import subprocess
import tempfile

from . import contenders, pairs, store
from .progress import Progress

SLOW_SECONDS = 10  # what takes longer is not repeated
KILL_AFTER_SECONDS = 60  # beyond the limit: for reading and preparing, which it does not count


class Campaign:
    def __init__(self, runs, programs, limits, repetitions, session):
        self.store, self.programs, self.limits = runs, programs, limits
        self.repetitions, self.session = repetitions, session
        self.done = runs.done()
        self.failed = set()  # (series, contender)

    def run(self, title, rounds):
        """A round is a list of jobs that are to be compared: each repetition runs all of them in turn."""
        progress = Progress(title, self.repetitions * sum(len(jobs) for jobs in rounds))
        for jobs in rounds:
            for repetition in range(self.repetitions):
                missing = not self._is_measured(jobs, repetition)
                turn = repetition % len(jobs)
                for job in jobs[turn:] + jobs[:turn]:  # so that no contender is always the first
                    ran = self._run(job, repetition, missing)
                    progress.step(f"{job.pair.name} {job.tolerance:g} {job.contender} {job.gate}", ran)
        progress.end()

    def _is_measured(self, jobs, repetition):
        """Whether all of a round was, in one session: from one to the next a machine's speed changes."""
        rows = [self._known(job).get(repetition) for job in jobs if not self._is_spared(job)]
        return None not in rows and len({row["session"] for row in rows}) <= 1

    def _known(self, job):
        return self.done.setdefault(store.key_of(self._identity(job)), {})

    def _run(self, job, repetition, missing):
        """Whether anything had to be measured."""
        known = self._known(job)
        ran = missing and not self._is_spared(job)
        if ran:
            known[repetition] = self.store.add({**self._identity(job), **self._measure(job), "repetition": repetition})
        if job.series and not all(map(_is_done, known.values())):
            self.failed.add((job.series, job.contender))
        return ran

    def _is_spared(self, job):
        if (job.series, job.contender) in self.failed:
            return True
        return any(not _is_done(row) or row["seconds"] > SLOW_SECONDS for row in self._known(job).values())

    def _identity(self, job):
        return {
            "experiment": job.experiment,
            "pair": job.pair.name,
            "meshes": pairs.content_hash(job.pair.a) + pairs.content_hash(job.pair.b),
            "contender": job.contender,
            "program": self.programs.hash_of(job.contender),
            "tolerance": job.tolerance,
            "gate": job.gate,
            "limits": job.limits(self.limits).text(),
        }

    def _measure(self, job):
        lower, upper = job.pair.reference or (None, None)
        row = {
            "session": self.session,
            "kind": job.pair.kind,
            "at": job.pair.at,
            "reference_lower": lower,
            "reference_upper": upper,
            "max_distance": None if math.isnan(job.max_distance) else job.max_distance,
            "load": os.getloadavg()[0],
        }
        limits = job.limits(self.limits)
        stdout, stderr, report = launch(self.programs, contenders.command(job, self.programs, limits), limits)
        row.update(
            wall=report["wall_seconds"],
            user=report["user_seconds"],
            system=report["system_seconds"],
            peak_bytes=report["peak_bytes"],
        )
        row.update(contenders.outcome(job, self.programs, stdout, stderr, report))
        return row


def _is_done(row):
    return row["status"] in (*contenders.FINISHED, contenders.SAMPLED)


def launch(programs, command, limits):
    """(stdout, stderr, report of bench_launch)"""
    with tempfile.TemporaryDirectory(prefix="bench") as folder:
        report = os.path.join(folder, "report.json")
        done = subprocess.run(
            [str(programs.launch), str(limits.seconds + KILL_AFTER_SECONDS), str(limits.bytes), report, *command],
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        if done.returncode != 0:
            raise SystemExit(f"bench: bench_launch failed: {done.stderr.strip()}")
        with open(report, encoding="utf-8") as file:
            return done.stdout, done.stderr, json.load(file)
