// fuzz_certify sides: the extent on each side (engine/sides.h) of random and adversarial pairs against exact signs and
// an independent subdivision.
//
// Each interval must meet the bracket of tests/oracle/sides.h, whenever and for whatever reason the search ends; its
// point must lie on its side by exact arithmetic; a refusal must be true; and two threads must give the bits of one
// if they start from the same bound, without a gate. Ends at the first violation, whose pair it prints.
#include <algorithm>
#include <cstdio>
#include <string>

#include "engine/hausdorff.h"
#include "fuzz/asked.h"
#include "fuzz/attack.h"
#include "fuzz/attacks.h"
#include "fuzz/closed.h"
#include "fuzz/dice.h"
#include "oracle/sides.h"

namespace {

using namespace meshgauge;

// Moves each vertex by up to `most` on each axis, equal ones alike. Returns an upper bound of the largest movement.
double shake_alike(fuzz::Dice& dice, double most, Mesh& mesh) {
  double moved = 0;
  const std::vector<Vec3> given = mesh.positions;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto first = static_cast<std::size_t>(std::find(given.begin(), given.end(), given[i]) - given.begin());
    const Vec3 by = most * dice.point();
    mesh.positions[i] = first < i ? mesh.positions[first] : Vec3(given[i] + by);
    moved = std::max(moved, (mesh.positions[i] - given[i]).norm());
  }
  return moved * (1 + 1e-12);
}

fuzz::Asked ask_sides(fuzz::Dice& dice, const fuzz::Pair& pair, double upper) {
  fuzz::Asked asked;
  asked.a = pair.a;
  asked.b = pair.b;
  if (upper > 1e-20 && dice.chance(0.15)) {
    const double most = upper * dice.power(-6, -1);
    asked.error_a = shake_alike(dice, most, asked.a);
    asked.error_b = shake_alike(dice, most, asked.b);
  }
  Options& options = asked.options;
  options.direction = dice.chance(0.8) ? Direction::a_to_b : Direction::symmetric;
  options.max_work_items = dice.chance(0.1) ? dice.below(4) : 3000;
  if (dice.chance(0.03)) options.max_memory_bytes = 1000 * (1 + dice.below(40));
  if (dice.chance(0.1)) options.thresholds = fuzz::lowered_thresholds(dice);
  const auto simd = supported_simd();
  options.simd = simd[dice.below(static_cast<std::uint32_t>(simd.size()))];
  options.sides.emplace().length_tolerance = dice.power(-3, -1);
  if (dice.chance(0.5)) {
    const auto limit = [&] { return dice.chance(0.1) ? 0 : upper * dice.uniform(0, 1.1); };
    options.sides->limits = {limit(), limit()};
    if (dice.chance(0.3)) options.uncertainty = upper * dice.uniform(0, 0.1);
    options.narrow = dice.chance(0.1);
  }
  if (dice.chance(0.1)) asked.cancel_at = 1 + dice.below(400);
  return asked;
}

bool same(const SideOutcome& x, const SideOutcome& y) {
  const auto equal = [](const SideBounds& a, const SideBounds& b) {
    return a.lower == b.lower && a.upper == b.upper && a.at == b.at && a.triangle == b.triangle;
  };
  return equal(x.outside, y.outside) && equal(x.inside, y.inside) && x.stop == y.stop;
}

// The name of what is violated; empty: nothing.
std::string judge_refusal(const fuzz::Asked& asked, const NoSides& refused, double size) {
  const oracle::Surface surface = oracle::surface_of(asked.b);
  const oracle::Dyadic volume = oracle::volume6(surface);
  switch (refused.why) {
    case NoSides::Why::inside_out:
      return volume.sign() < 0 ? "" : "refused as inside out";
    case NoSides::Why::no_volume:
      return std::abs(volume.approximate()) <= 1e-12 * size * size * size ? "" : "refused as without volume";
    case NoSides::Why::part_inside_out: {
      const oracle::Point p = oracle::exact(*refused.at);
      const auto winding = oracle::winding_number(p, surface);
      if (oracle::root_at_most(oracle::distance_sq(p, surface), 1e-12 * size))
        return "";  // rounding may move it across
      return winding && *winding < 0 ? "" : "refused for a part that is inside out";
    }
    default:
      return "";  // judged by tests of the topology
  }
}

