// One attack on the engine: a pair of meshes measured in one way, and the oracle's judgement.
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

// What is attacked. A new strategy is one more line in attack.cpp.
struct Method {
  const char* name;  // as `compare --strategy` takes it
  Strategy strategy;
};
std::span<const Method> methods();

// How one measurement is made. Everything but a deadline makes it repeatable.
struct Attempt {
  const char* what = "";  // which plan made it
  Options options;
  std::optional<std::chrono::microseconds> deadline;
  std::optional<std::uint64_t> cancel_at;  // the check that reports a cancellation
  bool watched = false;                    // follow every progress report
  bool twice = false;  // a second run, with another instruction set, must give the same bits; without a deadline, on
                       // one thread
};

struct Observed {
  Outcome outcome;
  std::uint64_t checks = 0;
  Progress tightest;  // the largest lower and the least upper bound reported on the way
};

Observed run(const Pair& pair, const Attempt& attempt);

struct Attacked {
  Observed seen;
  std::optional<oracle::Violation> violation;
};

// Everything that the judge checks, and: progress reports are valid ("progress"), equal runs give equal bits
// ("repeat"), no exception ("exception").
Attacked attack(const Pair& pair, const Attempt& attempt, oracle::Judge& judge);

// The attempts at one pair for one method: a measurement, and one that is disturbed or decided in a way that depends on
// how the first one went.
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

// `meshgauge compare ...` as far as its flags can say it, and the rest in words.
std::string command_line(const Attempt& attempt, const std::string& a, const std::string& b);

}  // namespace meshgauge::fuzz
