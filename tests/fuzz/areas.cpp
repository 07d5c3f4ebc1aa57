// fuzz_certify areas: certified areas (engine/area.h) of random and adversarial pairs against an independent
// subdivision.
//
// Each interval must meet the bracket of tests/oracle/area.h, whenever and for whatever reason the search ends, and two
// threads must give the bits of one if they start from the same bound, unless shares alone are asked for, or narrowing,
// which takes as long as it may. Ends at the first violation, whose pair it prints.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "engine/hausdorff.h"
#include "fuzz/asked.h"
#include "fuzz/attack.h"
#include "fuzz/attacks.h"
#include "fuzz/dice.h"
#include "fuzz/generate.h"
#include "oracle/area.h"

namespace {

using namespace meshgauge;

constexpr long double kRounding = 1e-9L;  // of the bracket itself, relative to the pair's size; it is far wider

// Moves each vertex by up to `most` on each axis. Returns an upper bound of the largest movement.
double shake(fuzz::Dice& dice, double most, Mesh& mesh) {
  double moved = 0;
  for (Vec3& p : mesh.positions) {
    const Vec3 q = p + most * Vec3(dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1));
    moved = std::max(moved, (q - p).norm());
    p = q;
  }
  return moved * (1 + 1e-12);
}

double limit_of(fuzz::Dice& dice, double upper, const std::vector<AreaOptions::Beyond>& others) {
  if (dice.chance(0.1)) return 0;
  if (dice.chance(0.1)) return upper * (1 + 1e-15 * dice.uniform(-5, 5));
  if (!others.empty() && dice.chance(0.1)) return others[0].distance;
  return upper * dice.uniform(0, 1.1);
}

fuzz::Asked ask_areas(fuzz::Dice& dice, const fuzz::Pair& pair, double upper) {
  fuzz::Asked asked;
  asked.a = pair.a;
  asked.b = pair.b;
  if (upper > 1e-100 && upper < 1e100 && dice.chance(0.2)) {
    const double most = upper * dice.power(-6, -1);
    asked.error_a = shake(dice, most, asked.a);
    asked.error_b = shake(dice, most, asked.b);
  }
  asked.options.direction = Direction::a_to_b;
  asked.options.max_work_items = dice.chance(0.1) ? dice.below(4) : 1500;
  if (dice.chance(0.03)) asked.options.max_memory_bytes = 1000 * (1 + dice.below(40));
  const auto simd = supported_simd();
  asked.options.simd = simd[dice.below(static_cast<std::uint32_t>(simd.size()))];
  AreaOptions areas;
  for (std::size_t k = 1 + dice.below(3); k > 0; --k) areas.beyond.push_back({limit_of(dice, upper, areas.beyond), {}});
  if (dice.chance(0.2)) areas.beyond[0].max_share = dice.unit();
  if (dice.chance(0.5)) {
    areas.quantiles.push_back(dice.uniform(0.01, 0.99));
    areas.mean = dice.chance(0.7);
    if (dice.chance(0.5)) asked.options.thresholds = fuzz::lowered_thresholds(dice);
  } else {
    asked.options.thresholds = fuzz::lowered_thresholds(dice);
  }
  areas.share_tolerance = dice.power(-4, -1);
  areas.length_tolerance = dice.power(-3, -1);
  asked.options.areas = areas;
  if (dice.chance(0.1)) asked.cancel_at = 1 + dice.below(400);
  if (dice.chance(0.3)) asked.options.tolerance.absolute = upper * dice.unit();
  if (dice.chance(0.3)) asked.options.max_distance = upper * dice.uniform(0.1, 1.5);
  asked.options.narrow = dice.chance(0.3);
  return asked;
}

bool meets(const AreaInterval& found, const oracle::AreaBracket& bracket, long double slack) {
  return found.lower <= found.upper && found.lower <= bracket.high + slack && bracket.low - slack <= found.upper;
}

bool same(const AreaBounds& x, const AreaBounds& y) {
  const auto equal = [](const AreaInterval& a, const AreaInterval& b) {
    return a.lower == b.lower && a.upper == b.upper;
  };
  return std::equal(x.beyond.begin(), x.beyond.end(), y.beyond.begin(), equal) &&
         equal(x.quantiles[0], y.quantiles[0]) && (!x.mean || (equal(*x.mean, *y.mean) && equal(*x.rms, *y.rms)));
}

