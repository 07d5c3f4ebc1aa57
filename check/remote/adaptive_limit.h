// Limits how many comparisons are at the service at the same time, and adapts to what it accepts.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "engine/control.h"

namespace meshgauge::check::service {

// Thread safe. Starts at the maximum. Each refusal lowers the limit to one less than the comparisons under way, at
// least to 1; as many comparisons without a refusal as the limit raise it by one. Waiting in take() sends no
// requests.
class AdaptiveLimit {
 public:
  explicit AdaptiveLimit(unsigned most) : most_(std::max(1U, most)), limit_(most_) {}

  unsigned most() const { return most_; }

  // Waits for a place. False: cancelled, and no place is taken.
  bool take(Control& control) {
    std::unique_lock lock(mutex_);
    while (taken_ >= limit_) {
      if (control.check() == Interruption::cancelled) return false;
      changed_.wait_for(lock, kTick);
    }
    ++taken_;
    return true;
  }

  void give_back() {
    const std::lock_guard lock(mutex_);
    --taken_;
    if (++served_ >= limit_ && limit_ < most_) {
      ++limit_;
      served_ = 0;
    }
    changed_.notify_all();
  }

  void refused() {
    const std::lock_guard lock(mutex_);
    limit_ = std::max(1U, std::min(limit_, taken_ - 1));
    served_ = 0;
  }

 private:
  static constexpr std::chrono::milliseconds kTick{10};

  const unsigned most_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  unsigned limit_;
  unsigned taken_ = 0;
  unsigned served_ = 0;  // since the limit last changed
};

}  // namespace meshgauge::check::service
