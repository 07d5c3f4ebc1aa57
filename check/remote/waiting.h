// Intervals of polling.
#pragma once

#include <chrono>
#include <thread>

#include "engine/control.h"

namespace meshgauge::check::service {

// Interval of polling a comparison: the first; then half as much again each time, up to the last.
inline constexpr std::chrono::milliseconds kFirstPoll{250};
inline constexpr std::chrono::milliseconds kLastPoll{1000};
inline constexpr int kAttempts = 3;  // attempts at a comparison or batch that gets lost

inline constexpr std::chrono::milliseconds kCancelPoll{50};

// Returns an Interrupted that is true once `time` has passed from now.
inline Interrupted after(std::chrono::milliseconds time) {
  return [end = Control::Clock::now() + time] { return Control::Clock::now() >= end; };
}

// Sleeps for `time`. False: cancelled.
inline bool pause(std::chrono::milliseconds time, Control& control) {
  constexpr std::chrono::milliseconds kTick{10};
  const Interrupted over = after(time);
  while (control.check() != Interruption::cancelled) {
    if (over()) return true;
    std::this_thread::sleep_for(kTick);
  }
  return false;
}

}  // namespace meshgauge::check::service
