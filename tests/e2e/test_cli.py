"""The command line: exit codes, and the JSON that HTTP gives."""

import json
import os
import re
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from contract import OPENAPI, validate
from harness import BINARY, ENVIRONMENT, OWN_DATA, RAISED, SLOW, SQUARE, Server, until_computing, wavy_grid


class Cli(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.a = self.file("a.obj", SQUARE)
        self.b = self.file("b.obj", RAISED)

    def file(self, name, data):
        path = Path(self.folder.name) / name
        path.write_bytes(data)
        return str(path)

    def run_cli(self, *arguments, environment=None, before=None):
        return subprocess.run([BINARY, *arguments], capture_output=True, text=True, timeout=120,
                              env={**OWN_DATA, **(environment or {})}, preexec_fn=before)

    def fails(self, *arguments, saying):
        result = self.run_cli(*arguments)
        self.assertEqual(result.returncode, 3, arguments)
        self.assertIn(saying, result.stderr)
        self.assertEqual(result.stdout, "")

    def test_json_is_the_result_of_the_service(self):
        result = self.run_cli("compare", self.a, self.b, "--json", "--absolute", "1e-9", "--max-distance", "2.5")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = json.loads(result.stdout)
        validate(document, "Comparison")
        self.assertLessEqual(document["distance"]["lower"], 2)
        self.assertGreaterEqual(document["distance"]["upper"], 2)
        self.assertEqual(document["verdict"], "pass")
        self.assertEqual(document["tolerance"]["asked"], {"absolute": 1e-9})
        self.assertEqual(result.stderr, "")

    def test_the_same_bytes_over_http(self):
        server = Server()
        self.addCleanup(server.stop)
        over_http = server.compare(options={"tolerance": {"relative": 1e-3}}).json()
        local = json.loads(self.run_cli("compare", self.a, self.b, "--json", "--relative", "1e-3", "--threads", "1").stdout)
        for document in (over_http, local):
            del document["id"], document["timings_ms"]
        over_http.pop("view", None)  # the command line has no page to point to
        self.assertEqual(over_http, local)

    def test_messages_name_files_by_their_paths(self):
        broken = self.file("broken.obj", SQUARE + b"v 1 2\n")
        self.fails("compare", self.a, broken, saying=f"line 7 of '{broken}': a vertex needs three coordinates")
        self.fails("compare", broken, broken, saying=f"line 7 of '{broken}': a vertex needs three coordinates")
        pointer = self.file("pointer.stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
        self.fails("compare", pointer, self.b, saying=f"'{pointer}' is a Git LFS pointer, not a mesh: 'git lfs pull'")

    def test_table_for_people(self):
        result = self.run_cli("compare", self.a, self.b, "--max-distance", "0.5")
        for line in ("distance", "verdict   fail\n  fail      the distance is at least 1.99999, above the limit of 0.5\n", "a to b", "witness", "mesh a", "engine    auto, ", "time"):
            self.assertIn(line, result.stdout)

    def test_the_exit_code_is_that_of_check(self):
        for limit, code in (("2.5", 0), ("0.5", 1)):
            self.assertEqual(self.run_cli("compare", self.a, self.b, "--max-distance", limit).returncode, code)
        hard = ("compare", self.file("fine.obj", wavy_grid(30, 0.1)), self.file("coarse.obj", wavy_grid(23, 0.103)), "--json")
        between = json.loads(self.run_cli(*hard, "--relative", "1e-6").stdout)["distance"]["lower"]
        self.assertEqual(self.run_cli(*hard, "--max-distance", repr(between), "--work-items", "1").returncode, 2)
        self.assertEqual(self.run_cli(*hard, "--max-distance", "nothing").returncode, 3)

    def test_the_table_tells_what_was_done_to_a_mesh(self):
        table = self.run_cli("compare", self.file("square.stl", SQUARE + b"f 1 2 3 4\nl 1 2\nf 1 1 1\n"), self.b).stdout
        for line in ("mesh a    obj, 5 triangles (1 degenerate)", "  the file name says stl, but the content is obj; it was read as that",
                     "split into triangles: 1\n", "left out, since they have no surface: 1\n",
                     "kept as the segment or the point they span: 1\n"):
            self.assertIn(line, table)

    def test_each_strategy_and_direction(self):
        for strategy in OPENAPI["components"]["schemas"]["Strategy"]["enum"]:
            for direction in ("symmetric", "a_to_b", "b_to_a"):
                result = self.run_cli("compare", self.a, self.b, "--json", "--strategy", strategy, "--direction", direction)
                document = json.loads(result.stdout)
                validate(document, "Comparison")
                self.assertEqual(document["engine"]["strategy"], strategy)
                self.assertEqual(document["a_to_b"] is None, direction == "b_to_a")
                self.assertEqual(document["b_to_a"] is None, direction == "a_to_b")

    def test_the_strategies_are_those_of_the_description(self):
        strategies = ", ".join(OPENAPI["components"]["schemas"]["Strategy"]["enum"])
        self.assertIn(strategies, self.run_cli("compare", "--help").stdout)

    def instruction_sets(self):
        """The instruction sets of this processor, from the message that refuses an unknown one."""
        refusal = self.run_cli("compare", self.a, self.b, "--simd", "abacus").stderr
        auto, *names = re.fullmatch(r"meshgauge: --simd must be one of (.*) on this processor, not 'abacus'\n",
                                    refusal)[1].split(", ")
        self.assertEqual((auto, names[-1]), ("auto", "scalar"))
        return names

    def test_every_instruction_set_gives_the_same_bits(self):
        pair = (self.file("fine.obj", wavy_grid(30, 0.1)), self.file("coarse.obj", wavy_grid(23, 0.103)))
        results = {}
        for name in ["auto", *self.instruction_sets()]:
            result = self.run_cli("compare", *pair, "--json", "--relative", "1e-6", "--threads", "1", "--simd", name)
            self.assertEqual(result.returncode, 0, result.stderr)
            results[name] = document = json.loads(result.stdout)
            validate(document, "Comparison")
            self.assertEqual(document["engine"]["threads"], 1)
            if name != "auto":
                self.assertEqual(document["engine"]["simd"], name)
            for part in ("distance", "a_to_b", "b_to_a"):
                self.assertEqual(document[part], results["auto"][part], name)
        self.assertEqual(results["auto"]["engine"]["simd"], self.instruction_sets()[0])
        self.assertGreater(results["auto"]["a_to_b"]["work"]["subdivisions"], 0)

    def test_an_instruction_set_of_another_processor_is_refused(self):
        known = OPENAPI["components"]["schemas"]["Comparison"]["properties"]["engine"]["properties"]["simd"]["enum"]
        others = set(known) - set(self.instruction_sets())
        self.assertGreater(len(others), 0)  # nothing has both avx2 and neon
        for name in others:
            self.fails("compare", self.a, self.b, "--simd", name, saying="on this processor, not '%s'" % name)

    def test_threads(self):
        pair = (self.file("fine.obj", wavy_grid(60, 0.1)), self.file("coarse.obj", wavy_grid(47, 0.103)))

        def run(*flags, before=None):
            result = self.run_cli("compare", *pair, "--json", "--relative", "1e-4", *flags, before=before)
            self.assertEqual(result.returncode, 0, result.stderr)
            document = json.loads(result.stdout)
            self.assertEqual(document["status"], "converged")
            return document

        one, three = run("--threads", "1"), run("--threads", "3")
        self.assertEqual([one["engine"]["threads"], three["engine"]["threads"]], [1, 3])
        self.assertLessEqual(one["distance"]["lower"], three["distance"]["upper"])
        self.assertLessEqual(three["distance"]["lower"], one["distance"]["upper"])
        every = run()["engine"]["threads"]
        self.assertTrue(1 <= every <= min(len(os.sched_getaffinity(0)), 64), every)  # a quota may leave fewer
        self.assertEqual(run("--threads", "0")["engine"]["threads"], every)
        bound = run(before=lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}))
        self.assertEqual(bound["engine"]["threads"], 1)
        self.assertEqual(run("--threads", "3", "--strategy", "four_point")["engine"]["threads"], 1)

    def test_bad_flags(self):
        pair = ("compare", self.a, self.b)
        self.fails(*pair, "--absolute", "nan", saying="--absolute must be")
        self.fails(*pair, "--absolute", "-1", saying="--absolute must be")
        self.fails(*pair, "--relative", "inf", saying="--relative must be")
        self.fails(*pair, "--max-distance", "-0.5", saying="--max-distance must be")
        self.fails(*pair, "--timeout-ms", "0", saying="from 1 to 180000")
        self.fails(*pair, "--threads", "1.5", saying="from 1 to 64")
        self.fails(*pair, "--threads", "65", saying="from 1 to 64")
        self.fails(*pair, "--threads", "-1", saying="from 1 to 64")
        self.fails(*pair, "--threads", "many", saying="--threads")
        self.fails(*pair, "--strategy", "best", saying="four_point")
        self.fails(*pair, "--direction", "up", saying="symmetric, candidate_to_baseline, baseline_to_candidate")
        self.fails(*pair, "--points", "10", saying="n_point")
        self.fails(*pair, "--unknown", saying="--unknown")
        self.fails("compare", self.a, saying="B")
        self.fails("frobnicate", saying="subcommand")
        self.fails(saying="subcommand")

    def test_bad_files(self):
        self.fails("compare", self.a, self.folder.name, saying="is a folder")
        self.fails("compare", self.a, "/dev/zero", saying="is not a regular file")
        self.fails("compare", self.a, self.folder.name + "/none.obj", saying="No such file")
        self.fails("compare", self.a, self.file("empty.obj", b""), saying="empty.obj' is an empty file")
        self.fails("compare", self.a, self.file("nan.obj", SQUARE.replace(b"v 1 1 0", b"v nan 1 0")), saying="line 3")

    def test_a_result_that_cannot_be_written_is_an_error(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run([BINARY, "compare", self.a, self.b], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 3)
        self.assertIn("could not be written", result.stderr)

    def test_timeout_is_a_result(self):
        a, b = self.file("1.obj", SLOW["a"]), self.file("2.obj", SLOW["b"])
        result = self.run_cli("compare", a, b, "--strategy", "four_point", "--absolute", "0", "--timeout-ms", "300", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = json.loads(result.stdout)
        self.assertEqual(document["status"], "timeout")
        self.assertLessEqual(document["distance"]["lower"], document["distance"]["upper"])

    def test_ctrl_c_prints_the_interval_reached(self):
        a, b = self.file("1.obj", SLOW["a"]), self.file("2.obj", SLOW["b"])
        process = subprocess.Popen([BINARY, "compare", a, b, "--strategy", "four_point", "--absolute", "0", "--timeout-ms", "100000", "--json"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT)
        until_computing(process, 1)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0)
        document = json.loads(out)
        validate(document, "Comparison")
        self.assertEqual(document["status"], "cancelled")

    def test_version_and_help(self):
        version = self.run_cli("--version")
        self.assertEqual(version.returncode, 0)
        self.assertRegex(version.stdout, r"^meshgauge \d+\.\d+\.\d+\n$")
        self.assertEqual(self.run_cli("compare", "--help").returncode, 0)

    def test_health(self):
        server = Server()
        self.assertEqual(self.run_cli("health", "--port", str(server.port)).returncode, 0)
        self.assertEqual(self.run_cli("health", environment={"MESHGAUGE_PORT": str(server.port)}).returncode, 0)
        server.stop()
        self.assertEqual(self.run_cli("health", "--port", str(server.port)).returncode, 1)

    def test_settings_are_flags_and_variables(self):
        help_text = self.run_cli("serve", "--help").stdout
        flags = dict(re.findall(r"^ +--([\w-]+).*?\(Env:(\w+)\)", help_text, re.MULTILINE))
        self.assertGreater(len(flags), 15)
        for flag, variable in flags.items():
            self.assertEqual(variable, "MESHGAUGE_" + flag.replace("-", "_").upper())

    def test_an_operator_forces_the_instruction_set(self):
        for server in (Server("--simd", "scalar"), Server(environment={"MESHGAUGE_SIMD": "scalar"})):
            self.addCleanup(server.stop)
            self.assertEqual(server.started["simd"], "scalar")
            self.assertEqual(server.compare().json()["engine"]["simd"], "scalar")
        server = Server()
        self.addCleanup(server.stop)
        self.assertEqual(server.started["simd"], self.instruction_sets()[0])

    def test_bad_settings(self):
        self.fails("serve", "--port", "70000", saying="--port")
        self.fails("serve", "--port", "0", "--io-threads", "0", saying="--io-threads must be at least")
        self.fails("serve", "--port", "0", "--temp-dir", "/nonexistent", saying="--temp-dir")
        self.fails("serve", "--port", "0", "--simd", "abacus", saying="--simd must be one of auto, ")
        self.fails("serve", "--host", "no such host", "--port", "0", saying="cannot listen")


if __name__ == "__main__":
    unittest.main()
