"""The service under load: its start, its metrics, and samples of all its processes."""
import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import threading
import time
import urllib.request


class Service:
    def __init__(self, binary, flags, log, before_start=None):
        """`before_start` is called in the new process."""
        self.log = log.open("w+")
        self.data = tempfile.TemporaryDirectory(dir=log.parent)
        environment = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_")}
        self.process = subprocess.Popen([binary, "serve", "--port", "0", "--data-dir", self.data.name, *flags], stderr=self.log, env=environment, preexec_fn=before_start)
        self.port = self._port(log)

    def _port(self, log):
        for _ in range(600):
            for line in log.read_text().splitlines():
                with contextlib.suppress(ValueError, KeyError):
                    event = json.loads(line)
                    if event["event"] == "listening":
                        return int(event["detail"].rsplit(":", 1)[1])
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise SystemExit(f"load: the service did not start:\n{log.read_text()}")

    def numbers(self):
        """{sample: value} of /metrics."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/metrics", timeout=30) as answer:
            text = answer.read().decode()
        return {name: float(value) for name, value in re.findall(r"^([^#\s]\S*) (\S+)$", text, re.M)}

    def is_idle(self):
        now = self.numbers()
        return (
            now["meshgauge_queue_depth"] == 0
            and now["meshgauge_jobs_running"] == 0
            and now["meshgauge_upload_bytes"] == 0
            and now["meshgauge_connections"] <= 1  # this one
        )

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(60)
        self.log.close()
        self.data.cleanup()
        return code


def family(pid):
    """The process and all that come from it."""
    children = {}
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
                children.setdefault(int(fields[1]), []).append(int(entry.name))
    found = [pid]
    for parent in found:
        found += children.get(parent, [])
    return found


def _number(path, name):
    with contextlib.suppress(OSError):
        match = re.search(rf"^{name}:\s+(\d+) kB", path.read_text(), re.M)
        return int(match[1]) * 1024 if match else 0
    return 0


def _memory(pid):
    """What processes share is counted once; files are left out, whose pages other programs share and let go."""
    return sum(_number(pathlib.Path(f"/proc/{pid}/smaps_rollup"), f"Pss_{kind}") for kind in ("Anon", "Shmem"))


def look(pid):
    """Memory of all processes and of the service alone; descriptors, threads and processor time of the service."""
    processes = family(pid)
    ticks = (pathlib.Path(f"/proc/{pid}/stat").read_text()).rsplit(")", 1)[1].split()
    return {
        "alone": _memory(pid),
        "memory": sum(map(_memory, processes)),
        "descriptors": len(os.listdir(f"/proc/{pid}/fd")),
        "threads": len(os.listdir(f"/proc/{pid}/task")),
        "processes": len(processes),
        "cpu": (int(ticks[11]) + int(ticks[12])) / os.sysconf("SC_CLK_TCK"),
    }


class Watch:
    """Samples the service every `period` seconds, on a thread, while a block runs. `more()` adds to each sample."""

    def __init__(self, pid, period=1.0, more=dict):
        self.pid, self.period, self.more = pid, period, more
        self.rows = []
        self._end = threading.Event()

    def __enter__(self):
        self._start = time.monotonic()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join()

    def _run(self):
        while True:
            with contextlib.suppress(OSError):
                self.rows.append({"at": time.monotonic() - self._start, **look(self.pid), **self.more()})
            if self._end.wait(self.period):
                return

    def most(self, what):
        return max((row[what] for row in self.rows), default=0)
