// How long what is asked for is waited for, and how it is let go.
#pragma once

#include <chrono>
#include <thread>

#include "engine/control.h"

namespace meshgauge::check::service {

// Between two looks at how something stands: the first, of one comparison, then half as much again each time.
inline constexpr std::chrono::milliseconds kFirstLook{250};
inline constexpr std::chrono::milliseconds kLastLook{1000};
inline constexpr int kAttempts = 3;  // in all, of what got lost

// For the service to be told of a cancellation, and to answer.
inline constexpr std::chrono::milliseconds kFarewell{2000};
inline constexpr std::chrono::milliseconds kFarewellLook{50};

// From now on, over after that time.
inline Interrupted after(std::chrono::milliseconds time) {
  return [end = Control::Clock::now() + time] { return Control::Clock::now() >= end; };
}

// False: cancelled.
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
