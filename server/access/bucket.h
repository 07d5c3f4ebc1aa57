// A token bucket: allows `burst` requests at once, and `per_minute` in the long run.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace meshgauge::server {

// Not thread safe.
class Bucket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Starts full. Precondition: both numbers are at least 1.
  Bucket(std::uint64_t per_minute, std::uint64_t burst, Time now)
      : per_second_(static_cast<double>(per_minute) / 60),
        burst_(static_cast<double>(burst)),
        level_(burst_),
        at_(now) {}

  bool take(Time now) {
    flow(now);
    if (level_ < 1) return false;
    level_ -= 1;
    return true;
  }

  // Time until take() would succeed. Precondition: the last take() returned false.
  std::chrono::duration<double> wait() const { return std::chrono::duration<double>((1 - level_) / per_second_); }

  // Changes rate and capacity; tokens that were used stay used.
  void change(std::uint64_t per_minute, std::uint64_t burst, Time now) {
    flow(now);
    per_second_ = static_cast<double>(per_minute) / 60;
    burst_ = static_cast<double>(burst);
    level_ = std::min(level_, burst_);
  }

 private:
  void flow(Time now) {
    level_ = std::min(burst_, level_ + per_second_ * std::chrono::duration<double>(now - at_).count());
    at_ = now;
  }

  double per_second_;
  double burst_;
  double level_;
  Time at_;
};

}  // namespace meshgauge::server
