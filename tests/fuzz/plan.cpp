#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "fuzz/attack.h"

namespace meshgauge::fuzz {
namespace {

using std::chrono::microseconds;

// Limits the time that one hard pair takes.
constexpr microseconds kPatience{100'000};

// Large stencils are rare: they cost a millisecond for each piece.
int stencil(Dice& dice) {
  const double x = dice.unit();
  return x < 0.4 ? 4 : x < 0.7 ? 10 : x < 0.95 ? 31 : x < 0.99 ? 109 : x < 0.998 ? 409 : 1585;
}

// Most pairs have a small budget of work items, a few a large one.
std::uint64_t work_items(Dice& dice, int points) {
  const std::uint64_t items = dice.chance(0.02) ? 20'000 : dice.chance(0.3) ? 1000 : 250;
  return 1 + items * 4 / static_cast<std::uint64_t>(points);
}

}  // namespace

Thresholds lowered_thresholds(Dice& dice) {
  Thresholds low;
  low.block = 1 + dice.below(16);
  low.adjacency = 1;
  low.patches = 0;
  low.triangles_a_patch = 1;
  low.patch_group = 1 + dice.below(3);
  low.area_sample = low.area_samples = 2;
  return low;
}

Tolerance Plan::tolerance(double diagonal) {
  const double eps = dice_.chance(0.15) ? 0 : dice_.power(-18, 1);
  Tolerance t;
  switch (dice_.below(6)) {
    case 0:
      t.absolute = std::min(eps * diagonal, std::numeric_limits<double>::max());
      break;
    case 1:
      t.diagonal = eps;
      break;
    case 2:
      t.relative = eps;
      break;
    case 3:
      t.diagonal = eps, t.relative = dice_.power(-6, 0);
      break;
    case 4:
      break;  // no rule: as tight as rounding allows
    default:
      t = Options{}.tolerance;
      break;
  }
  return t;
}

Options Plan::options(double diagonal) {
  static constexpr Direction kDirections[] = {Direction::symmetric, Direction::symmetric, Direction::a_to_b,
                                              Direction::b_to_a};
  Options o;
  o.strategy = method_.strategy;
  o.points = o.strategy == Strategy::n_point ? stencil(dice_) : 4;
  o.direction = dice_.pick(kDirections);
  o.tolerance = tolerance(diagonal);
  o.max_work_items = work_items(dice_, o.points);
  o.simd = supported_simd()[dice_.below(static_cast<std::uint32_t>(supported_simd().size()))];
  if (o.strategy == Strategy::automatic && dice_.chance(0.3)) o.threads = dice_.chance(0.5) ? 2 : 4;
  if (o.strategy == Strategy::automatic && dice_.chance(0.5)) o.thresholds = lowered_thresholds(dice_);
  return o;
}

Attempt Plan::plain(const Pair& pair) {
  Attempt attempt;
  attempt.what = "plain";
  attempt.options = options(diagonal(pair.a));
  attempt.deadline = kPatience;
  attempt.watched = dice_.chance(0.1);
  return attempt;
}

// Returns a gate limit at, near or far from the interval of the distance.
double Plan::limit_near(const Outcome& outcome) {
  const double values[] = {outcome.lower, outcome.upper, outcome.lower / 2 + outcome.upper / 2};
  double limit = dice_.pick(values);
  switch (dice_.below(6)) {
    case 0:
      break;
    case 1:
      limit = std::nextafter(limit, 0.0);
      break;
    case 2:
      limit = std::nextafter(limit, std::numeric_limits<double>::infinity());
      break;
    case 3:
      limit *= 1 + dice_.sign() * dice_.power(-16, 0);
      break;
    case 4:
      limit *= dice_.power(-3, 3);
      break;
    default:
      limit = dice_.chance(0.5) ? 0 : 0x1p1023;
      break;
  }
  return std::clamp(limit, 0.0, std::numeric_limits<double>::max());
}

Attempt Plan::disturbed(const Pair& pair, const Attempt& plain, const Observed& seen) {
  Attempt attempt = dice_.chance(0.5) ? plain : this->plain(pair);
  const auto up_to = [&](std::uint64_t n) { return static_cast<std::uint64_t>(dice_.unit() * static_cast<double>(n)); };
  switch (dice_.below(7)) {
    case 0:
    case 1:
      attempt.what = "gate";
      attempt.options.max_distance = limit_near(seen.outcome);
      break;
    case 2:
    case 3:
      attempt.what = "cancelled";
      attempt.cancel_at = 1 + up_to(seen.checks + 1);
      break;
    case 4:
      attempt.what = "deadline";
      attempt.deadline = microseconds(up_to(300));
      break;
    case 5:
      attempt.what = "budget";
      if (dice_.chance(0.5)) attempt.options.max_memory_bytes = up_to(20'000);
      attempt.options.max_work_items = up_to(40);
      break;
    default:
      attempt.what = "twice";
      attempt.twice = true;
      attempt.deadline.reset();  // a clock is not repeatable
      attempt.options.threads = 1;
      break;
  }
  return attempt;
}

std::string command_line(const Attempt& attempt, const std::string& a, const std::string& b) {
  const Options& o = attempt.options;
  std::string line = "meshgauge compare " + a + " " + b + " --direction " +
                     (o.direction == Direction::symmetric ? "symmetric"
                      : o.direction == Direction::a_to_b  ? "a_to_b"
                                                          : "b_to_a");
  for (const Method& method : methods()) {
    if (method.strategy == o.strategy) line += std::string(" --strategy ") + method.name;
  }
  line += " --threads " + std::to_string(o.threads) + " --simd " + std::string(o.simd);
  if (o.strategy == Strategy::n_point) line += " --points " + std::to_string(o.points);
  const auto flag = [&](const char* name, const std::optional<double>& value) {
    char text[64];
    if (value) std::snprintf(text, sizeof text, " --%s %.17g", name, *value), line += text;
  };
  flag("absolute", o.tolerance.absolute);
  flag("diagonal", o.tolerance.diagonal);
  flag("relative", o.tolerance.relative);
  flag("max-distance", o.max_distance);
  line += "\n  further: at most " + std::to_string(o.max_work_items) + " splits, " +
          std::to_string(o.max_memory_bytes) + " bytes";
  if (attempt.cancel_at) line += ", cancelled at check " + std::to_string(*attempt.cancel_at);
  if (attempt.deadline) line += ", deadline after " + std::to_string(attempt.deadline->count()) + " us";
  if (attempt.watched) line += ", watched";
  if (o.thresholds.patches == 0) line += ", lowered thresholds with blocks of " + std::to_string(o.thresholds.block);
  return line;
}

}  // namespace meshgauge::fuzz
