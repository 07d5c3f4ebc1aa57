// The time to narrow what is decided: as long as the work took so far, at least 0.1 s and at most 1 s.
#pragma once

#include <algorithm>
#include <chrono>

#include "engine/control.h"

namespace meshgauge {

// While it lives, the control's deadline is no later than the end of that time. `begun`: when the work began.
class NarrowingTime {
 public:
  NarrowingTime(Control& control, Control::Clock::time_point begun) : control_(control), deadline_(control.deadline()) {
    using std::chrono::milliseconds;
    const auto now = Control::Clock::now();
    const auto end = now + std::clamp<Control::Clock::duration>(now - begun, milliseconds(100), milliseconds(1000));
    control_.set_deadline(deadline_ ? std::min(*deadline_, end) : end);
  }
  ~NarrowingTime() { control_.set_deadline(deadline_); }
  NarrowingTime(const NarrowingTime&) = delete;
  NarrowingTime& operator=(const NarrowingTime&) = delete;

 private:
  Control& control_;
  const std::optional<Control::Clock::time_point> deadline_;
};

inline constexpr double kNarrowRelative = 0.1;  // of an interval's width to what it bounds, when it is narrow

}  // namespace meshgauge
