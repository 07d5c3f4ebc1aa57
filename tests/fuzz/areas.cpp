// fuzz_areas: certified areas (engine/area.h) of random and adversarial pairs against an independent subdivision.
//
//   fuzz_areas [--pairs N] [--seed S]
//
// Each interval must meet the bracket of tests/oracle/area.h, whenever and for whatever reason the search ends, and two
// threads must give the bits of one, unless shares alone are asked for. Exits with 1 at the first violation, whose pair
// it prints.
#include <algorithm>
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "engine/hausdorff.h"
#include "fuzz/attack.h"
#include "fuzz/dice.h"
#include "fuzz/generate.h"
#include "oracle/area.h"

namespace {

using namespace meshgauge;

constexpr long double kRounding = 1e-9L;  // of the bracket itself, relative to the pair's size; it is far wider

struct Asked {
  Options options;
  std::uint64_t cancel_at = 0;  // 0: never
};

Asked ask(fuzz::Dice& dice, double upper) {
  Asked asked;
  asked.options.direction = Direction::a_to_b;
  asked.options.max_work_items = dice.chance(0.1) ? 3 : 1500;
  AreaOptions areas;
  areas.beyond.push_back({dice.chance(0.1) ? 0 : upper * dice.uniform(0, 1.1), {}});
  if (dice.chance(0.2)) areas.beyond[0].max_share = dice.unit();
  if (dice.chance(0.5)) {
    areas.quantiles.push_back(dice.uniform(0.01, 0.99));
    areas.mean = dice.chance(0.7);
  } else {
    asked.options.thresholds = fuzz::lowered_thresholds(dice);
  }
  areas.share_tolerance = dice.power(-4, -1);
  areas.length_tolerance = dice.power(-3, -1);
  asked.options.areas = areas;
  if (dice.chance(0.1)) asked.cancel_at = 1 + dice.below(400);
  return asked;
}

Outcome run(const fuzz::Pair& pair, const Asked& asked, unsigned threads) {
  Control control;
  if (asked.cancel_at) control.cancel_at_check(asked.cancel_at);
  Options options = asked.options;
  options.threads = threads;
  return measure(pair.a, pair.b, options, control);
}

bool meets(const AreaInterval& found, const oracle::AreaBracket& bracket, long double slack) {
  return found.lower <= found.upper && found.lower <= bracket.high + slack && bracket.low - slack <= found.upper;
}

bool same(const AreaBounds& x, const AreaBounds& y) {
  const auto equal = [](const AreaInterval& a, const AreaInterval& b) {
    return a.lower == b.lower && a.upper == b.upper;
  };
  return equal(x.beyond[0], y.beyond[0]) && equal(x.quantiles[0], y.quantiles[0]) &&
         (!x.mean || (equal(*x.mean, *y.mean) && equal(*x.rms, *y.rms)));
}

// The name of what is violated; empty: nothing.
std::string judge(const fuzz::Pair& pair, const Asked& asked, const AreaBounds& found) {
  const auto limit = static_cast<long double>(asked.options.areas->beyond[0].distance);
  const auto cells = oracle::area_cells(pair.a, pair.b, 3, limit, 6);
  const long double area = oracle::total_area(cells);
  long double size = 0;
  for (const auto& cell : cells) size = std::max(size, cell.high);
  if (!(area > 0) || !std::isfinite(static_cast<double>(area)) ||
      !std::isfinite(static_cast<double>(area * size * size)))
    return "";
  // A limit within the rounding of the bracket may lie on either side.
  oracle::AreaBracket share = oracle::share_beyond(cells, limit - size * kRounding);
  share.low = oracle::share_beyond(cells, limit + size * kRounding).low;
  if (!meets(found.beyond[0], share, kRounding)) return "share";
  if (found.quantiles.empty()) return "";
  const double p = asked.options.areas->quantiles[0];
  oracle::AreaBracket quantile = oracle::quantile(cells, static_cast<long double>(p) - kRounding);
  quantile.high = oracle::quantile(cells, static_cast<long double>(p) + kRounding).high;
  if (!meets(found.quantiles[0], quantile, size * kRounding)) return "quantile";
  if (found.mean && !meets(*found.mean, oracle::mean(cells), size * kRounding)) return "mean";
  if (found.rms && !meets(*found.rms, oracle::rms(cells), size * kRounding)) return "rms";
  return "";
}

void print(const Mesh& mesh, const char* name) {
  std::printf("--- %s\n", name);
  for (const Vec3& p : mesh.positions) std::printf("v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
  for (const Triangle& t : mesh.triangles) std::printf("f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
}

bool attack(std::uint64_t seed, std::uint64_t& complete) {
  const fuzz::Pair pair = fuzz::generate(seed);
  if (pair.a.triangles.size() * pair.b.triangles.size() > 400) return true;  // the bracket would take too long
  fuzz::Dice dice(seed ^ 0x5a5a5a5aU);
  Options plain;
  plain.direction = Direction::a_to_b;
  Control control;
  const Asked asked = ask(dice, measure(pair.a, pair.b, plain, control).upper);
  const AreaBounds found = *run(pair, asked, 1).areas->a_to_b;
  complete += found.stop == AreaStop::complete ? 1 : 0;
  std::string violated = judge(pair, asked, found);
  if (!asked.cancel_at && violated.empty() && dice.chance(0.05)) {
    const AreaBounds again = *run(pair, asked, 2).areas->a_to_b;
    violated = judge(pair, asked, again);
    if (!found.quantiles.empty() && !same(found, again)) violated = "threads";
  }
  if (violated.empty()) return true;
  std::printf("VIOLATION of '%s', seed %llu: %s\n", violated.c_str(), static_cast<unsigned long long>(seed),
              pair.what.c_str());
  std::printf("beyond %.17g: [%.17g, %.17g]\n", asked.options.areas->beyond[0].distance, found.beyond[0].lower,
              found.beyond[0].upper);
  for (const AreaInterval& q : found.quantiles) {
    std::printf("quantile %.17g: [%.17g, %.17g]\n", asked.options.areas->quantiles[0], q.lower, q.upper);
  }
  print(pair.a, "a.obj");
  print(pair.b, "b.obj");
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t pairs = 1000, seed = 1, complete = 0;
  CLI::App app("Attacks certified areas with random and adversarial pairs.");
  app.add_option("--pairs", pairs)->capture_default_str();
  app.add_option("--seed", seed, "pair i is made from seed + i")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (std::uint64_t i = 0; i < pairs; ++i) {
    if (!attack(seed + i, complete)) return 1;
  }
  std::printf("%llu pairs, %llu of them as narrow as asked: no violation\n", static_cast<unsigned long long>(pairs),
              static_cast<unsigned long long>(complete));
}
