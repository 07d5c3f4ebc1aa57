#include <algorithm>
#include <numeric>
#include <vector>

#include "engine/part.h"
#include "fuzz/attack.h"

namespace meshgauge::fuzz {
namespace {

// The parts of one measurement, one after the other in random order. As soon as it has reported a few times, or from
// its start, each knows the greatest lower bound of those before it.
class Parts {
 public:
  Parts(const Pair& pair, const Attempt& attempt) : pair_(pair), attempt_(attempt), dice_(attempt.order) {
    if (attempt.cancel_at) cancelled_ = static_cast<unsigned>(*attempt.cancel_at % attempt.parts);
  }

  Observed run() {
    std::vector<unsigned> order(attempt_.parts);
    std::iota(order.begin(), order.end(), 0U);
    for (std::size_t i = order.size(); i > 1; --i) {
      std::swap(order[i - 1], order[dice_.below(static_cast<std::uint32_t>(i))]);
    }
    std::vector<Outcome> outcomes(order.size());
    Observed seen;
    for (const unsigned index : order) outcomes[index] = run(index, seen.checks);
    seen.outcome = joined(outcomes, attempt_.options);
    seen.tightest = {seen.outcome.lower, seen.outcome.upper};
    // As the service does it. The interval of the parts must hold nevertheless, and is looked at as one that was told.
    if (relies_on_lost(seen.outcome)) {
      Control control;
      seen.outcome = measure(pair_.a, pair_.b, attempt_.options, control);
    }
    return seen;
  }

 private:
  Outcome run(unsigned index, std::uint64_t& checks) {
    Control control;
    if (attempt_.deadline) control.set_deadline(Control::Clock::now() + *attempt_.deadline);
    if (index == cancelled_) control.cancel_at_check(1 + *attempt_.cancel_at / attempt_.parts);
    std::uint32_t reports = dice_.below(4);
    if (reports == 0) control.know_lower(known_);
    control.watch(
        [&](const Progress& progress) {
          if (reports > 0 && --reports == 0) control.know_lower(known_);
          reported_ = std::max(reported_, progress.lower);
        },
        std::chrono::milliseconds(0));
    Options options = attempt_.options;
    options.part = {index, attempt_.parts};
    Outcome outcome = measure(pair_.a, pair_.b, options, control);
    known_ = std::max({known_, reported_, outcome.lower});
    checks += control.checks();
    return outcome;
  }

  const Pair& pair_;
  const Attempt& attempt_;
  Dice dice_;
  unsigned cancelled_ = ~0U;
  double reported_ = 0;
  double known_ = 0;
};

}  // namespace

Observed run_parts(const Pair& pair, const Attempt& attempt) { return Parts(pair, attempt).run(); }

}  // namespace meshgauge::fuzz
