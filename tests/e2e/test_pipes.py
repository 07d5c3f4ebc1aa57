"""Meshes from pipes on the command line: standard input, a FIFO, /dev/fd/N of a shell's <(command)."""

import contextlib
import json
import os
import pty
import resource
import socket
import struct
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

from harness import BINARY, OWN_DATA, RAISED, SQUARE, Server

SANITIZED = os.environ.get("MESHGAUGE_SANITIZED") == "1"
CHECK = ("check", "--max-distance", "2.5", "--json")


def binary_stl():
    """SQUARE, as two facets."""
    corners = (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)
    facets = [struct.pack("<12fH", 0, 0, 1, *sum((corners[i] for i in face), ()), 0) for face in ((0, 1, 2), (0, 2, 3))]
    return b"\0" * 80 + struct.pack("<I", 2) + b"".join(facets)


def gltf(uri):
    return json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": uri}],
                       "bufferViews": [{"buffer": 0, "byteLength": 36}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                       "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
                       "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}).encode()  # fmt: skip


class Pipes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.square, self.raised = self.file("square.obj", SQUARE), self.file("raised.obj", RAISED)

    def file(self, name, data):
        (self.folder / name).write_bytes(data)
        return name

    def fifo(self, name, data):
        """A FIFO, and a thread that writes to it once it is opened."""
        path = self.folder / name
        os.mkfifo(path)

        def write():
            with contextlib.suppress(BrokenPipeError), open(path, "wb") as end:
                end.write(data)

        thread = threading.Thread(target=write, daemon=True)
        thread.start()
        self.addCleanup(self.ended, thread, path)
        return name

    @staticmethod
    def ended(thread, path):
        """The thread has written, or is freed from waiting for a reader."""
        if thread.is_alive():
            os.close(os.open(path, os.O_RDONLY | os.O_NONBLOCK))
        thread.join()

    def run_cli(self, *arguments, stdin=b"", **rest):
        to = {"stdin": stdin} if hasattr(stdin, "fileno") or isinstance(stdin, int) else {"input": stdin}
        return subprocess.run([BINARY, *arguments], capture_output=True, timeout=120, cwd=self.folder, env=OWN_DATA, **to, **rest)

    def shell(self, line, *arguments):
        return subprocess.run(["bash", "-c", line, "bash", BINARY, *arguments], capture_output=True, timeout=120, cwd=self.folder,
                              env=OWN_DATA, stdin=subprocess.DEVNULL)

    def measures(self, result, distance=2):
        self.assertEqual(result.returncode, 0, result.stderr)
        document = json.loads(result.stdout)
        self.assertAlmostEqual(document["distance"]["upper"], distance, 6)
        return document

    def fails(self, result, saying):
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertIn(saying, result.stderr.decode())
        return result.stderr.decode()


class Compare(Pipes):
    def test_standard_input_is_either_mesh(self):
        flags = ("--json", "--absolute", "1e-9")
        document = self.measures(self.run_cli("compare", "-", self.raised, *flags, stdin=SQUARE))
        self.assertEqual(document["meshes"]["a"]["triangles"], 2)
        self.measures(self.run_cli("compare", self.square, "-", *flags, stdin=RAISED))
        self.measures(self.run_cli("compare", "/dev/stdin", self.raised, *flags, stdin=SQUARE))

    def test_the_result_is_that_of_the_file(self):
        def told(result):
            document = self.measures(result, 0)
            return {key: value for key, value in document.items() if key not in ("id", "timings_ms")}

        self.file("square.stl", binary_stl())
        flags = ("compare", "--json", "--absolute", "1e-9", "--threads", "1")
        of_file = told(self.run_cli(*flags, "square.stl", self.square))
        self.assertEqual(told(self.run_cli(*flags, "-", self.square, stdin=binary_stl())), of_file)

    def test_standard_input_that_is_a_file_or_a_socket(self):
        with open(self.folder / self.square, "rb") as file:
            self.measures(self.run_cli("compare", "-", self.raised, "--json", "--absolute", "1e-9", stdin=file))
        for name in ("-", "/dev/stdin"):  # as Node.js starts a program
            ours, theirs = socket.socketpair()
            with ours, theirs:
                ours.sendall(SQUARE)
                ours.shutdown(socket.SHUT_WR)
                theirs.setblocking(False)
                self.measures(self.run_cli("compare", name, self.raised, "--json", "--absolute", "1e-9", stdin=theirs))

    def test_a_fifo_and_two(self):
        self.measures(self.run_cli("compare", self.fifo("one", SQUARE), self.raised, "--json", "--absolute", "1e-9"))
        pair = (self.fifo("two", SQUARE), self.fifo("three", RAISED))
        self.measures(self.run_cli("compare", *pair, "--json", "--absolute", "1e-9"))

    def test_process_substitution(self):
        self.measures(self.shell('"$1" compare <(cat square.obj) raised.obj --json --absolute 1e-9'))
        self.measures(self.shell('"$1" compare <(cat square.obj) <(cat raised.obj) --json --absolute 1e-9'))
        self.measures(self.shell('cat square.obj | "$1" compare - <(cat raised.obj) --json --absolute 1e-9'))
        self.measures(self.shell('gzip <square.obj | "$1" compare - raised.obj --json --absolute 1e-9'))

    def test_a_large_mesh(self):
        facets = 100_000  # 5 MB, more than a pipe holds
        stl = binary_stl()
        large = stl[:80] + struct.pack("<I", 2 * facets) + stl[84:] * facets
        document = self.measures(self.run_cli("compare", "-", self.square, "--json", "--absolute", "1e-9", stdin=large), 0)
        self.assertEqual(document["meshes"]["a"]["triangles"], 2 * facets)

    def test_a_map_of_it(self):
        result = self.run_cli("compare", "-", self.raised, "--json", "--deviation", "map.ply", stdin=SQUARE)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((self.folder / "map.ply").read_bytes().startswith(b"ply"))

    def test_a_pipe_is_one_mesh_only(self):
        once = " can be one mesh only: name a file or another pipe for the other"
        for pair in (("-", "-"), ("-", "/dev/stdin"), ("/dev/fd/0", "-"), ("/dev/stdin", "/dev/stdin")):
            self.fails(self.run_cli("compare", *pair, stdin=SQUARE), "meshgauge: standard input" + once)
        self.fails(self.run_cli("compare", "-", "-", stdin=subprocess.DEVNULL), "standard input" + once)
        os.mkfifo(self.folder / "pipe")
        for other in ("pipe", "./pipe"):
            self.fails(self.run_cli("compare", "pipe", other), "the pipe 'pipe'" + once)

    def test_a_file_called_standard_input(self):
        self.file("standard input", RAISED)
        self.fails(self.run_cli("compare", "-", "standard input", stdin=SQUARE),
                   "'standard input' is a file and a pipe at once: write './' before the file's name")
        self.measures(self.run_cli("compare", "-", "./standard input", "--json", "--absolute", "1e-9", stdin=SQUARE))

    def test_a_terminal_is_refused(self):
        ours, theirs = pty.openpty()
        try:
            self.fails(self.run_cli("compare", "-", self.raised, stdin=theirs), "standard input is a terminal: send a mesh into it")
        finally:
            os.close(ours)
            os.close(theirs)

    def test_no_standard_input(self):
        self.fails(self.shell('"$1" compare - raised.obj <&-'), "'standard input' cannot be read: Bad file descriptor")

    def test_what_is_wrong_names_the_pipe(self):
        self.fails(self.run_cli("compare", "-", self.raised, stdin=b""), "'standard input' is an empty file")
        self.fails(self.run_cli("compare", "-", self.raised, stdin=SQUARE + b"v 1 2\n"),
                   "line 7 of 'standard input': a vertex needs three coordinates")
        self.fails(self.run_cli("compare", self.raised, self.fifo("cut.obj", b"f 1 2 3\n")), "'cut.obj'")
        self.fails(self.run_cli("compare", self.raised, "/dev/zero"), "'/dev/zero' is not a regular file")

    def test_a_gltf_has_no_files_beside_it_in_a_pipe(self):
        (self.folder / "x.bin").write_bytes(b"\0" * 36)
        said = self.fails(self.run_cli("compare", "-", self.raised, stdin=gltf("x.bin")),
                          "'standard input' is a glTF of several files: it came through a pipe, which has no folder for 'x.bin'")
        self.assertIn("; name the .gltf itself, or send a .glb or a .zip with all files", said)
        self.fails(self.run_cli("compare", self.raised, self.fifo("s.gltf", gltf("../x.bin"))), "'s.gltf'")

    @unittest.skipIf(SANITIZED, "a sanitizer takes more address space than the limit")
    def test_a_pipe_that_does_not_end_is_bounded(self):
        limit = 256 << 20
        with subprocess.Popen(["yes", "v 0 0 0"], stdout=subprocess.PIPE) as endless:
            result = self.run_cli("compare", "-", self.raised, stdin=endless.stdout,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
            endless.kill()
        self.fails(result, "'standard input' is larger than the memory: a pipe may send at most %d bytes here" % limit)

    def test_other_flags_are_refused_before_a_pipe_is_read(self):
        os.mkfifo(self.folder / "unwritten")
        self.fails(self.run_cli("compare", "unwritten", self.raised, "--strategy", "best"), "--strategy")
        self.fails(self.run_cli("compare", "unwritten", self.raised, "--deviation", "map.txt"), "map.txt")


class Check(Pipes):
    def report(self, result, code=0):
        self.assertEqual(result.returncode, code, result.stderr)
        return json.loads(result.stdout)["gates"][0]

    def test_pipes(self):
        gate = self.report(self.run_cli(*CHECK, "-", self.raised, stdin=SQUARE))
        self.assertEqual((gate["name"], gate["candidate"], gate["baseline"]), ("standard input", "standard input", self.raised))
        self.assertEqual(self.report(self.run_cli(*CHECK, self.square, self.fifo("base", RAISED)))["verdict"], "pass")
        gate = self.report(self.shell('"$1" check <(cat square.obj) <(cat raised.obj) --max-distance 1.5 --json'), 1)
        self.assertEqual(gate["verdict"], "fail")

    def test_pictures_and_a_map(self):
        result = self.run_cli(*CHECK, "-", self.raised, "--html", "report.html", "--deviation", "map.ply", stdin=SQUARE)
        self.report(result)
        self.assertIn("standard input", (self.folder / "report.html").read_text())
        self.assertTrue((self.folder / "map.ply").read_bytes().startswith(b"ply"))

    def test_by_a_service(self):
        server = Server()
        self.addCleanup(server.stop)
        at = ("--server", "http://127.0.0.1:%d" % server.port)
        self.assertEqual(self.report(self.run_cli(*CHECK, *at, "-", self.raised, stdin=SQUARE))["verdict"], "pass")
        share = ("check", "--json", "--max-distance", "1 %", *at)  # the baseline's diagonal is measured here
        gate = self.report(self.run_cli(*share, self.square, self.fifo("base", RAISED)), 1)
        self.assertEqual(gate["verdict"], "fail")
        said = self.report(self.run_cli(*CHECK, *at, "-", self.raised, stdin=gltf("x.bin")), 3)["error"]["message"]
        self.assertIn("'standard input' is a glTF of several files: it came through a pipe", said)

    def test_refused(self):
        self.fails(self.run_cli(*CHECK, "-", "-", stdin=SQUARE), "standard input can be one mesh only")
        os.mkfifo(self.folder / "pipe.obj")
        self.fails(self.run_cli(*CHECK, "pipe.obj", "pipe.obj"), "the pipe 'pipe.obj' can be one mesh only")
        said = self.report(self.run_cli(*CHECK, "-", self.raised, stdin=SQUARE + b"v 1 2\n"), 3)["error"]["message"]
        self.assertIn("line 7 of 'standard input'", said)

    def test_a_manifest_names_files(self):
        os.mkfifo(self.folder / "pipe.obj")
        self.file("gates.yaml", b"version: 1\ngates:\n  - candidate: pipe.obj\n    baseline: raised.obj\n    max_distance: 1\n")
        self.fails(self.run_cli("check", "gates.yaml"), "is not a regular file but a pipe, which only the measurement of two meshes reads: "
                                                        "write what it sends into a file")
        self.fails(self.run_cli("check", "pipe.obj", self.raised, "--update-baselines"), "is not a regular file but a pipe")


if __name__ == "__main__":
    unittest.main()
