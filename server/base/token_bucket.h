// A token bucket: allows a burst of something at once, and a rate of it in the long run.
#pragma once

#include <algorithm>
#include <chrono>

namespace meshgauge::server {

// Not thread safe. The caller gives the time.
class TokenBucket {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Seconds = std::chrono::duration<double>;

  // Starts full. Preconditions: `per_second` is above 0, `burst` at least 1.
  TokenBucket(double per_second, double burst, Time now)
      : per_second_(per_second), burst_(burst), level_(burst), at_(now) {}

  // False: there is no token.
  bool take(Time now) {
    flow(now);
    if (level_ < 1) return false;
    level_ -= 1;
    return true;
  }

  void give_back() { level_ += 1; }  // the token of a take(), which was not used

  // Time until take() would succeed. Precondition: the last take() returned false.
  Seconds wait() const { return Seconds((1 - level_) / per_second_); }

  double level() const { return level_; }  // tokens after the last take()

  bool is_full(Time now) const { return level_at(now) >= burst_; }

  // Changes rate and capacity; tokens that were used stay used.
  void change(double per_second, double burst, Time now) {
    flow(now);
    per_second_ = per_second;
    burst_ = burst;
    level_ = std::min(level_, burst_);
  }

 private:
  double level_at(Time now) const { return std::min(burst_, level_ + per_second_ * Seconds(now - at_).count()); }

  void flow(Time now) {
    level_ = level_at(now);
    at_ = now;
  }

  double per_second_;
  double burst_;
  double level_;
  Time at_;  // of the level
};

}  // namespace meshgauge::server
