#include "fuzz/campaign.h"

#include <cstdio>
#include <thread>
#include <vector>

#include "fuzz/conversion.h"
#include "fuzz/shrink.h"

namespace meshgauge::fuzz {
namespace {

constexpr auto kShrinkPatience = std::chrono::seconds(20);

// Whether the pair is small enough for an exact bracket, which measures every corner to every triangle.
bool is_small(const Pair& pair) { return pair.a.triangles.size() * pair.b.triangles.size() <= 300; }

// The oracle's effort: small for most pairs, large for some, with a bracket in exact arithmetic for a few.
oracle::Effort effort_for(const Pair& pair, Dice& dice) {
  const double x = dice.unit();
  return {x < 0.05 ? std::size_t{4000} : std::size_t{250},
          x < 0.02 && is_small(pair) ? std::size_t{40} : std::size_t{0}};
}

}  // namespace

bool Campaign::run() {
  start_ = Control::Clock::now();
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < settings_.threads; ++i) threads.emplace_back([this] { work(); });
  auto next_report = start_ + std::chrono::seconds(10);
  while (!is_over()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (Control::Clock::now() < next_report) continue;
    print_progress();
    next_report += std::chrono::seconds(10);
  }
  for (std::thread& thread : threads) thread.join();
  print_summary();
  return !failed_;
}

bool Campaign::is_over() const {
  if (failed_ && !settings_.keep_going) return true;
  if (settings_.pairs > 0 && next_ >= settings_.pairs) return true;
  return settings_.seconds > 0 && elapsed() >= settings_.seconds;
}

void Campaign::work() {
  while (!is_over()) {
    const std::uint64_t i = next_++;
    if (settings_.pairs > 0 && i >= settings_.pairs) return;
    treat(settings_.seed + i);
    ++pairs_;
  }
}

void Campaign::treat(std::uint64_t seed) {
  const Pair pair = generate(seed);
  Dice dice(~seed);
  oracle::Judge judge(pair.a, pair.b, effort_for(pair, dice));
  try_conversion(pair, seed);
  for (const Method& method : methods()) {
    Dice own(dice.bits());  // so that leaving out a method does not change the others
    if (!settings_.strategy.empty() && settings_.strategy != method.name) continue;
    try_method(method, pair, seed, own, judge);
  }
}

// For every fourth pair, with its own random numbers, so that the other attempts do not change.
void Campaign::try_conversion(const Pair& pair, std::uint64_t seed) {
  constexpr std::uint64_t kEvery = 4, kOwn = 0x5CA1ED;
  if (seed % kEvery != 0) return;
  Dice dice(seed ^ kOwn);
  ++outcomes_;
  ++converted_;
  Options options = Plan(methods()[dice.below(static_cast<std::uint32_t>(methods().size()))], dice).plain(pair).options;
  const oracle::Effort effort{250, is_small(pair) && dice.chance(0.25) ? std::size_t{40} : std::size_t{0}};
  const auto violation = attack_converted(pair, options, effort, dice);
  if (!violation) return;
  failed_ = true;
  const std::lock_guard lock(printing_);
  if (violations_[violation->check]++ > 0) return;
  std::printf("\nVIOLATION of '%s', pair %llu: %s\n  %s\n  again: fuzz_certify --pairs 1 --seed %llu\n\n",
              violation->check.c_str(), static_cast<unsigned long long>(seed), pair.what.c_str(),
              violation->detail.c_str(), static_cast<unsigned long long>(seed));
  std::fflush(stdout);
}

void Campaign::try_method(const Method& method, const Pair& pair, std::uint64_t seed, Dice& dice,
                          oracle::Judge& judge) {
  Plan plan(method, dice);
  const Attempt plain = plan.plain(pair);
  const auto seen = passes(pair, plain, seed, judge);
  if (!seen) return;
  ++stops_[static_cast<std::size_t>(seen->outcome.stop)];
  passes(pair, plan.disturbed(pair, plain, *seen), seed, judge);
}

std::optional<Observed> Campaign::passes(const Pair& pair, const Attempt& attempt, std::uint64_t seed,
                                         oracle::Judge& judge) {
  ++outcomes_;
  Attacked attacked = attack(pair, attempt, judge);
  if (!attacked.violation) return std::move(attacked.seen);
  failed_ = true;
  show(pair, attempt, seed, *attacked.violation);
  return std::nullopt;
}

void Campaign::show(const Pair& pair, const Attempt& attempt, std::uint64_t seed, const oracle::Violation& violation) {
  const std::lock_guard lock(printing_);
  const std::string kind = violation.check + " (" + attempt.what + ")";
  if (violations_[kind]++ > 0) return;
  std::printf("\nVIOLATION of '%s', pair %llu: %s\n  %s\n", violation.check.c_str(),
              static_cast<unsigned long long>(seed), pair.what.c_str(), violation.detail.c_str());
  std::fflush(stdout);
  std::string detail = violation.detail;
  const auto fails = [&](const Pair& smaller) {
    oracle::Judge judge(smaller.a, smaller.b, {1000, is_small(smaller) ? std::size_t{20} : std::size_t{0}});
    const auto found = attack(smaller, attempt, judge).violation;
    if (!found || found->check != violation.check) return false;
    detail = found->detail;
    return true;
  };
  const Pair small = fails(pair) ? shrink(pair, fails, kShrinkPatience) : pair;
  if (fails(small)) std::printf("shrunk: %s\n", detail.c_str());
  std::printf("--- a.obj\n%s--- b.obj\n%s---\n", to_obj(small.a).c_str(), to_obj(small.b).c_str());
  std::printf("  %s\n  again: fuzz_certify --pairs 1 --seed %llu\n\n", command_line(attempt, "a.obj", "b.obj").c_str(),
              static_cast<unsigned long long>(seed));
  std::fflush(stdout);
}

void Campaign::print_progress() const {
  const double s = elapsed();
  std::printf("%6.0f s  %llu pairs  %llu outcomes  %.0f pairs/s\n", s, static_cast<unsigned long long>(pairs_.load()),
              static_cast<unsigned long long>(outcomes_.load()), static_cast<double>(pairs_.load()) / s);
  std::fflush(stdout);
}

void Campaign::print_summary() const {
  print_progress();
  static constexpr const char* kStops[] = {"converged", "gate", "timeout", "cancelled", "budget", "precision floor"};
  std::printf("%llu pairs in other units as well\n", static_cast<unsigned long long>(converted_.load()));
  std::printf("plain measurements ended by:");
  for (std::size_t i = 0; i < stops_.size(); ++i) {
    if (stops_[i] > 0) std::printf("  %s %llu", kStops[i], static_cast<unsigned long long>(stops_[i].load()));
  }
  std::printf("\n");
  for (const auto& [kind, count] : violations_) {
    std::printf("%llu violations of %s\n", static_cast<unsigned long long>(count), kind.c_str());
  }
  if (violations_.empty()) std::printf("no violation\n");
}

}  // namespace meshgauge::fuzz