// The name of what is violated; empty: nothing.
std::string judge(const fuzz::Pair& pair, const fuzz::Asked& asked, const AreaBounds& found) {
  std::vector<oracle::AreaCell> cells;
  long double size = 0;
  for (std::size_t k = 0; k < found.beyond.size(); ++k) {
    const auto limit = static_cast<long double>(asked.options.areas->beyond[k].distance);
    cells = oracle::area_cells(pair.a, pair.b, 3, limit, 6);
    const long double area = oracle::total_area(cells);
    for (const auto& cell : cells) size = std::max(size, cell.high);
    if (!(area > 0) || !std::isfinite(static_cast<double>(area)) ||
        !std::isfinite(static_cast<double>(area * size * size)))
      return "";
    // A limit within the rounding of the bracket may lie on either side.
    oracle::AreaBracket share = oracle::share_beyond(cells, limit - size * kRounding);
    share.low = oracle::share_beyond(cells, limit + size * kRounding).low;
    if (!meets(found.beyond[k], share, kRounding)) return "share";
  }
  if (found.quantiles.empty()) return "";
  const double p = asked.options.areas->quantiles[0];
  oracle::AreaBracket quantile = oracle::quantile(cells, static_cast<long double>(p) - kRounding);
  quantile.high = oracle::quantile(cells, static_cast<long double>(p) + kRounding).high;
  if (!meets(found.quantiles[0], quantile, size * kRounding)) return "quantile";
  if (found.mean && !meets(*found.mean, oracle::mean(cells), size * kRounding)) return "mean";
  if (found.rms && !meets(*found.rms, oracle::rms(cells), size * kRounding)) return "rms";
  return "";
}

bool try_pair(std::uint64_t seed, std::uint64_t& complete) {
  const fuzz::Pair pair = fuzz::generate(seed);
  if (pair.a.triangles.size() * pair.b.triangles.size() > 400) return true;  // the bracket would take too long
  fuzz::Dice dice(seed ^ 0x5a5a5a5aU);
  Options plain;
  plain.direction = Direction::a_to_b;
  Control control;
  const fuzz::Asked asked = ask_areas(dice, pair, measure(pair.a, pair.b, plain, control).upper);
  const Outcome outcome = fuzz::run(asked, 1);
  const AreaBounds& found = *outcome.areas->a_to_b;
  complete += found.stop == AreaStop::complete ? 1 : 0;
  std::string violated = judge(pair, asked, found);
  if (!asked.cancel_at && violated.empty() && dice.chance(0.05)) {
    const Outcome again = fuzz::run(asked, 2);
    violated = judge(pair, asked, *again.areas->a_to_b);
    const bool is_same_start = outcome.a_to_b->bounds.upper == again.a_to_b->bounds.upper && !asked.options.narrow;
    if (is_same_start && !found.quantiles.empty() && !same(found, *again.areas->a_to_b)) violated = "threads";
  }
  if (violated.empty()) return true;
  std::printf("VIOLATION of '%s', seed %llu: %s\n", violated.c_str(), static_cast<unsigned long long>(seed),
              pair.what.c_str());
  for (std::size_t k = 0; k < found.beyond.size(); ++k) {
    std::printf("beyond %.17g: [%.17g, %.17g]\n", asked.options.areas->beyond[k].distance, found.beyond[k].lower,
                found.beyond[k].upper);
  }
  for (const AreaInterval& q : found.quantiles) {
    std::printf("quantile %.17g: [%.17g, %.17g]\n", asked.options.areas->quantiles[0], q.lower, q.upper);
  }
  std::printf("the measured meshes err by %.17g and %.17g\n", asked.error_a, asked.error_b);
  fuzz::print_obj(pair.a, "a.obj");
  fuzz::print_obj(pair.b, "b.obj");
  return false;
}

}  // namespace

bool meshgauge::fuzz::attack_areas(std::uint64_t pairs, std::uint64_t seed) {
  std::uint64_t complete = 0;
  for (std::uint64_t i = 0; i < pairs; ++i) {
    if (!try_pair(seed + i, complete)) return false;
  }
  std::printf("%llu pairs, %llu of them as narrow as asked: no violation\n", static_cast<unsigned long long>(pairs),
              static_cast<unsigned long long>(complete));
  return true;
}
