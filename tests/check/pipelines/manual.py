"""docs/ci.md and the README's part about pipelines as what they show: scripts, files and tables."""

import functools
import hashlib
import http.server
import io
import json
import os
import pathlib
import platform
import re
import shlex
import struct
import tarfile
import threading
from dataclasses import dataclass

from harness import BINARY, ENVIRONMENT, ROOT

MANUAL = (ROOT / "docs/ci.md").read_text()
README = (ROOT / "README.md").read_text()
PIPELINE = README.split("## In a pipeline\n")[1].split("\n## ")[0]

# What the pages download from, as packaging/repository says.
REPOSITORY = (ROOT / "packaging/repository").read_text().strip()
RELEASES = f"https://github.com/{REPOSITORY}/releases/download"

# A stand-in for docker: runs the built program with the arguments after the image, and logs its own arguments. DOCKER_RUN: how a
# docker ends that starts no container.
DOCKER = """#!/bin/sh
printf '%s\\n' "$*" >> "$DOCKER_LOG"
case $1 in
  info) exit "${DOCKER_INFO:-0}" ;;
  import) tar -tf - >> "$DOCKER_LOG.image" && echo sha256:imported && exit ;;
esac
[ -z "$DOCKER_RUN" ] || exit "$DOCKER_RUN"
while [ "$1" != --entrypoint ] && [ "${1#ghcr.io/}" = "$1" ]; do shift; done
if [ "$1" = --entrypoint ]; then shift 2; fi
shift
exec meshgauge "$@"
"""


@dataclass
class Block:
    language: str
    note: str  # the text after the language, which pages do not show
    text: str

    @property
    def file(self):
        """The name in the first line of a file that is shown, or None."""
        found = re.match(r"# (\S+\.ya?ml)\n", self.text)
        return found and found[1]


def blocks(page):
    return [Block(*found) for found in re.findall(r"^```(\w+) ?([^\n]*)\n(.*?)^```$", page, re.M | re.S)]


def files(page):
    return {block.file: block.text for block in blocks(page) if block.language == "yaml" and block.file}


def all_of(page, name):
    """The texts of every file of this name that the page shows."""
    return [block.text for block in blocks(page) if block.language == "yaml" and block.file == name]


def rows(page, heading):
    """The cells of the table whose first row begins with these cells."""
    table = re.search(rf"^\| {re.escape(heading)} \|.*\n\|[-|]+\|\n((?:\|.*\n)+)", page, re.M)[1]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table.splitlines()]


def tools(folder):
    """A folder for PATH with `meshgauge` and `docker`, and the environment that has it. The user's own settings are not used."""
    place = pathlib.Path(folder) / "tools"
    place.mkdir()
    for name, text in (("meshgauge", f'#!/bin/sh\nexec {shlex.quote(str(BINARY))} "$@"\n'), ("docker", DOCKER)):
        (place / name).write_text(text)
        (place / name).chmod(0o755)
    return {**ENVIRONMENT, "PATH": f"{place}{os.pathsep}{os.environ['PATH']}", "HOME": str(place),
            "DOCKER_LOG": str(place / "docker.log"), "GIT_CONFIG_NOSYSTEM": "1", "NO_COLOR": "1",
            "GIT_AUTHOR_NAME": "t", "GIT_AUTHOR_EMAIL": "t@example.com", "GIT_COMMITTER_NAME": "t",
            "GIT_COMMITTER_EMAIL": "t@example.com"}


class Releases:
    """A page of releases on this machine: one archive, whose program runs the built one, and SHA256SUMS."""

    def __init__(self, folder):
        self.version = re.search(r"project\(meshgauge VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
        name = f"meshgauge-{self.version}-linux-{platform.machine()}"
        self.place = pathlib.Path(folder) / "releases" / f"v{self.version}"
        self.place.mkdir(parents=True)
        self.archive = self.place / f"{name}.tar.gz"
        program = f'#!/bin/sh\nexec {shlex.quote(str(BINARY))} "$@"\n'.encode()
        with tarfile.open(self.archive, "w:gz") as archive:
            file = tarfile.TarInfo(f"{name}/meshgauge")
            file.size, file.mode = len(program), 0o755
            archive.addfile(file, io.BytesIO(program))
        self.sha256 = hashlib.sha256(self.archive.read_bytes()).hexdigest()
        (self.place / "SHA256SUMS").write_text(f"{'0' * 64}  another.whl\n{self.sha256}  {self.archive.name}\n")

        class Quiet(http.server.SimpleHTTPRequestHandler):
            def log_message(self, *words):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=self.place.parent))
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()

    def close(self):
        self.server.shutdown()
        self.server.server_close()


def box(x=20, y=20, z=20, hole=False):
    """The boxes of docs/ci.md, as OFF."""
    corners = "".join(f"{a} {b} {c}\n" for c in (0, z) for b in (0, y) for a in (0, x))
    faces = ["0 2 1", "1 2 3", "4 5 6", "5 7 6", "0 1 4", "1 5 4", "2 6 3", "3 6 7", "0 4 2", "2 4 6", "1 3 5", "3 7 5"]
    if hole:
        faces.pop()
    return f"OFF\n8 {len(faces)} 0\n{corners}" + "".join(f"3 {face}\n" for face in faces)


def box_and_support():
    """The whole box, and a triangle that stands out of it."""
    head, *lines = box().splitlines()[1:]
    corners, faces = lines[:8], lines[8:]
    assert head == "8 12 0"
    return "\n".join(["OFF", "11 13 0", *corners, "30 0 0", "30 5 0", "30 0 5", *faces, "3 8 9 10"]) + "\n"


def as_glb(off):
    """The same mesh as a GLB, whose numbers are metres."""
    head, *lines = off.splitlines()[1:]
    vertices, faces = (int(count) for count in head.split()[:2])
    corners = [float(x) for line in lines[:vertices] for x in line.split()]
    indices = [int(i) for line in lines[vertices:vertices + faces] for i in line.split()[1:]]
    data = struct.pack(f"<{len(corners)}f{len(indices)}I", *corners, *indices)
    document = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 4 * len(corners)},
                        {"buffer": 0, "byteOffset": 4 * len(corners), "byteLength": 4 * len(indices)}],
        "buffers": [{"byteLength": len(data)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def repository(folder, broken=False):
    """The three parts of docs/ci.md with its gates.yaml; `broken`: the bracket has a hole."""
    folder = pathlib.Path(folder)
    for place in ("parts", "baselines"):
        (folder / place).mkdir(parents=True)
        for name, size in (("plate", (40, 30, 4)), ("bracket", (20, 20, 20)), ("pin", (5, 5, 60))):
            hole = broken and place == "parts" and name == "bracket"
            (folder / place / f"{name}.off").write_text(box(*size, hole=hole))
    (folder / "gates.yaml").write_text(files(MANUAL)["gates.yaml"])
    return folder
