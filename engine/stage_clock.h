// How long the stages of a measurement take.
#pragma once

#include <chrono>

namespace meshgauge {

// Adds the time of its scope to a stage.
class StageClock {
  using Clock = std::chrono::steady_clock;

 public:
  explicit StageClock(double& total_ms) : total_ms_(total_ms) {}
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  ~StageClock() { total_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }

 private:
  double& total_ms_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace meshgauge
