// Wall time of the stages of a measurement.
#pragma once

#include "engine/control.h"

namespace meshgauge {

// Adds its lifetime in milliseconds to `total_ms`.
class StageClock {
 public:
  explicit StageClock(double& total_ms) : total_ms_(total_ms) {}
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  ~StageClock() { total_ms_ += ms_since(start_); }

 private:
  double& total_ms_;
  Control::Clock::time_point start_ = Control::Clock::now();
};

}  // namespace meshgauge
