"""What faults.cpp counts and is told, and how its places are named."""

import errno
import mmap
import os
import struct
import subprocess
from pathlib import Path

import victim

SHIM = os.environ.get("MESHGAUGE_FAULTS_LIBRARY", str(victim.ROOT / "build/tests/chaos/libfaults.so"))
KINDS = ("read", "write", "sync", "map", "rename", "allocation", "thread", "connect")
ERRORS = {"read": errno.EIO, "write": errno.ENOSPC, "sync": errno.EIO, "map": errno.ENOMEM, "rename": errno.EIO,
          "allocation": errno.ENOMEM, "thread": errno.EAGAIN, "connect": errno.ECONNREFUSED}
ORDERS = struct.Struct("iiiiqQq8q")
SITE = struct.Struct("QiiQ")
SITES = 1 << 14


class Faults:
    """The orders to the shim, and what it counts."""

    def __init__(self, path):
        path.write_bytes(bytes(ORDERS.size + SITES * SITE.size))
        with open(path, "r+b") as file:
            self.table = mmap.mmap(file.fileno(), 0)
        self.path = path
        self.process = 0

    def _write(self, kind, error=0, lasting=0, after=0, place=0):
        struct.pack_into("i", self.table, 4, -1)  # first: the others belong together
        struct.pack_into("iiqQq", self.table, 8, error, lasting, after, place, 0)
        struct.pack_into("i", self.table, 0, self.process)
        struct.pack_into("i", self.table, 4, kind)

    def watch(self, process):
        """-1: every process that loads the shim and the file, from its first call on."""
        self.process = process
        self._write(-1)

    def fail(self, kind, lasting, after=0, place=0):
        self._write(KINDS.index(kind), ERRORS[kind], int(lasting), after, place)

    def failed(self):
        """How many calls have failed by the newest orders."""
        return ORDERS.unpack_from(self.table)[6]

    def calls(self):
        """How many calls of each kind the process has made."""
        return dict(zip(KINDS, ORDERS.unpack_from(self.table)[7:]))

    def lift(self):
        struct.pack_into("i", self.table, 4, -1)

    def points(self):
        """The places seen so far: (kind, place) to calls."""
        sites = (SITE.unpack_from(self.table, ORDERS.size + i * SITE.size) for i in range(SITES))
        return {(KINDS[kind], place): calls for place, kind, failed, calls in sites if place}


class Maps:
    """Where the program and its libraries lie in a process."""

    def __init__(self, process):
        self.maps = []  # begin, end, offset in the file, file
        for line in Path("/proc/%d/maps" % process).read_text().splitlines():
            fields = line.split()
            if len(fields) > 5:
                self.maps.append((*(int(one, 16) for one in fields[0].split("-")), int(fields[2], 16), fields[5]))

    def name_of(self, place):
        """file+offset and function of a place."""
        for begin, end, at, path in self.maps:
            if begin <= place < end:
                offset = place - begin + at
                names = subprocess.run(["addr2line", "-Cfpie", path, hex(offset - 1)], capture_output=True, text=True, check=False)
                return "%s+%x %s" % (Path(path).name, offset, names.stdout.splitlines()[0][:160] if names.stdout else "")
        return hex(place)

    def place_of(self, name, offset):
        """The place of file+offset; None: the file is not there."""
        return next((begin + offset - at for begin, end, at, path in self.maps
                     if Path(path).name == name and at <= offset < at + end - begin), None)