std::string judge_side(const fuzz::Asked& asked, const SideBounds& found, const oracle::SideBracket& bracket,
                       bool inside, double size) {
  const std::string name = inside ? "inside" : "outside";
  const long double slack = 1e-9L * static_cast<long double>(size);
  if (!(0 <= found.lower && found.lower <= found.upper)) return name + ", order";
  if (found.lower > bracket.high + slack || found.upper + slack < bracket.low) return name;
  if ((found.lower > 0) != found.at.has_value()) return name + ", point";
  const double off = 1e-12 * size;
  if (!found.at || found.lower <= off) return "";
  const oracle::Point p = oracle::exact(*found.at);
  const oracle::Surface surface = oracle::surface_of(asked.b);
  if (!oracle::root_at_least(oracle::distance_sq(p, surface), found.lower - off))
    return name + ", distance of its point";
  const oracle::Surface a{oracle::surface_of(asked.a)[found.triangle]};
  if (!oracle::root_at_most(oracle::distance_sq(p, a), off)) return name + ", triangle of its point";
  const auto winding = oracle::winding_number(p, surface);
  return winding && (*winding > 0) == inside && *winding >= 0 ? "" : name + ", side of its point";
}

std::string judge(const fuzz::Pair& pair, const fuzz::Asked& asked, const SideOutcome& found, double size) {
  if (found.refused) return judge_refusal(asked, *found.refused, size);
  const oracle::SidesBracket bracket =
      oracle::bracket_sides(pair.a, pair.b, 150, 1e-12L * static_cast<long double>(size));
  if (bracket.turned) return "";
  std::string violated = judge_side(asked, found.outside, bracket.outside, false, size);
  if (violated.empty()) violated = judge_side(asked, found.inside, bracket.inside, true, size);
  return violated;
}

struct Counts {
  std::uint64_t narrow = 0, refused = 0, both = 0;
};

bool try_pair(std::uint64_t seed, Counts& counts) {
  const fuzz::Pair pair = fuzz::generate_closed(seed);
  fuzz::Dice dice(seed ^ 0x5a5a5a5aU);
  Options plain;
  plain.direction = Direction::a_to_b;
  Control control;
  const fuzz::Asked asked = ask_sides(dice, pair, measure(pair.a, pair.b, plain, control).upper);
  Box box = bounding_box(pair.a);
  box.extend(bounding_box(pair.b));
  const double size = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
  const Outcome outcome = fuzz::run(asked, 1);
  const SideOutcome& found = *outcome.sides;
  if (found.stop == AreaStop::complete && !found.refused) ++counts.narrow;
  if (found.refused) ++counts.refused;
  if (found.inside.lower > 0 && found.outside.lower > 0) ++counts.both;
  std::string violated = judge(pair, asked, found, size);
  if (violated.empty() && !asked.cancel_at && !asked.options.sides->limits && dice.chance(0.1)) {
    const Outcome again = fuzz::run(asked, 2);
    const bool is_same_start = outcome.a_to_b->bounds.upper == again.a_to_b->bounds.upper;
    if (is_same_start && !same(found, *again.sides)) violated = "threads";
  }
  if (violated.empty()) return true;
  std::printf("VIOLATION of '%s', seed %llu: %s\n", violated.c_str(), static_cast<unsigned long long>(seed),
              pair.what.c_str());
  std::printf("outside [%.17g, %.17g], inside [%.17g, %.17g], refused %d, stop %d\n", found.outside.lower,
              found.outside.upper, found.inside.lower, found.inside.upper,
              found.refused ? static_cast<int>(found.refused->why) : -1, static_cast<int>(found.stop));
  std::printf("the measured meshes err by %.17g and %.17g\n", asked.error_a, asked.error_b);
  fuzz::print_obj(pair.a, "a.obj");
  fuzz::print_obj(pair.b, "b.obj");
  return false;
}

}  // namespace

bool meshgauge::fuzz::attack_sides(std::uint64_t pairs, std::uint64_t seed) {
  Counts counts;
  for (std::uint64_t i = 0; i < pairs; ++i) {
    if (!try_pair(seed + i, counts)) return false;
  }
  const auto text = [](std::uint64_t count) { return static_cast<unsigned long long>(count); };
  std::printf("%llu pairs: %llu as narrow as asked, %llu with points on both sides, %llu refused: no violation\n",
              text(pairs), text(counts.narrow), text(counts.both), text(counts.refused));
  return true;
}
