// Measures gates in this process, which share its processors.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "check/gate.h"
#include "check/measurer.h"
#include "check/run/meshes.h"

namespace meshgauge::check {

// Shares the processors of this machine among the gates that run at the same time: few gates get several threads each,
// many gates one each. Thread safe.
class Processors {
 public:
  // `gates` gates will begin, at most `at_once` at the same time. All arguments are at least 1.
  Processors(unsigned processors, unsigned at_once, std::size_t gates)
      : free_(static_cast<int>(processors)), seats_(at_once), waiting_(gates) {}

  // Returns the number of threads for a gate that begins, at least 1. `asked`: this number instead, however many are
  // free; 0: not asked for.
  unsigned take(unsigned asked) {
    const std::lock_guard lock(mutex_);
    const auto beginning = static_cast<unsigned>(std::max<std::size_t>(1, std::min<std::size_t>(waiting_, seats_)));
    const unsigned granted = asked ? asked : static_cast<unsigned>(std::max(1, free_ / static_cast<int>(beginning)));
    free_ -= static_cast<int>(granted);
    if (waiting_ > 0) --waiting_;
    if (seats_ > 0) --seats_;
    return granted;
  }

  // Returns the number of threads for work beside the gates when all places are taken: a gate's part.
  static unsigned part(unsigned processors, std::size_t seats) {
    return std::max(1U, static_cast<unsigned>(processors / std::max<std::size_t>(seats, 1)));
  }

  void give_back(unsigned granted) {
    const std::lock_guard lock(mutex_);
    free_ += static_cast<int>(granted);
    ++seats_;
  }

 private:
  std::mutex mutex_;  // guards the members below
  int free_;          // negative if gates have asked for more than there are
  unsigned seats_;
  std::size_t waiting_;
};

struct LocalOptions {
  unsigned processors = 1;  // shared by the gates
  unsigned jobs = 0;        // gates at the same time; 0: one for each processor
};

// `gates`: all that will be measured, each once. `meshes` must have a turn for each gate; the measurer calls done()
// after it.
std::unique_ptr<Measurer> local(const std::vector<Gate>& gates, std::shared_ptr<Meshes> meshes,
                                const LocalOptions& options);

}  // namespace meshgauge::check
