#!/usr/bin/env python3
"""Attacks the Python package by hostile arrays and objects, arrays that change while they are measured, many threads,
forks in the middle and subinterpreters. Each attempt ends with the right interval or with an error, in time. They run
in processes of their own, so that a crash or a hang is seen; a failing one is repeated by its seed."""

import argparse
import collections
import ctypes
import gc
import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests/chaos"))

import numpy  # noqa: E402
import meshgauge  # noqa: E402
import hostile_arrays  # noqa: E402
import hostile_objects  # noqa: E402
import shapes  # noqa: E402
from seeds import seed  # noqa: E402

DISTANCE = 2.0  # of the flat squares
OTHER = (shapes.grid(4)[0] + [0, 0, DISTANCE], shapes.grid(4)[1])
ERRORS = (meshgauge.InputError, MemoryError, TimeoutError, OSError)
MOST_BYTES = 8 << 30  # of address space: an array may claim more than there is
CHILD_SECONDS = 300
FORK_SECONDS = 60
SANITIZED = "san.so" in os.environ.get("LD_PRELOAD", "")  # takes terabytes of addresses, and no fork of many threads


class Broken(AssertionError):
    pass


def demand(condition, *what):
    if not condition:
        raise Broken(" ".join(str(one)[:500] for one in what))


def outcome(mesh, other=OTHER, **options):
    """("interval", lower, upper), or ("refused", the error)."""
    try:
        result = meshgauge.compare(mesh, other, threads=1, **options)
    except ERRORS as error:
        return "refused", error
    demand(result.lower <= result.upper, "an empty interval:", result.lower, result.upper)
    return "interval", result.lower, result.upper


def holds(found, *what):
    """Asserts that it is an interval that holds the distance."""
    demand(found[0] == "interval" and found[1] <= DISTANCE <= found[2], *what, found)


# --- kinds of attempts: each takes dice, and returns what came of it --------------------------------------------------


def arrays(dice):
    """The same numbers in another layout are the same mesh; what is none is refused as in the plain layout."""
    vertices, faces, right = hostile_arrays.mesh(dice)
    name, given, plain = hostile_arrays.vertices(vertices, dice)
    face_name, given_faces, plain_faces = hostile_arrays.faces(faces, dice)
    found = outcome((given, given_faces))
    if plain is None or plain_faces is None:  # claims more than there is, or is no numbers
        demand(found[0] == "refused", name, face_name, "are taken:", found)
        return "refused"
    wanted = outcome((plain, plain_faces))
    demand(found[0] == wanted[0], name, face_name, found, "and not", wanted)
    demand(found[0] == "refused" or found == wanted, name, face_name, found, "and not", wanted)
    if right and numpy.array_equal(plain, vertices) and numpy.array_equal(plain_faces, faces):
        holds(found, name, face_name)
    return found[0]


def objects(dice):
    """Objects that run code while they are read, or are no meshes."""
    name, thing, is_mesh = hostile_objects.drawn(dice)
    try:
        found = outcome(thing)
    except (ValueError, TypeError) as error:  # of Python itself, as a path with NUL
        found = "refused", error
    if is_mesh:
        holds(found, name)
    else:
        demand(found[0] == "refused", name, found)
    return found[0]


def changing(dice):
    """Another thread changes the numbers, and what the arrays say of themselves, while they are measured."""
    vertices, faces = shapes.grid(dice.choice((10, 40, 80)))
    vertices, faces, over = numpy.array(vertices), numpy.array(faces), threading.Event()
    changer = threading.Thread(target=hostile_arrays.change, args=(vertices, faces, over, random.Random(dice.random())))
    interval, before = sys.getswitchinterval(), collections.Counter()
    sys.setswitchinterval(1e-5)
    changer.start()
    try:
        for _ in range(20):
            try:
                before[outcome((vertices, faces), timeout=0.2)[0]] += 1
            except (ValueError, IndexError):  # of numpy, which saw two shapes or values of one array
                before["refused"] += 1
    finally:
        over.set()
        changer.join()
        sys.setswitchinterval(interval)
    return "interval" if before["interval"] else "refused"


def threads(dice):
    """Twenty threads compare the same arrays, beside one that is interrupted, and get the same bits."""
    mesh, found, failed = shapes.sphere(8), [], []
    wanted = outcome(mesh, shapes.sphere(6))

    def compare():
        try:
            for _ in range(3):
                found.append(outcome(mesh, shapes.sphere(6)))
                gc.collect()
        except BaseException as error:
            failed.append(repr(error))

    def endless():
        try:
            meshgauge.compare(shapes.grid(30), shapes.grid(33), tolerance=0, strategy="four_point", timeout=9,
                              threads=1)
        except KeyboardInterrupt:
            found.append(wanted)

    interrupted = threading.Thread(target=endless)
    all_of_them = [interrupted, *(threading.Thread(target=compare) for _ in range(20))]
    for one in all_of_them:
        one.start()
    time.sleep(dice.uniform(0, 0.1))
    interrupt(interrupted)
    for one in all_of_them:
        one.join(CHILD_SECONDS)
        demand(not one.is_alive(), "a thread does not end")
    demand(not failed and set(found) == {wanted}, failed, set(found), "and not", wanted)
    return "interval"


