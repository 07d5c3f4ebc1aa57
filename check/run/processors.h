// The processors of this machine, shared by the gates that run at the same time: a gate that begins gets its part of
// those that are free, so that few gates use all of them and many gates one each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <mutex>

namespace meshgauge::check {

// Thread safe.
class Processors {
 public:
  // `gates` will begin, at most `at_once` at the same time. All at least 1.
  Processors(unsigned processors, unsigned at_once, std::size_t gates)
      : free_(static_cast<int>(processors)), seats_(at_once), waiting_(gates) {}

  // For a gate that begins: how many threads it may use, at least 1. `asked`: that many instead, whatever is free; 0:
  // not asked for.
  unsigned take(unsigned asked) {
    const std::lock_guard lock(mutex_);
    const auto beginning = static_cast<unsigned>(std::max<std::size_t>(1, std::min<std::size_t>(waiting_, seats_)));
    const unsigned granted = asked ? asked : static_cast<unsigned>(std::max(1, free_ / static_cast<int>(beginning)));
    free_ -= static_cast<int>(granted);
    if (waiting_ > 0) --waiting_;
    if (seats_ > 0) --seats_;
    return granted;
  }

  // For work beside the gates, when all seats are taken: no more than a gate's part.
  static unsigned part(unsigned processors, std::size_t seats) {
    return std::max(1U, static_cast<unsigned>(processors / std::max<std::size_t>(seats, 1)));
  }

  void give_back(unsigned granted) {
    const std::lock_guard lock(mutex_);
    free_ += static_cast<int>(granted);
    ++seats_;
  }

 private:
  std::mutex mutex_;  // guards what follows
  int free_;          // below zero when gates have asked for more than there are
  unsigned seats_;
  std::size_t waiting_;
};

}  // namespace meshgauge::check
