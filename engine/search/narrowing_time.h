// The time to narrow what is decided: half a second.
#pragma once

#include <algorithm>
#include <chrono>

#include "engine/control.h"

namespace meshgauge {

// While it lives, the control's deadline is no later than the end of that time.
class NarrowingTime {
 public:
  explicit NarrowingTime(Control& control) : control_(control), deadline_(control.deadline()) {
    const auto end = Control::Clock::now() + std::chrono::milliseconds(500);
    control_.set_deadline(deadline_ ? std::min(*deadline_, end) : end);
  }
  ~NarrowingTime() { control_.set_deadline(deadline_); }
  NarrowingTime(const NarrowingTime&) = delete;
  NarrowingTime& operator=(const NarrowingTime&) = delete;

 private:
  Control& control_;
  const std::optional<Control::Clock::time_point> deadline_;
};

// An interval is narrow when its width is at most this part of what it bounds, or of the limit.
inline constexpr double kNarrowRelative = 0.01, kNarrowOfLimit = 1e-4;

}  // namespace meshgauge
