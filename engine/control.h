// What a caller may do to a running job: give it a deadline, cancel it, watch it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

namespace meshgauge {

// The interval as it stands, of the direction asked for; valid at every moment.
struct Progress {
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();  // infinite until the first bound is known
  const char* stage = "";                                  // "build", "traverse", "reduce", "certify", "statistics"
};

enum class Interruption { none, timeout, cancelled };

// Asked in the middle of long passes: whether to give up.
using Interrupted = std::function<bool()>;
inline bool never_interrupted() { return false; }

// One per job. cancel() may be called from any thread, check() from the job's own threads; everything else belongs to
// the thread that runs the job.
class Control {
 public:
  using Clock = std::chrono::steady_clock;

  Control() = default;
  explicit Control(Clock::time_point deadline) : deadline_(deadline) {}
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  void set_deadline(Clock::time_point deadline) { deadline_ = deadline; }
  std::optional<Clock::time_point> deadline() const { return deadline_; }

  // Called by the engine at most every `interval`, on the job's thread; must be quick and must not throw.
  void watch(std::function<void(const Progress&)> callback, std::chrono::milliseconds interval) {
    callback_ = std::move(callback);
    interval_ = interval;
  }

  // For tests: the n-th check from now reports a cancellation.
  void cancel_at_check(std::uint64_t n) { cancel_at_ = n; }
  std::uint64_t checks() const { return checks_.load(std::memory_order_relaxed); }

  // The engine asks this at least every 10 ms of work, and ends at once on anything but `none`.
  Interruption check() {
    const std::uint64_t count = checks_.fetch_add(1, std::memory_order_relaxed) + 1;
    if (count >= cancel_at_ || cancelled_.load(std::memory_order_relaxed)) return Interruption::cancelled;
    if (deadline_ && Clock::now() >= *deadline_) return Interruption::timeout;
    return Interruption::none;
  }

  // Whether anybody is watching and enough time has passed; report() then tells.
  bool report_due() const { return callback_ && Clock::now() >= next_report_; }
  void report(const Progress& progress) {
    if (!callback_) return;
    next_report_ = Clock::now() + interval_;
    callback_(progress);
  }

 private:
  std::optional<Clock::time_point> deadline_;
  std::atomic<bool> cancelled_{false};
  std::atomic<std::uint64_t> checks_{0};
  std::uint64_t cancel_at_ = std::numeric_limits<std::uint64_t>::max();
  std::function<void(const Progress&)> callback_;
  std::chrono::milliseconds interval_{100};
  Clock::time_point next_report_{};
};

// Milliseconds of wall time.
inline double ms_since(Control::Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Control::Clock::now() - start).count();
}

}  // namespace meshgauge
