// One attack on the engine: measures a pair of meshes in one way and checks the outcome with the oracle.
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/hausdorff.h"
#include "fuzz/dice.h"
#include "fuzz/generate.h"
#include "oracle/judge.h"

namespace meshgauge::fuzz {

// A strategy to attack. A new strategy is one more line in attack.cpp.
struct Method {
  const char* name;  // the value of `compare --strategy`
  Strategy strategy;
};
std::span<const Method> methods();

// The parameters of one measurement. It is repeatable unless it has a deadline.
struct Attempt {
  const char* what = "";  // the plan that made it
  Options options;
  std::optional<std::chrono::microseconds> deadline;
  std::optional<std::uint64_t> cancel_at;  // the check that reports a cancellation
  bool watched = false;                    // follow every progress report
  bool twice = false;  // run again with another instruction set and expect the same bits; only without a deadline and
                       // on one thread
};

struct Observed {
  Outcome outcome;
  std::uint64_t checks = 0;
  Progress tightest;  // the largest lower and the smallest upper bound of all reports
};

Observed run(const Pair& pair, const Attempt& attempt);

struct Attacked {
  Observed seen;
  std::optional<oracle::Violation> violation;
};

// Measures and checks everything that the judge checks, and also: progress reports are valid ("progress"), equal runs
// give equal bits ("repeat"), there is no exception ("exception").
Attacked attack(const Pair& pair, const Attempt& attempt, oracle::Judge& judge);

// Returns thresholds with which small meshes reach the bounds that are meant for large ones.
Thresholds lowered_thresholds(Dice& dice);

// The attempts for one pair and one method: a plain measurement, and one that is interrupted or has a gate, chosen by
// the result of the first.
class Plan {
 public:
  Plan(const Method& method, Dice& dice) : method_(method), dice_(dice) {}

  Attempt plain(const Pair& pair);
  Attempt disturbed(const Pair& pair, const Attempt& plain, const Observed& seen);

 private:
  Options options(double diagonal);
  Tolerance tolerance(double diagonal);
  double limit_near(const Outcome& outcome);

  const Method& method_;
  Dice& dice_;
};

// Returns `meshgauge compare ...` with the flags of the attempt; parameters that have no flag follow in words.
std::string command_line(const Attempt& attempt, const std::string& a, const std::string& b);

}  // namespace meshgauge::fuzz
