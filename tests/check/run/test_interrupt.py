"""Ctrl-C and SIGTERM: the intervals so far are reported, soon."""

import fcntl
import json
import os
import signal
import struct
import subprocess
import termios
import unittest

from harness import SLOW, until, until_computing, wavy_grid
from workplace import Workplace

F_GETPIPE_SZ = 1032  # of Linux; Python's fcntl has it since 3.10
FOREVER = ("--max-distance", "0", "--strategy", "four_point", "--timeout", "100 s")


def waiting_in(pipe):
    """How many bytes can be read from it."""
    return struct.unpack("i", fcntl.ioctl(pipe, termios.FIONREAD, bytes(4)))[0]


class Interrupt(Workplace):
    def hard_pair(self):
        return self.file("1.obj", SLOW["a"]), self.file("2.obj", SLOW["b"])

    def ended_by(self, sign, process, after=0.3):
        until_computing(process, after)
        process.send_signal(sign)
        out, err = process.communicate(timeout=60)
        return process.returncode, out, err

    def test_a_running_gate_returns_its_interval_and_reports_are_written(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            process = self.start(*self.hard_pair(), *FOREVER, "--json=report.json")
            code, out, err = self.ended_by(sign, process)
            self.assertEqual(code, 2, err)
            self.assertIn("UNDECIDED", out)
            self.assertIn("; interrupted", out)
            report = json.loads((self.folder / "report.json").read_text())
            self.assertTrue(report["interrupted"])
            gate = report["gates"][0]
            if gate["comparison"]:  # else the machine was too busy to read within that second
                self.assertEqual(gate["comparison"]["status"], "cancelled")
                self.assertLessEqual(gate["distance"]["lower"], gate["distance"]["upper"])
                self.assertIn("letting it run to its end", gate["advice"])
            (self.folder / "report.json").unlink()

    def test_while_a_large_file_is_read(self):
        grid = wavy_grid(300, 0.1)
        large = grid + 8 * grid[grid.index(b"f "):]
        self.file("large.obj", large)
        self.file("other.obj", large)
        process = self.start("large.obj", "other.obj", "--max-distance", "0.1", "--json")
        code, out, _ = self.ended_by(signal.SIGINT, process, after=0.1)
        report = json.loads(out)
        if code == 0:
            self.skipTest("this machine has read a large file and measured it within a tenth of a second")
        self.assertEqual(code, 2)
        self.assertTrue(report["interrupted"])
        gate = report["gates"][0]
        self.assertEqual((gate["verdict"], gate["interrupted"]), ("undecided", True))
        self.assertEqual(gate["advice"], "Interrupted before anything was known: run it again.")

    def test_gates_that_have_ended_keep_their_verdicts_and_the_rest_does_not_begin(self):
        self.hard_pair()
        quick = [("quick%d" % i, "flat.obj", "raised.obj", 3) for i in range(3)]
        hard = [("hard%d" % i, "1.obj", "2.obj", 0, "strategy: four_point", "timeout: 100 s") for i in range(9)]
        self.manifest(quick + hard)
        process = self.start("gates.yaml", "--json", "--jobs", "6")
        code, out, _ = self.ended_by(signal.SIGINT, process)
        self.assertEqual(code, 2)
        gates = json.loads(out)["gates"]
        self.assertEqual(len(gates), 12)
        # Large files begin first: six hard pairs take all places.
        begun = [gate for gate in gates if not gate["interrupted"]]
        self.assertLessEqual(len(begun), 6)
        for gate in gates:
            self.assertEqual(gate["verdict"], "undecided")

    def test_a_second_ctrl_c_ends_at_once(self):
        """While the reader of the report does not read, the run cannot end by itself: the second signal ends it."""
        read, write = os.pipe()
        self.addCleanup(os.close, read)
        many = [("gate%d" % i, "1.obj", "2.obj", 0, "strategy: four_point", "timeout: 100 s") for i in range(300)]
        self.hard_pair()
        self.manifest(many)
        process = self.start("gates.yaml", "--json", "--quiet", stdout=write, stderr=subprocess.DEVNULL)
        os.close(write)
        until_computing(process, 0.3)
        process.send_signal(signal.SIGINT)
        until(lambda: waiting_in(read) > fcntl.fcntl(read, F_GETPIPE_SZ) - 4096)  # 300 gates do not fit into a pipe
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(60), -signal.SIGINT)


if __name__ == "__main__":
    unittest.main()
