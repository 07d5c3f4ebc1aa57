"""Every file of the corpus over HTTP: each has its answer in time, the service lives, and its memory comes back."""

import csv
import os
import time
import unittest
from pathlib import Path

from harness import SQUARE, Server, post_head

CORPUS = os.environ.get("MESHGAUGE_CORPUS")
MOST_SECONDS = 5
MOST_KB = 64 << 10


def rows(folder):
    """(path, what the index asks for), of the files that are meant to be read."""
    with open(Path(CORPUS) / folder / "INDEX.tsv", newline="") as file:
        for row in csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE):
            if row and not row[0].startswith("#") and "not an input" not in row[2]:
                yield Path(CORPUS) / folder / row[0], row[2]


def resident_kb(pid):
    with open("/proc/%d/status" % pid) as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS:"))


def request(path):
    parts = (("a", path.read_bytes(), path.name), ("b", SQUARE, "b.obj"), ("options", b'{"timeout_ms": 2000}', "options"))
    body = b"".join(b'--XXboundaryXX\r\nContent-Disposition: form-data; name="%s"; filename="%s"\r\n\r\n%s\r\n'
                    % (name.encode(), file.encode(), data) for name, data, file in parts) + b"--XXboundaryXX--\r\n"
    return post_head(len(body)) + body


@unittest.skipUnless(CORPUS, "MESHGAUGE_CORPUS names no folder")
class Corpus(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.slowest = 0.0

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0
        print("slowest answer %.2f s" % cls.slowest)

    def ask(self, path):
        start = time.monotonic()
        answer = self.server.raw(request(path))
        seconds = time.monotonic() - start
        type(self).slowest = max(self.slowest, seconds)
        self.assertLess(seconds, MOST_SECONDS, path)
        self.assertIn(answer.status, (200, 413, 415, 422), answer.body)
        if answer.status != 200:
            self.assertEqual([error["part"] for error in answer.json()["errors"]], ["a"], path)
            self.assertNotIn("ended abnormally", answer.json()["detail"], path)
        return answer

    def test_every_file_is_answered_and_the_memory_comes_back(self):
        self.server.raw(request(next(rows("formats"))[0]))
        before = resident_kb(self.server.process.pid)
        for folder in ("formats", "malformed"):
            for path, _ in rows(folder):
                self.ask(path)
        self.assertEqual(self.server.compare().status, 200)
        self.assertLess(resident_kb(self.server.process.pid), before + MOST_KB)

    def test_a_good_file_is_read(self):
        for path, asked in rows("formats"):
            if asked.startswith("accept; 1000 triangles") and path.suffix in (".obj", ".stl", ".ply", ".off", ".glb"):
                answer = self.ask(path)
                self.assertEqual(answer.status, 200, path)
                self.assertEqual(answer.json()["meshes"]["a"]["triangles"], 1000, path)


if __name__ == "__main__":
    unittest.main()
