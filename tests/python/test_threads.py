"""Many calls at once, other Python threads meanwhile, Ctrl-C, and fork."""

import concurrent.futures
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import unittest

import meshgauge
import shapes

# Two flat grids are at distance 0, which four_point approaches for ever.
ENDLESS = """
import sys, meshgauge, shapes
sys.stdout.write("started\\n"); sys.stdout.flush()
meshgauge.compare(shapes.grid(120), shapes.grid(127), tolerance=0, strategy="four_point", timeout=None, threads=1)
"""

# Indices and corners go to and fro between those of a mesh and what leads outside of it.
CHANGING = """
import threading, numpy, meshgauge, shapes
vertices, faces = shapes.grid(60)
vertices, faces = numpy.array(vertices, numpy.float64), numpy.array(faces, numpy.uint32)
right, over = (vertices.copy(), faces.copy()), threading.Event()

def change():
    while not over.is_set():
        faces[::3] = 0xffff0000
        vertices[::5] = numpy.nan
        vertices[:], faces[:] = right

thread = threading.Thread(target=change)
thread.start()
try:
    for _ in range(15):
        try:
            meshgauge.compare((vertices, faces), shapes.grid(67, 0.1), timeout=0.1, threads=1)
        except (meshgauge.InputError, TimeoutError):
            pass
finally:
    over.set()
    thread.join()
print("ended")
"""


class Threads(unittest.TestCase):
    def test_a_thousand_calls_at_once_give_the_same_bits(self):
        a, b = shapes.sphere(16), shapes.sphere(11)
        expected = meshgauge.compare(a, b, threads=1)
        begin = threading.Barrier(50)

        def call(index):
            if index < 50:
                begin.wait()
            result = meshgauge.compare(a, b, threads=1)
            return result.document["distance"], result.document["a_to_b"], result.document["b_to_a"]

        with concurrent.futures.ThreadPoolExecutor(50) as pool:
            found = list(pool.map(call, range(1000)))
        self.assertEqual(found, [(expected.document["distance"], expected.document["a_to_b"], expected.document["b_to_a"])] * 1000)

    def test_python_runs_meanwhile(self):
        """A thread of Python makes progress while another compares: the lock of the interpreter is not held."""
        comparing, counted = threading.Event(), 0
        ended = threading.Event()

        def compare():
            comparing.set()
            meshgauge.compare(shapes.grid(120), shapes.grid(127), tolerance=0, strategy="four_point", timeout=1.0, threads=1)
            ended.set()

        thread = threading.Thread(target=compare)
        thread.start()
        comparing.wait()
        while not ended.is_set():
            counted += 1
        thread.join()
        self.assertGreater(counted, 1000)

    def test_arrays_that_change_meanwhile(self):
        """A result or an error, never memory of others: in a process of its own, which would end by a signal."""
        run = subprocess.run([sys.executable, "-c", CHANGING], capture_output=True, text=True, check=False)
        self.assertEqual((run.returncode, run.stdout), (0, "ended\n"), run.stderr)

    def test_a_forked_process_compares(self):
        a, b = shapes.grid(4), shapes.grid(5, 0.1)
        expected = meshgauge.compare(a, b, threads=1).lower
        with multiprocessing.get_context("fork").Pool(2) as pool:
            self.assertEqual(pool.map(_lower, [(a, b)] * 4), [expected] * 4)


def _lower(pair):
    return meshgauge.compare(*pair, threads=1).lower


class Interrupt(unittest.TestCase):
    def interrupted(self, program):
        process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.assertEqual(process.stdout.readline(), "started\n")
        process.send_signal(signal.SIGINT)
        return process, *process.communicate(timeout=60)

    def test_ctrl_c_cancels(self):
        process, _, errors = self.interrupted(ENDLESS)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertEqual(process.returncode, -signal.SIGINT)

    def test_ctrl_c_while_another_thread_compares(self):
        """The main thread gets it; the other thread's comparison has a timeout of its own."""
        program = ("import threading\n"
                   "import meshgauge, shapes\n"
                   "t = threading.Thread(target=lambda: meshgauge.compare(shapes.grid(120), shapes.grid(127), tolerance=0,"
                   " strategy='four_point', timeout=1, threads=1))\n"
                   "t.start()\n"
                   "try:\n"
                   "    print('started', flush=True)\n"
                   "    while True: t.join(10); print('more', flush=True)\n"
                   "except KeyboardInterrupt:\n"
                   "    t.join(); print('ended')\n")
        _, output, errors = self.interrupted(program)
        self.assertEqual((output.splitlines()[-1], errors), ("ended", ""))

    def test_a_signal_s_handler_runs_and_the_comparison_goes_on(self):
        handled = []
        before = signal.signal(signal.SIGUSR1, lambda *_: handled.append(1))
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGUSR1))
        timer.start()
        try:
            result = meshgauge.compare(shapes.grid(120), shapes.grid(127), tolerance=0, strategy="four_point", timeout=1.0, threads=1)
        finally:
            timer.join()
            signal.signal(signal.SIGUSR1, before)
        self.assertEqual((handled, result.status), ([1], "timeout"))


if __name__ == "__main__":
    unittest.main()