def interrupt(thread):
    """Raises KeyboardInterrupt in a thread until it has ended."""
    for _ in range(1000):
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident), ctypes.py_object(KeyboardInterrupt))
        thread.join(0.05)
        if not thread.is_alive():
            return


def forks(dice):
    """A process that is forked while others compare compares as well, or says that it cannot."""
    mesh = shapes.grid(4)
    endless = {"tolerance": 0, "strategy": "four_point", "timeout": 0.3}
    busy = [threading.Thread(target=outcome, args=(shapes.grid(20), shapes.grid(23)), kwargs=endless)
            for _ in range(dice.randrange(3))]
    for one in busy:
        one.start()
    time.sleep(dice.uniform(0, 0.05))
    child = os.fork()
    if child == 0:
        code = 2
        try:
            result = meshgauge.compare(mesh, OTHER, threads=dice.randrange(1, 4))
            code = 0 if result.lower <= DISTANCE <= result.upper else 3
        except (*ERRORS, RuntimeError):
            code = 1
        finally:
            os._exit(code)
    code = ended(child)
    for one in busy:
        one.join()
    demand(code in (0, 1), "a forked process ended by", code)
    return ("interval", "refused")[code]


def ended(child):
    """The exit code of a child; it is killed if it does not end in time."""
    end = time.monotonic() + FORK_SECONDS
    while time.monotonic() < end:
        process, status = os.waitpid(child, os.WNOHANG)
        if process:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "a hang"


IN_AN_INTERPRETER = """
import sys
sys.path[:] = %r
import meshgauge
square = "v 0 0 %%d\\nv 1 0 %%d\\nv 0 1 %%d\\nf 1 2 3\\n"
result = meshgauge.compare((square %% (0, 0, 0)).encode(), (square %% (2, 2, 2)).encode(), threads=1)
assert result.lower <= 2 <= result.upper, result
"""


def interpreters(dice):
    """Another interpreter of the process compares, or says that it cannot."""
    try:
        import _xxsubinterpreters as module
    except ImportError:
        try:
            import _interpreters as module
        except ImportError:
            return "refused"
    for _ in range(dice.randrange(1, 4)):
        other = module.create()
        try:
            failed = getattr(module, "run_string")(other, IN_AN_INTERPRETER % sys.path)  # None before Python 3.13
        except Exception as error:  # a class of its own
            failed = error
        demand(failed is None or "ImportError" in str(failed), failed)
        module.destroy(other)
        holds(outcome(shapes.grid(2)), "the first interpreter")
    return "interval" if failed is None else "refused"


# How often each is tried in one process.
KINDS = {arrays: 300, objects: 200, changing: 4, threads: 3, forks: 20, interpreters: 3}
IN_PART = {arrays: 60, objects: 60, changing: 1, threads: 1, forks: 3, interpreters: 1}


def tried(kind, count, dice):
    """So many attempts; prints what came of them."""
    found = collections.Counter(kind(dice) for _ in range(count))
    print(json.dumps({"kind": kind.__name__, **found}), flush=True)


def child(kinds, counts, number):
    if SANITIZED:
        hostile_arrays.CLAIMS.clear()
    else:
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    for kind in kinds:
        tried(kind, counts[kind], random.Random("%s %d" % (kind.__name__, number)))


def attempt(names, number, in_part):
    """One process; its counts, and why it failed, or None."""
    command = [sys.executable, __file__, "--child", *names, "--seed", str(number), *(["--in-part"] if in_part else [])]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=CHILD_SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return [], "hangs: %s" % command
    counts = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    return counts, None if done.returncode == 0 else "exit %d of %s: %s" % (done.returncode, command,
            done.stderr[-1500:])


def campaign(seconds, number, in_part):
    """Returns how many attempts were broken."""
    began, totals, broken, processes = time.monotonic(), collections.defaultdict(collections.Counter), [], 0
    names = [kind.__name__ for kind in KINDS if not SANITIZED or kind not in (forks, interpreters)]
    while processes == 0 or time.monotonic() - began < seconds:
        for some in ([names] if in_part else [[name] for name in names]):
            counts, failed = attempt(some, number + processes, in_part)
            processes += 1
            for line in counts:
                totals[line.pop("kind")].update(line)
            if failed:
                broken.append(failed)
                print("BROKEN: " + failed, flush=True)
    print("python: seed %d, %d processes in %.0f s; %s; broken: %d" % (
        number, processes, time.monotonic() - began,
        ", ".join("%s: %s" % (kind, dict(found)) for kind, found in totals.items()), len(broken)))
    return len(broken) or not totals


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="./dev chaos python", description=__doc__)
    parser.add_argument("--seconds", type=float, default=300, help="each kind is tried once at least")
    parser.add_argument("--seed", type=seed, default=random.SystemRandom().randrange(1 << 30), help="`today`: the date")
    parser.add_argument("--in-part", action="store_true", help="some of each kind, in one process")
    parser.add_argument("--child", nargs="+", metavar="KIND", help="these kinds, in this process")
    given = parser.parse_args(arguments)
    if given.child:
        kinds = [kind for kind in KINDS if kind.__name__ in given.child]
        return child(kinds, IN_PART if given.in_part else KINDS, given.seed)
    print("seed %d" % given.seed, flush=True)
    return campaign(given.seconds, given.seed, given.in_part)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        tempfile.tempdir = folder
        sys.exit(main())
