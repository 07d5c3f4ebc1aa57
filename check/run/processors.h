// Shares the processors of this machine among the gates that run at the same time: few gates get several threads
// each, many gates one each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <mutex>

namespace meshgauge::check {

// Thread safe.
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

}  // namespace meshgauge::check
