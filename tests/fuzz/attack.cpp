#include "fuzz/attack.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <exception>
#include <limits>

namespace meshgauge::fuzz {
namespace {

using oracle::Violation;

constexpr Method kMethods[] = {{"auto", Strategy::automatic},
                               {"four_point", Strategy::four_point},
                               {"n_point", Strategy::n_point},
                               {"triangle_set", Strategy::triangle_set}};

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

bool same(const Bounds& a, const Bounds& b) {
  if (a.lower != b.lower || a.upper != b.upper || a.witness.has_value() != b.witness.has_value()) return false;
  if (!a.witness) return true;
  const Witness &v = *a.witness, &w = *b.witness;
  return v.point_a == w.point_a && v.point_b == w.point_b && v.triangle_a == w.triangle_a &&
         v.triangle_b == w.triangle_b;
}

bool same(const std::optional<Directed>& a, const std::optional<Directed>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (same(a->bounds, b->bounds) && a->work.subdivisions == b->work.subdivisions &&
                a->culling.survivors == b->culling.survivors);
}

bool same(const Outcome& a, const Outcome& b) {
  return a.stop == b.stop && a.met_by == b.met_by && a.lower == b.lower && a.upper == b.upper &&
         a.precision_floor == b.precision_floor && same(a.a_to_b, b.a_to_b) && same(a.b_to_a, b.b_to_a);
}

oracle::Circumstances circumstances_of(const Attempt& attempt) {
  const Options unlimited;
  return {attempt.deadline.has_value(), attempt.cancel_at.has_value(),
          attempt.options.max_work_items != unlimited.max_work_items ||
              attempt.options.max_memory_bytes != unlimited.max_memory_bytes};
}

std::optional<Violation> judge_progress(const Attempt& attempt, const Observed& seen, oracle::Judge& judge) {
  const Progress& tightest = seen.tightest;
  if (tightest.lower > seen.outcome.upper) {
    return Violation{"progress",
                     format("lower %.17g was reported, the end says upper %.17g", tightest.lower, seen.outcome.upper)};
  }
  if (std::isinf(tightest.upper)) return std::nullopt;
  const oracle::Ratio largest_sq = judge.largest_seen_sq(attempt.options.direction);
  if (oracle::root_at_most(largest_sq, tightest.upper)) return std::nullopt;
  return Violation{"progress", format("upper %.17g was reported, a sample is at %.17g", tightest.upper,
                                      largest_sq.approximate_root())};
}

std::optional<Violation> judge_repetition(const Pair& pair, const Attempt& attempt, const Observed& seen) {
  Attempt other = attempt;
  other.options.simd =
      attempt.options.simd == supported_simd().front() ? supported_simd().back() : supported_simd().front();
  const Observed again = run(pair, other);
  if (same(seen.outcome, again.outcome)) return std::nullopt;
  return Violation{"repeat", format("[%.17g, %.17g], then [%.17g, %.17g]", seen.outcome.lower, seen.outcome.upper,
                                    again.outcome.lower, again.outcome.upper)};
}

}  // namespace

std::span<const Method> methods() { return kMethods; }

Observed run(const Pair& pair, const Attempt& attempt) {
  Control control;
  if (attempt.deadline) control.set_deadline(Control::Clock::now() + *attempt.deadline);
  if (attempt.cancel_at) control.cancel_at_check(*attempt.cancel_at);
  Observed seen;
  if (attempt.watched) {
    control.watch(
        [&](const Progress& progress) {
          seen.tightest.lower = std::max(seen.tightest.lower, progress.lower);
          seen.tightest.upper = std::min(seen.tightest.upper, progress.upper);
        },
        std::chrono::milliseconds(0));
  }
  seen.outcome = measure(pair.a, pair.b, attempt.options, control);
  seen.checks = control.checks();
  return seen;
}

Attacked attack(const Pair& pair, const Attempt& attempt, oracle::Judge& judge) try {
  Attacked attacked{run(pair, attempt), std::nullopt};
  const Observed& seen = attacked.seen;
  attacked.violation = judge.judge(attempt.options, seen.outcome, circumstances_of(attempt));
  if (!attacked.violation) attacked.violation = judge_progress(attempt, seen, judge);
  if (!attacked.violation && attempt.twice) attacked.violation = judge_repetition(pair, attempt, seen);
  return attacked;
} catch (const std::exception& e) {
  return {{}, Violation{"exception", e.what()}};
}

}  // namespace meshgauge::fuzz
