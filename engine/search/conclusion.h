// What an interval means for what was asked: which rule holds, whether the gate is decided, why the work ended; and how
// far an interval is narrowed once its gate is decided.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "engine/control.h"
#include "engine/options.h"
#include "engine/outcome.h"

namespace meshgauge {

// Returns the first rule of options.tolerance that the interval [lower, upper] meets; nullopt: none. All in the meshes'
// unit.
std::optional<Rule> rule_met(const Options& options, double lower, double upper, double diagonal_a);

// Whether upper <= max_distance or lower > max_distance. False without a gate.
bool gate_decided(const std::optional<double>& max_distance, double lower, double upper);

// Sets Outcome::lower and upper to the maximum over the directions that were asked for.
void take_maximum(Outcome& outcome);

// Precondition: the job was interrupted.
inline Stop to_stop(Interruption interruption) {
  return interruption == Interruption::timeout ? Stop::timeout : Stop::cancelled;
}

// While it lives, the control's deadline is at most `end`.
class EarlierDeadline {
 public:
  EarlierDeadline(Control& control, Control::Clock::time_point end) : control_(control), deadline_(control.deadline()) {
    control_.set_deadline(deadline_ ? std::min(*deadline_, end) : end);
  }
  ~EarlierDeadline() { control_.set_deadline(deadline_); }
  EarlierDeadline(const EarlierDeadline&) = delete;
  EarlierDeadline& operator=(const EarlierDeadline&) = delete;

 private:
  Control& control_;
  const std::optional<Control::Clock::time_point> deadline_;
};

// The time to narrow what is decided.
class NarrowingTime : public EarlierDeadline {
 public:
  explicit NarrowingTime(Control& control)
      : EarlierDeadline(control, Control::Clock::now() + std::chrono::milliseconds(500)) {}
};

// An interval is narrow when its width is at most this part of what it bounds, or of the limit.
inline constexpr double kNarrowRelative = 0.01, kNarrowOfLimit = 1e-4;

}  // namespace meshgauge
