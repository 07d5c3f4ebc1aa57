// How long the stages of a measurement take.
#pragma once

#include "engine/control.h"

namespace meshgauge {

// Adds the time of its scope to a stage.
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
