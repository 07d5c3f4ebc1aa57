// How many may wait in a queue. A burst may fill it; but a queue that has not been empty for a while hides a surplus,
// and all that its length does is that everybody waits longer, also for being refused. Then a part of it has to do.
// (The idea is that of Nichols and Jacobson, "Controlling Queue Delay", ACM Queue 2012.)
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace meshgauge::server {

// One thread at a time.
class QueueLimit {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kBurst{100};
  static constexpr std::size_t kPart = 8;

  explicit QueueLimit(std::size_t most) : most_(most) {}

  // When one more comes and finds `waiting`: how many may wait.
  std::size_t limit(std::size_t waiting, Clock::time_point now) {
    if (waiting == 0) empty_ = now;
    return now - empty_ <= kBurst ? most_ : std::min(most_, most_ / kPart + 1);
  }

 private:
  const std::size_t most_;
  Clock::time_point empty_{};  // when it last was
};

}  // namespace meshgauge::server
