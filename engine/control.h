// How a caller controls a running job: deadline, cancellation, progress.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

namespace meshgauge {

// The certified interval reached so far, of the distance asked for; in the meshes' unit.
struct Progress {
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();  // infinite until the first bound is known
  const char* stage = "";                                  // "build", "traverse", "reduce", "certify", "areas", ...
};

enum class Interruption { none, timeout, cancelled };

// Polled inside long passes. True: stop.
using Interrupted = std::function<bool()>;
inline bool never_interrupted() { return false; }

// One object for each job, and for each part of a job that can be stopped alone. cancel() and cancelled() may be called
// on any thread, check() on the job's threads, everything else only on the thread that runs the job.
class Control {
 public:
  using Clock = std::chrono::steady_clock;

  Control() = default;
  explicit Control(Clock::time_point deadline) : deadline_(deadline) {}
  // Controls a part of `job`, which it borrows: the part stops with the job, and cancel() stops the part alone.
  explicit Control(Control* job) : job_(job) {}
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept {
    return cancelled_.load(std::memory_order_relaxed) || (job_ != nullptr && job_->cancelled());
  }
  void set_deadline(std::optional<Clock::time_point> deadline) { deadline_ = deadline; }
  std::optional<Clock::time_point> deadline() const { return deadline_; }

  // Sets a callback for progress. The engine calls it at most once every `interval`, on the thread that runs the job.
  // It must return quickly and must not throw.
  void watch(std::function<void(const Progress&)> callback, std::chrono::milliseconds interval) {
    callback_ = std::move(callback);
    interval_ = interval;
  }

  // Replaces the callback and returns the one before; null: none. Both are called at the interval of watch().
  std::function<void(const Progress&)> exchange_callback(std::function<void(const Progress&)> callback) {
    return std::exchange(callback_, std::move(callback));
  }

  // For tests: check() returns `cancelled` from its n-th call on.
  void cancel_at_check(std::uint64_t n) { cancel_at_ = n; }
  // The number of calls of check() so far.
  std::uint64_t checks() const { return checks_.load(std::memory_order_relaxed); }

  // Returns the reason to stop, or `none`. The engine calls it at least every 10 ms of work and stops at once on any
  // other value.
  Interruption check() {
    const std::uint64_t count = checks_.fetch_add(1, std::memory_order_relaxed) + 1;
    if (count >= cancel_at_ || cancelled()) return Interruption::cancelled;
    if (deadline_ && Clock::now() >= *deadline_) return Interruption::timeout;
    return job_ != nullptr ? job_->check() : Interruption::none;
  }

  // Whether a callback is set and its interval has passed since the last report.
  bool report_due() const { return callback_ && Clock::now() >= next_report_; }
  // Calls the callback, if there is one, even when no report is due.
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
  Control* const job_ = nullptr;  // null: this is the whole job
};

// Milliseconds of wall time since `start`.
inline double ms_since(Control::Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Control::Clock::now() - start).count();
}

}  // namespace meshgauge
