#!/usr/bin/python3
"""Breaks the engine on purpose, one line at a time, and expects the tests to notice.

usage: run.py [--check] [--only TEXT ...] [--jobs N] [--markdown]

Each mutation replaces one exact piece of text in a copy of the sources, builds engine_tests and the campaigns of tests/fuzz,
and runs the campaign that its description names (fuzz_certify: none), then the tests. A mutation that survives or does not
compile makes the run fail; so does, before anything is built, one of the whole list that no longer applies. docs/mutations.md
records the last full run.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import queue
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# By how the description begins. The unmutated engine passes hundreds of thousands of pairs.
CAMPAIGNS = {
    "": ["fuzz_certify", "--seconds", "25", "--threads", "1", "--seed", "1"],
    "areas:": ["fuzz_certify", "areas", "--pairs", "3000", "--seed", "1"],
    "sides:": ["fuzz_certify", "sides", "--pairs", "2000", "--seed", "1"],
    "regions:": ["fuzz_certify", "regions", "--pairs", "2000", "--seed", "1"],
}

# what it breaks, file, text, replacement
MUTATIONS = [
    # rounding constants
    ("no slack for a computed distance", "engine/rounding.h", "kDistanceSlack = 64 * kUnit", "kDistanceSlack = 0 * kUnit"),
    ("no slack for the separating planes of the lower bound", "engine/rounding.h",
     "kSeparationSlack = 32 * kUnit", "kSeparationSlack = 0 * kUnit"),
    ("no slack for midpoints", "engine/rounding.h", "kMidpointSlack = 2 * kUnit", "kMidpointSlack = 0 * kUnit"),
    ("the overlay's half-planes are not moved", "engine/rounding.h",
     "kOverlayOffset = 128 * kUnit", "kOverlayOffset = 0 * kUnit"),
    ("the boxes in single precision are not padded", "engine/rounding.h", "kOffsetPad = 0x1p-22", "kOffsetPad = 0"),
    ("boxes are skipped a little too early", "engine/kernels/kernels.h",
     "best_sq * (1 + 0x1p-18) + 0x1p-100", "best_sq * (1 - 0x1p-10)"),
    # dropped slacks and outward rounding
    ("the upper bound without its slack", "engine/rounding.h",
     "return kDistanceSlack + residual + kMidpointSlack * max_depth;", "return 0 * (residual + max_depth);"),
    ("queries do not poll whether to stop", "engine/search/search.h", "return &stop_;", "return nullptr;"),
    ("an inner witness counts as lying on A", "engine/search/certify.cpp",
     "std::min(*below, beyond), off)", "std::min(*below, beyond), 0 * off)"),
    ("the lower bound is scaled back to nearest", "engine/rounding.cpp",
     "> x ? std::nextafter(scaled, 0.0) : scaled", "> x ? scaled : scaled"),
    ("the upper bound is scaled back to nearest", "engine/rounding.cpp",
     "< x ? up(scaled) : scaled", "< x ? scaled : scaled"),
    # culling and accounting
    ("the cull loses the bounds that it drops", "engine/search/search.h",
     "void drop(double upper) { dropped_ = std::max(dropped_, upper); }", "void drop(double) {}"),
    ("the bound that the overlay could not resolve is lost", "engine/search/search_worker.h",
     "    unresolved_ = std::max(unresolved_, upper);\n    drop(upper);\n", "    unresolved_ = std::max(unresolved_, upper);\n"),
    ("a worker loses the bounds that it drops", "engine/search/search_worker.h",
     "void drop(double upper) { dropped_ = std::max(dropped_, upper); }", "void drop(double) {}"),
    ("the bounds that a worker dropped are lost in absorb()", "engine/search/search.cpp", "  drop(worker.dropped_);\n", ""),
    ("the pieces that the heap has not taken in do not count", "engine/search/search.cpp",
     "heap_ > 0 ? std::max(waiting_.front().upper, pushed_) : pushed_", "heap_ > 0 ? waiting_.front().upper : 0"),
    ("the cull uses twice the tolerance", "engine/search/search.cpp",
     "lower + gap(lower, slack.to_come())", "lower + 2 * gap(lower, slack.to_come())"),
    # the patch certificate
    ("open edges do not fail a triangle", "engine/fast/bounds/patch.cpp",
     "if (meets_open_edge(piece, ground, cover.near)) return {};", "(void)meets_open_edge(piece, ground, 0);"),
    ("partners that run in the same direction count", "engine/fast/bounds/patch.cpp",
     "return to != partner_from && mesh.positions[to] != mesh.positions[partner_from];", "return (void)to, (void)partner_from, false;"),
    ("partners that were not gathered count", "engine/fast/bounds/patch.cpp",
     "if (!partner || !gathered(partner->triangle)) return true;", "if (!partner) return true;"),
    ("triangles within phi are left out", "engine/kernels/patch.inc",
     "const V far = within + gap.error;", "const V far = within * spread(0.25) - gap.error;"),
    ("only what lies under the first of eight triangles is looked at", "engine/fast/bounds/patch.cpp",
     "  const Extent box = extent_of(block);\n", "  Extent box = extent_of(block);\n  box.high_x = block.high_x[0];\n"),
    ("the inner point need not be covered", "engine/fast/bounds/patch.cpp",
     "if (result.under == Nearest::kNone) return {};", ""),
    ("a patch's bound of the clipped triangles is lost", "engine/fast/bounds/patch.cpp",
     "    if (upper > limit) return false;\n", ""),
    ("the inner point may lie in a triangle beyond phi", "engine/fast/bounds/patch.cpp",
     "const unsigned inner = cover.inner & cover.near; inner != 0", "const unsigned inner = cover.inner; inner != 0"),
    ("a patch bounds one corner of the common part", "engine/fast/bounds/patch.cpp",
     "for (std::size_t i = 0; i < common.size; ++i) {", "for (std::size_t i = 0; i < common.size && i < 1; ++i) {"),
    ("the difference of height is narrowed by two corners", "engine/kernels/patch.inc",
     "for (std::size_t c = 0; c < 3; ++c) {\n    const V of_piece", "for (std::size_t c = 0; c < 2; ++c) {\n    const V of_piece"),
    ("no slack for heights", "engine/rounding.h", "kPatchHeightError = 1024 * kUnit", "kPatchHeightError = 0 * kUnit"),
    ("no slack for the patch", "engine/rounding.h", "kPatchSlack = 128 * kUnit", "kPatchSlack = 0 * kUnit"),
    ("the patch's half-planes are not moved", "engine/rounding.h", "kPatchOffset = 128 * kUnit", "kPatchOffset = 0 * kUnit"),
    ("triangles seen edge-on are projected", "engine/rounding.h", "kPatchThinnest = 0x1p10", "kPatchThinnest = 0x1p60"),
    # the front
    ("the bound by movement uses two corners", "engine/fast/front.cpp",
     "std::max(std::max(sq_[triangle[0]], sq_[triangle[1]]), sq_[triangle[2]])",
     "std::max(sq_[triangle[0]], sq_[triangle[1]])"),
    ("the bound by a point of B forgets a corner's mark", "engine/fast/front.cpp",
     "vertices_[a].marks & vertices_[b].marks & vertices_[c].marks", "vertices_[a].marks & vertices_[b].marks"),
    ("the bound of what the front left out is lost", "engine/measure/measurement.cpp", "  search.drop(direction.left_out);\n", ""),
    ("the lower bound may exceed the reach of a part of B", "engine/search/certify.cpp", "std::min(*below, beyond)", "*below"),
    ("a box is not widened by its reach", "engine/tree/vicinity.cpp",
     "cell(box.high[axis] + on_axis, axis)", "cell(box.high[axis] + 0 * on_axis, axis)"),
    ("a triangle that spans many cells is looked up by one corner", "engine/tree/vicinity.cpp",
     "neighbours(a, b) & neighbours(a, c) ? first : spread", "neighbours(a, b) | neighbours(a, c) ? first : spread"),
    ("boxes within reach are skipped a little too early", "engine/tree/vicinity.cpp",
     "near.reach_sq * kNearer + kLeast", "near.reach_sq * (1 - 0x1p-10)"),
    ("off by one: the last triangle of a leaf of A is skipped", "engine/paper/traversal.cpp",
     "t < from_.block_end(block); ++t", "t + 1 < from_.block_end(block); ++t"),
    ("off by one: the last triangle of a block of A is skipped", "engine/fast/sweep.cpp",
     "t < block.end; ++t) {\n        const double known", "t + 1 < block.end; ++t) {\n        const double known"),
    ("off by one: the last triangle of a leaf of B is skipped", "engine/tree/nearest.cpp",
     "t < tree.block_end(block); ++t", "t + 1 < tree.block_end(block); ++t"),
    ("off by one: a kernel skips the last lane", "engine/kernels/simd.cpp",
     "for (std::uint32_t lane = 0; lane < kLanes32; ++lane) {", "for (std::uint32_t lane = 0; lane + 1 < kLanes32; ++lane) {"),
    ("an interrupted traversal loses the open nodes", "engine/paper/traversal.cpp",
     "search_.set_unvisited(upper);", "search_.set_unvisited(0 * upper);"),
    ("an interrupted sweep loses the rest", "engine/fast/sweep.cpp",
     "search_.set_unvisited(blocks_[begin].upper);", "search_.set_unvisited(0);"),
    ("an interrupted block counts as visited", "engine/fast/sweep.cpp",
     "if (sweeper.worker.interrupted()) return sweeper.worker.forget_beyond(pieces);",
     "if (sweeper.worker.interrupted()) { sweeper.worker.forget_beyond(pieces); break; }"),
    ("the sweep drops the rest but loses its bound", "engine/fast/sweep.cpp",
     "search_.drop(blocks_[begin].upper);", ""),
    ("one of four parts is lost", "engine/paper/reduction.cpp", "    add({ab, bc, ca}, piece);\n", ""),
    ("one of two halves is lost", "engine/fast/bisection.cpp", "    add({middle, b, c}, piece, too_far && !at_a);\n", ""),
    # bounds
    ("the bound of a piece uses two corners only", "engine/search/piece.h",
     "at[2] = corners[2].point[k];", "at[2] = corners[1].point[k];"),
    ("a triangle with two corners in common counts as shared", "engine/mesh/mesh_index.cpp",
     "(equal(1, k) && equal(2, l)) || (equal(1, l) && equal(2, k))", "equal(1, k) || equal(1, l)"),
    ("the Lipschitz radius is too small", "engine/fast/bounds/lipschitz.h", "+ kRoundUp * enclosing", "+ 0.9 * enclosing"),
    ("the owner cut bounds the cut points alone", "engine/fast/bounds/owner_cut.cpp",
     "upper = std::max(upper, at_i[k] ? distances[i] : distances[j]);", "upper = at_i[k] ? 0 : 0;"),
    ("the owner cut bounds its cut points by the nearer triangle", "engine/fast/bounds/owner_cut.cpp",
     "most = std::max(to_i, to_j);", "most = std::min(to_i, to_j);"),
    ("the owner cut bounds one of two halves", "engine/fast/bounds/owner_cut.cpp",
     "return verdict == Verdict::bounded ? bound({middle, b, c}, depth - 1) : verdict;", "return verdict;"),
    ("the bound that the owner cut could not resolve is lost", "engine/fast/bisection.cpp",
     "if (upper) *upper > worker_.cull_within_tolerance() ? worker_.cull_unresolved(*upper) : worker_.drop(*upper);",
     "if (upper && *upper > worker_.cull_within_tolerance()) worker_.cull_unresolved(*upper);"),
    ("the flood starts at a point that may be outside of the piece", "engine/fast/bounds/overlay.cpp",
     "is_inside(*inner, centre) && is_inside(sides, centre)", "is_inside(*inner, centre)"),
    ("the flood starts at a point that may be outside of the image", "engine/fast/bounds/overlay.cpp",
     "is_inside(*inner, centre) && is_inside(sides, centre)", "is_inside(sides, centre)"),
    ("shadows are not bounded", "engine/fast/bounds/overlay.cpp",
     "    if (!view.add(target_.prepared(image.triangle), view.shadow(side, a.at, b.at), work)) return false;\n", ""),
    ("the flood enters neighbours that fold back", "engine/fast/bounds/overlay.cpp",
     "if (!side.surely_outside(view.image_of(apex), kOffset)) continue;", "(void)side;"),
    # certified areas
    ("areas: what is nearly within a limit counts as within", "engine/extras/area/places.cpp", "low_(low - slack_)", "low_(low * 1.2)"),
    ("areas: a block counts as beyond by its middle", "engine/extras/area/places.cpp",
     "&& is_beyond(in_.to, box, high_, stop_)) {", "&& is_beyond(in_.to, Box{(box.low + box.high) / 2, (box.low + box.high) / 2}, high_, stop_)) {"),
    ("areas: what the sweep keeps counts as within", "engine/extras/area/places.cpp",
     "if (places_[t] == Place::unknown && !kept[t])", "if (places_[t] == Place::unknown)"),
    ("areas: the input error does not count for places", "engine/extras/area/places.cpp",
     "rounding::upper_slack(in.to.residual(), 0) + in.error + 32", "rounding::upper_slack(in.to.residual(), 0) + 32"),
    ("areas: a lower function is kept from a walk that ended early", "engine/extras/area/minorant.cpp",
     "> least_sum)) return MinorantFound::too_low;", "> -4)) return MinorantFound::too_low;"),
    ("areas: a block counts as within by its middle", "engine/extras/area/places.cpp",
     "found.distance + farthest_of_box(box, centre) + rounding::kDistanceSlack <= low_", "found.distance <= low_"),
    ("areas: what lies above the overlay's base is lost", "engine/extras/area/part.cpp",
     "base(part.corners[i].point) + *attempt.upper", "base(part.corners[i].point)"),
    ("areas: triangles near the middle alone lower the lower function", "engine/extras/area/minorant.cpp",
     "probe_.limit_sq = far_limit(reach() * reach())", "probe_.limit_sq = far_limit(reach() * reach() / 16)"),
    ("areas: the parts of a cell weigh alike", "engine/extras/area/part.cpp",
     "part.weight * (area / whole)", "part.weight * (0.1 + 0 * area / whole)"),
    ("areas: a cell's upper function is that of nearer corners", "engine/extras/area/part.cpp",
     "one.corners[k].distance + slack_high", "0.9 * one.corners[k].distance + slack_high"),
    ("areas: a cut divides the area in halves", "engine/extras/area/part.cpp",
     "part.weight * (second ? 1 - cut.at : cut.at)", "part.weight / 2"),
    ("areas: a quantile is sought by a smaller share", "engine/extras/area/totals.cpp",
     "share(sum).upper <= 1 - p - kRound", "share(sum).upper <= 1 - 0.9 * p - kRound"),
    ("areas: the last of the cells counts twice", "engine/extras/area/area_rounds.cpp", "    cells->parts.pop_back();\n", ""),
    ("areas: one cell takes the place of all", "engine/extras/area/area_rounds.cpp",
     "refined.others = std::move(cells->parts);", "refined.others = {};"),
    ("areas: the points of a fan do not lower the lower function from the fourth on", "engine/extras/area/minorant.cpp",
     "for (std::size_t i = 1; i < size(); ++i) top =", "for (std::size_t i = 1; i < 2; ++i) top ="),
    ("areas: what foresight closes does not count", "engine/extras/area/area_search.cpp",
     "      closed_early_ += contribution;\n      close(part);\n", "      closed_early_ += contribution;\n"),
    ("areas: cells may cover a part twice", "engine/extras/area/part.cpp", "std::abs(sum - whole) + rounding", "0 * std::abs(sum - whole) + rounding"),
    ("areas: the last corner of a cell is left out", "engine/extras/area/part.cpp",
     "for (std::size_t i = 2; i < polygon.size; ++i)", "for (std::size_t i = 2; i < std::max<std::size_t>(polygon.size, 4) - 1; ++i)"),
    ("areas: cells end where B does", "engine/fast/bounds/overlay.cpp", "    if (view.takes_cells) return false;\n", "    if (view.takes_cells) continue;\n"),
    ("areas: what the search for the largest distance left out counts as within", "engine/measure/measurement.cpp",
     "direction.bounds.assign(from.given, rounding::float_up(left_out));", "direction.bounds.assign(from.given, 0 * rounding::float_up(left_out));"),
    ("areas: the input error does not count for bounds of the search", "engine/extras/area/places.cpp",
     "rounding::subtract_down(given_low_, in_.error)", "given_low_"),
    ("areas: a triangle of which only a vertex was searched counts as searched", "engine/measure/measurement.cpp",
     "  of_first = std::max(of_first, rounding::float_up(left_out));\n", "  static_cast<void>(of_first);\n"),
    ("areas: a block that the search drops counts as within", "engine/fast/sweep.cpp", "search_.note(t, block.upper);", "search_.note(t, 0 * block.upper);"),
    # sides
    ("sides: a ray passes what lies behind its start", "engine/extras/area/winding.cpp", "  if ((towards > 0) != ray.up) return 0;\n", ""),
    ("sides: a passing has no direction", "engine/extras/area/winding.cpp", "return ray.up ? least : -least;", "return least * least;"),
    ("sides: a ray skips boxes a little too early", "engine/extras/area/winding.cpp",
     "std::min(a, b) <= high + kWide", "std::min(a, b) <= high - 0.01"),
    ("sides: the other side is bounded by the corners alone", "engine/extras/area/side_search.cpp",
     "found = std::max(found, high[i] + at * (high[j] - high[i]) + rounding::kCutValueSlack);", "(void)at;"),
    ("sides: the bounds of closed parts are lost", "engine/extras/area/side_search.cpp",
     "std::max(closed_[side], upper[side])", "std::max(closed_[side], 0 * upper[side])"),
    # regions
    ("regions: a ball's outer plane is too near", "engine/mesh/clipping.cpp",
     "sphere.centre, r * (1 + kSlack), -1}", "sphere.centre, r * (1 - 0x1p-6), -1}"),
    ("regions: a ball's inner plane touches it", "engine/mesh/clipping.cpp", "inner.offset = chord;", "inner.offset = chord < r ? r : 0;"),
    ("regions: what may belong to a part does not count", "engine/measure/region_stage.cpp",
     "    bounds.upper = std::max(bounds.upper, doubtful.upper);  // it may have no point of the part\n", "    (void)doubtful;\n"),
    ("regions: the rest loses what lies beyond a side of a box", "engine/mesh/clipping.cpp",
     "if (keep_ == Keep::outside) emit(beyond(pieces, side), out);", "if (keep_ == Keep::outside && f > 0) emit(beyond(pieces, side), out);"),
    ("regions: the gap between two copies does not count", "engine/mesh/clipping.cpp",
     "sure.err(wide <= resolution ? rounding::add_up(wide, moved) : moved);", "sure.err(moved);"),
    # moved meshes
    ("the rounding of a moved corner's products does not count", "engine/mesh/rigid.cpp", "lost += off + sum.error;", "lost += sum.error;"),
    ("the rounding of a moved corner does not count", "engine/mesh/rigid.cpp",
     "std::abs(last.error) + rounding::kMotionSlack * size", "0 * std::abs(last.error)"),
    ("the error of a mesh before it was moved is lost", "engine/rounding.h", "(of_rounding + before) * (1 + 0x1p-40)", "of_rounding * (1 + 0x1p-40)"),
]


def run(command, **kwargs):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **kwargs)


def campaign_of(what):
    return next(CAMPAIGNS[begin] for begin in sorted(CAMPAIGNS, reverse=True) if what.startswith(begin))


def caught_by(build, campaign, in_full=False):
    """The first test that fails with its message, or None. The whole run: fuzz_certify goes on after its first violation."""
    keeps_going = in_full and campaign == CAMPAIGNS[""]
    for folder, command, figures in (("fuzz", campaign + ["--keep-going"] * keeps_going, figures_of_campaign),
                                     ("engine", ["engine_tests"], figures_of_tests)):
        name, *flags = command
        try:
            done = run([str(build / "tests" / folder / name), *flags], cwd=build, timeout=600)
        except subprocess.TimeoutExpired:
            return name, "", "does not end"
        if done.returncode != 0:
            return name, *figures(done.stdout)
    return None


def figures_of_campaign(text):
    """How many pairs, and how many violations of each kind."""
    violations = collections.Counter(re.findall(r"^VIOLATION of '(\w+)'", text, re.M))  # the others end at their first
    for count, kind in re.findall(r"^(\d+) violations of (\w+)", text, re.M):
        violations[kind] += int(count)
    pairs = re.findall(r"(\d+) pairs ", text)
    return f"{int(pairs[-1]):,}" if pairs else "", ", ".join(f"{n:,} {kind}" for kind, n in violations.most_common())


def figures_of_tests(text):
    """The tests that failed; those that only print a message are left out."""
    failed = "".join(part for part in re.split(r"^=+$", text, flags=re.M) if "ERROR: " in part)
    return "", "; ".join(dict.fromkeys(re.findall(r"^TEST CASE:  (.*)$", failed, re.M)))


class Tree:
    """A copy of the sources with a build of its own."""

    def __init__(self, folder, compilers):
        self.source, self.build, self.compilers = folder / "source", folder / "build", str(compilers)
        shutil.copytree(ROOT, self.source, ignore=shutil.ignore_patterns(".*", "build", "build-*", "node_modules"))

    def configured(self):
        return run(["cmake", "-S", str(self.source), "-B", str(self.build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DMESHGAUGE_BUILD_SERVICE=OFF", "-DMESHGAUGE_WERROR=OFF"])

    def built(self):
        return run(["cmake", "--build", str(self.build), "--parallel", self.compilers,
                    "--target", "engine_tests", *(campaign[0] for campaign in CAMPAIGNS.values())])

    def verdict(self, mutation, in_full):
        """What notices the mutation, after how many pairs, and how; in capitals: nothing did."""
        what, name, text, replacement = mutation
        path = self.source / name
        original = path.read_text()
        path.write_text(original.replace(text, replacement))
        failed = self.built().returncode
        found = ("DOES NOT COMPILE", "", "") if failed else caught_by(self.build, campaign_of(what), in_full)
        path.write_text(original)
        return found or ("SURVIVES", "", "")


def trees_in(folder, jobs):
    """As many trees, whose tests pass; in a queue, from which each job takes one at a time."""
    free, trees = queue.SimpleQueue(), [Tree(folder / str(i), max(1, os.cpu_count() // jobs)) for i in range(jobs)]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for tree, done in zip(trees, pool.map(lambda tree: (tree.configured(), tree.built())[1], trees)):
            if done.returncode != 0:
                sys.exit("it does not build without any mutation\n" + done.stdout[-3000:])
            free.put(tree)
    if found := caught_by(trees[0].build, CAMPAIGNS[""]):
        sys.exit(f"{found[0]} fails without any mutation: {found[2]}")
    return free


def places(root, name, text):
    return (root / name).read_text().count(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="only see whether every mutation still applies")
    parser.add_argument("--only", action="append", metavar="TEXT", help="only mutations whose description holds this text")
    parser.add_argument("--jobs", type=int, default=1, help="as many mutations at once, each in a tree of its own")
    parser.add_argument("--markdown", action="store_true", help="print the table of docs/mutations.md")
    args = parser.parse_args()
    stale = ["does not apply (%d places): %s" % (places(ROOT, name, text), what)
             for what, name, text, _ in MUTATIONS if places(ROOT, name, text) != 1]
    if stale:
        sys.exit("\n".join(stale))
    if args.check:
        return print("%d mutations apply" % len(MUTATIONS))
    chosen = [m for m in MUTATIONS if not args.only or any(text in m[0] for text in args.only)]
    failures = 0
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        free = trees_in(pathlib.Path(folder), args.jobs)

        def judge(mutation):
            tree = free.get()
            try:
                return tree.verdict(mutation, args.markdown)
            finally:
                free.put(tree)

        judged = {pool.submit(judge, mutation): mutation[0] for mutation in chosen}
        for done in concurrent.futures.as_completed(judged):
            what, verdict = judged[done], done.result()
            failures += verdict[0].isupper()
            print("| %s | %s |" % (what, " | ".join(verdict)) if args.markdown else "%-20s %s" % (verdict[0], what), flush=True)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
