"""The runs of ./dev bench: what is measured again, what is stored, what one takes.

MESHGAUGE_BUILD is the build folder.
"""
import sys
import unittest
import unittest.mock

from harness import campaign, contenders, pairs, results, store
from harness_test import BUILD, Folder, row


class Stored(Folder):
    def test_what_was_added_is_read_again(self):
        added = store.Store(self.folder).open().add(row(lower=0.1, simd="avx2", user=1e-9))
        again = store.Store(self.folder).open()
        self.assertEqual(again.rows, [added])
        self.assertEqual((added["lower"], added["simd"], added["user"], added["prepare"]), (0.1, "avx2", 1e-9, None))
        self.assertIn(0, again.done()[store.key_of(added)])

    def test_a_torn_line_is_dropped(self):
        store.Store(self.folder).open().add(row())
        with (self.folder / "runs.csv").open("a") as file:
            file.write("pairs,q,m,au")
        again = store.Store(self.folder).open()
        again.add(row(pair="r"))
        self.assertEqual([r["pair"] for r in store.Store(self.folder).open().rows], ["p", "r"])


class Measured(Folder):
    def campaign(self, session, programs, seconds):
        """Two repetitions of one round that measure nothing: what was added, and the session's results."""
        runs = store.Store(self.folder).open()
        known = len(runs.rows)
        measured = campaign.Campaign(runs, unittest.mock.Mock(), contenders.Limits(60, 6 << 30), 2, session)
        measured.programs.hash_of.side_effect = programs.get
        mesh = self.folder / "mesh.obj"
        mesh.touch()
        jobs = [contenders.Job("pairs", pairs.Pair("p", "k", mesh, mesh), name, 1e-4) for name in programs]
        finished = {"session": session, "status": "converged", "lower": 1.0, "upper": 1.001, "diagonal": 1.0}
        measured._measure = lambda job: finished | {"seconds": seconds[job.contender]}
        measured.run("pairs", [jobs])
        cases = results.Results(runs.rows).cases["pairs", "p", 1e-4, ""]
        return (
            [(added["contender"], int(added["repetition"])) for added in runs.rows[known:]],
            {name: result.seconds for name, result in cases.items()},
        )

    def test_what_is_compared_was_measured_in_one_session(self):
        both, times = {"auto": "1", "cgal": "1"}, {"auto": 1.0, "cgal": 2.0}
        measured = [("auto", 0), ("cgal", 0), ("cgal", 1), ("auto", 1)]
        self.assertEqual(self.campaign("s", both, times), (measured, times))
        self.assertEqual(self.campaign("t", both, times), ([], times))
        slower = {"auto": 3.0, "cgal": 4.0}
        self.assertEqual(self.campaign("u", {**both, "cgal": "2"}, slower), (measured, slower))

    def test_what_takes_long_is_not_repeated(self):
        both, times = {"auto": "1", "cgal": "1"}, {"auto": 1.0, "cgal": 20.0}
        self.assertEqual(self.campaign("s", both, times), ([("auto", 0), ("cgal", 0), ("auto", 1)], times))
        self.assertEqual(self.campaign("t", both, times), ([], times))


class Launched(unittest.TestCase):
    def launch(self, code, seconds=60, size=6 << 30):
        limits = contenders.Limits(seconds - campaign.KILL_AFTER_SECONDS, size)
        return campaign.launch(contenders.Programs(BUILD), [sys.executable, "-S", "-c", code], limits)

    def test_it_tells_what_the_command_took(self):
        ballast = bytearray(200 << 20)  # of this process: not to be counted
        stdout, _, report = self.launch("print(sum(range(3000000)))")
        self.assertEqual(
            (stdout.strip(), report["exit"], report["signal"], report["killed"]), ("4499998500000", 0, 0, False)
        )
        self.assertLess(report["peak_bytes"], len(ballast) / 2)
        self.assertGreater(report["wall_seconds"] + report["user_seconds"], 0)

    def test_peak_memory(self):
        _, _, report = self.launch("bytearray(300 << 20)")
        self.assertGreater(report["peak_bytes"], 300 << 20)
        self.assertLess(report["peak_bytes"], 400 << 20)

    def test_limits(self):
        _, _, report = self.launch("import time; time.sleep(60)", seconds=0.2)
        self.assertTrue(report["killed"])
        _, stderr, report = self.launch("bytearray(1 << 30)", size=1 << 29)
        self.assertIn("MemoryError", stderr)
        self.assertNotEqual(report["exit"], 0)
