"""Settings from flags, variables and a file: which wins, and what is refused."""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

from harness import BINARY, ENVIRONMENT, Server


class Settings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "meshgauge.toml"

    def serve(self, *flags, environment=None):
        return subprocess.run([BINARY, "serve", *flags], capture_output=True, text=True, timeout=60,
                              env={**ENVIRONMENT, **(environment or {})})

    def printed(self, *flags, environment=None):
        done = self.serve("--print-config", *flags, environment=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def fails(self, text, saying):
        self.path.write_text(text)
        done = self.serve("--config", str(self.path))
        self.assertEqual(done.returncode, 3)
        self.assertIn(saying, done.stderr)

    def test_a_flag_wins_over_a_variable_that_over_the_file_that_over_the_default(self):
        self.path.write_text("queue = 7\nkeep_alive_ms = 7\ngrace_ms = 7\n")
        text = self.printed("--config", str(self.path), "--queue", "9", "--workers", "2",
                            environment={"MESHGAUGE_QUEUE": "8", "MESHGAUGE_KEEP_ALIVE_MS": "8"})
        for line in ("queue = 9", "keep_alive_ms = 8", "grace_ms = 7", "parsers = 0  # here: 3"):
            self.assertIn("\n%s\n" % line, text)

    def test_the_file_may_be_named_by_a_variable(self):
        self.path.write_text("queue = 7\n")
        self.assertIn("\nqueue = 7\n", self.printed(environment={"MESHGAUGE_CONFIG": str(self.path)}))

    def test_what_is_printed_is_read_and_names_every_setting(self):
        text = self.printed("--queue", "5", "--temp-dir", "/tmp/\"quoted\" # name", "--public-without-keys")
        self.path.write_text(text)
        self.assertEqual(self.printed("--config", str(self.path)), text)
        names = re.findall(r"^(\w+) = ", text, re.MULTILINE)
        flags = re.findall(r"^ +--([\w-]+).*\(Env:", self.serve("--help").stdout, re.MULTILINE)
        self.assertEqual(names, [flag.replace("-", "_") for flag in flags if flag != "config"])
        self.assertRegex(text, r"\nworkers = 0  # here: \d+\n")

    def test_a_password_is_never_shown(self):
        given = {"MESHGAUGE_DATABASE": "postgresql://me:geheim@127.0.0.1:1/x"}
        text = self.printed(environment=given)
        self.assertIn("host='127.0.0.1'", text)
        help_text = self.serve("--help", environment=given).stdout
        broken = self.serve("--database", "host=one password=very geheim")
        self.assertEqual(broken.returncode, 3)
        for shown in (text, help_text, broken.stdout, broken.stderr):
            self.assertNotIn("geheim", shown)

    def test_the_file_takes_effect(self):
        self.path.write_text('max_part_bytes = 10\nsimd = "scalar"\n')
        server = Server("--config", str(self.path))
        self.addCleanup(server.stop)
        self.assertEqual(server.started["simd"], "scalar")
        self.assertEqual(server.compare().status, 413)

    def test_bad_files(self):
        self.fails("port = 1\nprot = 2\n", "line 2: 'prot' is not a setting")
        self.fails("port = 1\nport = 2\n", "line 2: 'port' is set twice")
        self.fails("port = \"1\"\n", "line 1: 'port' must be a whole number")
        self.fails("host = 0.0.0.0\n", "line 1: 'host' must be a text in double quotes")
        self.fails("[serve]\nport = 1\n", "line 1: must be 'name = value'")
        self.fails("port = 70000\n", "--port must be at most 65535")
        self.path.unlink()
        self.assertIn("No such file", self.serve("--config", str(self.path)).stderr)

    def test_health_reads_the_same_file(self):
        server = Server()
        self.addCleanup(server.stop)
        self.path.write_text("port = %d\nqueue = 3\n" % server.port)
        health = [BINARY, "health", "--config", str(self.path)]
        self.assertEqual(subprocess.run(health, env=ENVIRONMENT).returncode, 0)
        self.path.write_text("prot = 3\n")
        self.assertEqual(subprocess.run(health, env=ENVIRONMENT, stderr=subprocess.DEVNULL).returncode, 3)


if __name__ == "__main__":
    unittest.main()
