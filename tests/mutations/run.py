#!/usr/bin/python3
"""Breaks the engine on purpose, one line at a time, and expects the tests to notice.

usage: run.py [--build DIR] [--only TEXT] [--markdown]

Each mutation replaces one exact piece of text in a copy of the sources, builds engine_tests and fuzz_certify, and runs them. A
mutation that survives, does not compile or no longer applies makes the run fail. docs/mutations.md records the last full run.
"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAIRS = "3000"  # of the exact oracle; the unmutated engine passes hundreds of thousands

# what it breaks, file, text, replacement
MUTATIONS = [
    ("a rounding constant: the certified lower bound is rounded up, not down", "engine/rounding.h",
     "kSeparationSlack = 32 * kUnit", "kSeparationSlack = -32 * kUnit"),
    ("a rounding constant: no slack for a computed distance, residual included", "engine/rounding.h",
     "return kDistanceSlack + residual + kMidpointSlack * max_depth;", "return -0.0 * (residual + max_depth);"),
    ("a dropped slack: the certified upper bound without it", "engine/certify.cpp",
     "rounding::add_up(search.upper(), search.upper_slack())", "search.upper()"),
    ("a dropped slack: an inner witness is taken to be on A", "engine/certify.cpp",
     "const double off = distance_above(", "const double off = 0 * distance_above("),
    ("outward rounding: scaling back rounds to nearest", "engine/rounding.cpp",
     "return std::ldexp(scaled, -exponent) < x ?", "return false ?"),
    ("an off-by-one in the cull: the last triangle of a leaf of A is skipped", "engine/traversal.cpp",
     "slot < node.first + node.count; ++slot", "slot + 1 < node.first + node.count; ++slot"),
    ("an off-by-one in the cull: the last triangle of a leaf of B is skipped", "engine/nearest.cpp",
     "slot < leaf.first + leaf.count; ++slot) attempt(slot)", "slot + 1 < leaf.first + leaf.count; ++slot) attempt(slot)"),
    ("the cull forgets what it drops", "engine/search.h",
     "dropped_ = std::max(dropped_, upper);", "(void)upper;"),
    ("the cull drops a little too much", "engine/search.cpp",
     "if (!goal_.gate) return lower_;", "if (!goal_.gate) return lower_ * 1.001;"),
    ("an interrupted traversal forgets the open nodes", "engine/traversal.cpp",
     "search_.set_unvisited(upper);", "search_.set_unvisited(0);"),
    ("an interrupted sweep forgets the rest", "engine/sweep.cpp",
     "search_.set_unvisited(blocks_[i].upper);", "search_.set_unvisited(0);"),
    ("the sweep drops the rest but forgets its bound", "engine/sweep.cpp",
     "        search_.drop(blocks_[i].upper);\n        break;", "        break;"),
    ("one of four parts is lost", "engine/reduction.cpp",
     "    add({ab, bc, ca}, piece);\n", ""),
    ("one of two halves is lost", "engine/bisection.cpp",
     "    add({middle, b, c}, piece);\n", ""),
    ("the bound of a piece looks at two corners", "engine/bounds/piece.h",
     "for (const Corner& corner : piece.corners) {", "for (const Corner& corner : {piece.corners[0], piece.corners[1]}) {"),
    ("the Lipschitz radius is too small", "engine/bounds/lipschitz.h",
     "return std::max({a.distance, b.distance, c.distance}) + enclosing_radius",
     "return std::max({a.distance, b.distance, c.distance}) + 0.9 * enclosing_radius"),
    ("blocked edges cast no shadow", "engine/bounds/overlay.cpp",
     "if (side->surely_outside(view.start, kOffset)) continue;", "continue;"),
    ("the flood enters neighbours that fold back", "engine/bounds/overlay.cpp",
     "if (!side.surely_outside(apex.at, kOffset)) continue;", ""),
    ("the overlay takes the images of shared corners the wrong way round", "engine/bounds/overlay.cpp",
     "std::swap(next.corners[n.edge], next.corners[(n.edge + 1) % 3]);", ""),
    ("the residual of a prepared triangle is not measured", "engine/triangle.cpp",
     "return {t, std::max(at_b, at_c) + rounding::kResidualSlack};", "return {t, 0 * std::max(at_b, at_c)};"),
    ("the base of a triangle is not its longest edge", "engine/triangle.cpp",
     "if (bc > ab && bc >= ca) {", "if (bc < ab && bc >= ca) {"),
    ("a gate fails on a computed bound that is not certified", "engine/hausdorff.cpp",
     "return limit && (outcome_.upper <= *limit || outcome_.lower > *limit);", "return limit.has_value();"),
    ("the second direction forgets what the first one reached", "engine/hausdorff.cpp",
     "outcome_.upper = std::max(outcome_.upper, (*directed)->bounds.upper);",
     "outcome_.upper = (*directed)->bounds.upper;"),
]


def run(command, **kwargs):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **kwargs)


def caught_by(build):
    """The first test that fails, or None."""
    for name, command in (("engine_tests", ["tests/engine/engine_tests"]),
                          ("fuzz_certify", ["tests/fuzz/fuzz_certify", "--pairs", PAIRS, "--threads", "2"])):
        if not (build / command[0]).exists():
            continue
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
    targets = run(["ninja", "-C", str(build), "-t", "targets", "all"]).stdout
    wanted = [t for t in ("engine_tests", "fuzz_certify") if t + ":" in targets]
    return run(["ninja", "-C", str(build)] + wanted)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="only mutations whose description holds this text")
    parser.add_argument("--markdown", action="store_true", help="print the table of docs/mutations.md")
    args = parser.parse_args()
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
            if original.count(text) != 1:
                verdict = "DOES NOT APPLY (%d places)" % original.count(text)
            else:
                path.write_text(original.replace(text, replacement))
                built = build_tree(source, build, False)
                verdict = "DOES NOT COMPILE" if built.returncode else caught_by(build) or "SURVIVES"
                path.write_text(original)
            failures += verdict.isupper() or verdict.startswith("DOES NOT")
            print("| %s | `%s` | %s |" % (what, name, verdict) if args.markdown else "%-40s %s" % (verdict, what), flush=True)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
