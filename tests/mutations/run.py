#!/usr/bin/python3
"""Breaks the engine on purpose, one line at a time, and expects the tests to notice.

usage: run.py [--check] [--only TEXT] [--markdown]

Each mutation replaces one exact piece of text in a copy of the sources, builds engine_tests and fuzz_certify, and runs them. A
mutation that survives or does not compile makes the run fail; so does, before anything is built, one of the whole list that no
longer applies. docs/mutations.md records the last full run.
"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECONDS = "25"  # of fuzz_certify on one thread; the unmutated engine passes hundreds of thousands of pairs

# what it breaks, file, text, replacement
MUTATIONS = [
    # rounding constants
    ("no slack for a computed distance", "engine/rounding.h", "kDistanceSlack = 64 * kUnit", "kDistanceSlack = 0 * kUnit"),
    ("no slack for the separating planes of the lower bound", "engine/rounding.h",
     "kSeparationSlack = 32 * kUnit", "kSeparationSlack = 0 * kUnit"),
    ("no slack for midpoints", "engine/rounding.h", "kMidpointSlack = 2 * kUnit", "kMidpointSlack = 0 * kUnit"),
    ("the overlay's half-planes are not moved", "engine/rounding.h",
     "kOverlayOffset = 128 * kUnit", "kOverlayOffset = 0 * kUnit"),
    # dropped slacks and outward rounding
    ("the upper bound without its slack", "engine/rounding.h",
     "return kDistanceSlack + residual + kMidpointSlack * max_depth;", "return 0 * (residual + max_depth);"),
    ("an inner witness is taken to be on A", "engine/certify.cpp",
     "certified_distance_below(search.to(), w), off)", "certified_distance_below(search.to(), w), 0 * off)"),
    ("the lower bound is scaled back to nearest", "engine/rounding.cpp",
     "> x ? std::nextafter(scaled, 0.0) : scaled", "> x ? scaled : scaled"),
    ("the upper bound is scaled back to nearest", "engine/rounding.cpp",
     "< x ? std::nextafter(scaled, std::numeric_limits<double>::infinity()) : scaled", "< x ? scaled : scaled"),
    # culling and accounting
    ("the cull forgets what it drops", "engine/search.h",
     "void drop(double upper) { dropped_ = std::max(dropped_, upper); }", "void drop(double) {}"),
    ("what the overlay could not resolve is forgotten", "engine/search.h", "    drop(upper);\n", "    (void)upper;\n"),
    ("the cull takes twice the tolerance", "engine/search.h",
     "lower_ + goal_.gap(lower_, slack_to_come())", "lower_ + 2 * goal_.gap(lower_, slack_to_come())"),
    ("off by one: the last triangle of a leaf of A is skipped", "engine/traversal.cpp",
     "slot < node.first + node.count; ++slot", "slot + 1 < node.first + node.count; ++slot"),
    ("off by one: the last triangle of a leaf of B is skipped", "engine/nearest.cpp",
     "slot < leaf.first + leaf.count; ++slot) attempt(slot)", "slot + 1 < leaf.first + leaf.count; ++slot) attempt(slot)"),
    ("an interrupted traversal forgets the open nodes", "engine/traversal.cpp",
     "search_.set_unvisited(upper);", "search_.set_unvisited(0 * upper);"),
    ("an interrupted sweep forgets the rest", "engine/sweep.cpp",
     "search_.set_unvisited(blocks_[i].upper);", "search_.set_unvisited(0);"),
    ("the sweep drops the rest but forgets its bound", "engine/sweep.cpp",
     "        search_.drop(blocks_[i].upper);\n        break;", "        break;"),
    ("one of four parts is lost", "engine/reduction.cpp", "    add({ab, bc, ca}, piece);\n", ""),
    ("one of two halves is lost", "engine/bisection.cpp", "    add({middle, b, c}, piece);\n", ""),
    # bounds
    ("the bound of a piece looks at two corners", "engine/bounds/piece.h",
     "  for (const Corner& corner : piece.corners) {\n    farthest",
     "  for (const Corner& corner : {piece.corners[0], piece.corners[1]}) {\n    farthest"),
    ("the Lipschitz radius is too small", "engine/bounds/lipschitz.h", "+ kRoundUp * enclosing", "+ 0.9 * enclosing"),
    ("shadows are not bounded", "engine/bounds/overlay.cpp",
     "    if (!view.add(triangle, view.shadow(*side, a.at, b.at), work)) return false;\n", "    (void)triangle;\n"),
    ("the flood enters neighbours that fold back", "engine/bounds/overlay.cpp",
     "if (!side.surely_outside(apex.at, kOffset)) continue;", "(void)side;"),
]


def run(command, **kwargs):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **kwargs)


def caught_by(build):
    """The first test that fails, or None."""
    for command in (["tests/fuzz/fuzz_certify", "--seconds", SECONDS, "--threads", "1"], ["tests/engine/engine_tests"]):
        name = pathlib.Path(command[0]).name
        try:
            if run([str(build / command[0])] + command[1:], cwd=build, timeout=600).returncode != 0:
                return name
        except subprocess.TimeoutExpired:
            return name + " (does not end)"
    return None


def build_tree(source, build, configure):
    if configure:
        done = run(["cmake", "-S", str(source), "-B", str(build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DMESHGAUGE_BUILD_SERVICE=OFF", "-DMESHGAUGE_WERROR=OFF"])
        if done.returncode != 0:
            return done
    return run(["ninja", "-C", str(build), "engine_tests", "fuzz_certify"])


def places(root, name, text):
    return (root / name).read_text().count(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="only see whether every mutation still applies")
    parser.add_argument("--only", default="", help="only mutations whose description holds this text")
    parser.add_argument("--markdown", action="store_true", help="print the table of docs/mutations.md")
    args = parser.parse_args()
    stale = ["does not apply (%d places): %s" % (places(ROOT, name, text), what)
             for what, name, text, _ in MUTATIONS if places(ROOT, name, text) != 1]
    if stale:
        sys.exit("\n".join(stale))
    if args.check:
        return print("%d mutations apply" % len(MUTATIONS))
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        source, build = pathlib.Path(folder) / "source", pathlib.Path(folder) / "build"
        shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(".git", "build*", "node_modules"))
        done = build_tree(source, build, True)
        if done.returncode != 0 or caught_by(build):
            sys.exit("the tests fail without any mutation\n" + done.stdout[-3000:])
        for what, name, text, replacement in MUTATIONS:
            if args.only not in what:
                continue
            path = source / name
            original = path.read_text()
            path.write_text(original.replace(text, replacement))
            built = build_tree(source, build, False)
            verdict = "DOES NOT COMPILE" if built.returncode else caught_by(build) or "SURVIVES"
            path.write_text(original)
            failures += verdict.isupper()
            print("| %s | `%s` | %s |" % (what, name, verdict) if args.markdown else "%-40s %s" % (verdict, what), flush=True)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
