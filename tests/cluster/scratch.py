#!/usr/bin/env python3
"""A private folder for processes that must not outlive their test, and what such processes need."""

import atexit
import contextlib
import os
import pwd
import random
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "build" / "tools"  # where ./dev unpacks programs instead of installing them


def servant():
    """The user for programs that refuse to run as root: arguments of subprocess.Popen, none when we are not root."""
    if os.geteuid() != 0:
        return {}
    for name in ("postgres", "nobody"):
        with contextlib.suppress(KeyError):
            entry = pwd.getpwnam(name)
            return {"user": entry.pw_uid, "group": entry.pw_gid, "extra_groups": []}
    raise AssertionError("root must run this as another user, such as 'postgres' or 'nobody', which the machine lacks")


def own(path):
    """Gives a folder to the servant."""
    user = servant()
    if user:
        os.chown(path, user["user"], user["group"])
    return path


def within_reach(scratch, base, *parts):
    """`base`, or where it is closed to the servant a folder with copies of these parts of it."""
    if subprocess.run(["/usr/bin/test", "-r", base / parts[0]], cwd="/", **servant()).returncode == 0:
        return base
    for part in parts:
        source, copy = base / part, scratch.path / "copies" / part
        copy.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if source.is_dir() else shutil.copy)(source, copy)
    return scratch.path / "copies"


def ports_to_take(handed_out):
    """Ports that the system does not hand out by itself, so that no program takes one while its process is down.

    Any port, where the system hands out almost all: there are so many that a clash is not probable.
    """
    lowest, highest = handed_out
    below, above = range(10000, lowest), range(highest + 1, 65536)
    return next((ports for ports in (below, above) if len(ports) >= 1000), range(10000, 65536))


def free_port():
    ports = ports_to_take(map(int, Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()))
    for _ in range(1000):
        port = random.SystemRandom().choice(ports)
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise AssertionError("no free port")


def inside(folder):
    """The processes whose working directory is this folder or in it."""
    found, folder = [], str(folder)
    for entry in os.scandir("/proc"):
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                place = os.readlink(entry.path + "/cwd").removesuffix(" (deleted)")
                if place == folder or place.startswith(folder + "/"):
                    found.append(int(entry.name))
    return sorted(found)


def signal_inside(folder, sign):
    for process in inside(folder):
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, sign)


def end_inside(folder):
    """kill -9, until there is none: one may have begun another meanwhile."""
    end = time.monotonic() + 30
    while inside(folder):
        signal_inside(folder, signal.SIGKILL)
        assert time.monotonic() < end, "processes that cannot be killed"
        time.sleep(0.01)


class Scratch:
    """A folder, `path`. When it is closed, or its maker is gone, the processes in it are killed and it is removed.

    Every process that belongs to it is started with a working directory in it.
    """

    def __init__(self):
        of_mine = tempfile.gettempdir()  # may be closed to the servant
        where = "/tmp" if servant() and not os.stat(of_mine).st_mode & stat.S_ISVTX else None
        self.path = Path(own(tempfile.mkdtemp(prefix="meshgauge-cluster-", dir=where))).resolve()
        self.guard = subprocess.Popen([sys.executable, __file__, str(self.path)], stdin=subprocess.PIPE, cwd="/",
                                      stdout=subprocess.DEVNULL, start_new_session=True)
        atexit.register(self.close)

    def folder(self, name):
        path = self.path / name
        path.mkdir(mode=0o700)
        return Path(own(path))

    def close(self):
        atexit.unregister(self.close)
        if self.guard.poll() is None:
            self.guard.stdin.close()
            self.guard.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def guard(folder):
    """Waits for the end of the maker, however it comes, and cleans up behind it."""
    sys.stdin.buffer.read()
    end_inside(folder)
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    guard(sys.argv[1])
