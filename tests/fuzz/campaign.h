// Attacks many pairs on several threads, until one fails, the time is over or the pairs are done.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "fuzz/attack.h"

namespace meshgauge::fuzz {

struct Settings {
  double seconds = 0;       // 0: no limit
  std::uint64_t pairs = 0;  // 0: no limit
  std::uint64_t seed = 1;   // pair i depends on seed + i alone
  unsigned threads = 2;
  std::string strategy;     // of methods(); empty: all
  bool keep_going = false;  // count violations, show the first of each kind
};

class Campaign {
 public:
  explicit Campaign(Settings settings) : settings_(std::move(settings)) {}

  // Prints progress and violations to stdout. Returns whether there was no violation.
  bool run();

 private:
  void work();
  void treat(std::uint64_t seed);
  void try_conversion(const Pair& pair, std::uint64_t seed);
  void try_method(const Method& method, const Pair& pair, std::uint64_t seed, Dice& dice, oracle::Judge& judge);
  // Counts of what was covered, printed at the end.
  std::optional<Observed> passes(const Pair& pair, const Attempt& attempt, std::uint64_t seed, oracle::Judge& judge);
  void show(const Pair& pair, const Attempt& attempt, std::uint64_t seed, const oracle::Violation& violation);
  bool is_over() const;
  void print_progress() const;
  void print_summary() const;
  double elapsed() const { return std::chrono::duration<double>(Control::Clock::now() - start_).count(); }

  Settings settings_;
  Control::Clock::time_point start_;
  std::atomic<std::uint64_t> next_{0};
  std::atomic<std::uint64_t> pairs_{0};
  std::atomic<std::uint64_t> outcomes_{0};
  std::atomic<std::uint64_t> converted_{0};            // pairs that were also measured in other units
  std::array<std::atomic<std::uint64_t>, 6> stops_{};  // outcomes by stop reason
  std::atomic<bool> failed_{false};
  std::mutex printing_;
  std::map<std::string, std::uint64_t> violations_;  // by kind; guarded by printing_
};

}  // namespace meshgauge::fuzz
