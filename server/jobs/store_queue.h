// Caches the counts of a queue that several processes share: a thread reads them once a second. Thread safe.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>

#include "server/base/each_second.h"
#include "server/measure/stores.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// Measures how many jobs of a queue end in a second while jobs wait: what its workers can do, not what is asked of
// them.
class EndRate {
 public:
  // Takes two readings of the counts, the second so many seconds after the first. Ignores them if no job waited at one
  // of them, or if a sweep has reduced the number of ended jobs.
  void learn(const store::Counts& before, const store::Counts& now, double seconds);
  // nullopt: no jobs have waited yet.
  std::optional<double> per_second() const { return readings_ > 0 ? std::optional(per_second_) : std::nullopt; }

 private:
  double per_second_ = 0;  // mean of the first readings; then their exponential mean
  std::uint64_t readings_ = 0;
};

class StoreQueue {
 public:
  using Clock = std::chrono::steady_clock;

  // Borrows both. Reads the counts once before it returns.
  StoreQueue(store::JobStore& jobs, StoreErrors& store_errors);

  // Returns the error of the newest read; storage_unavailable when the store takes long to answer.
  Result<Done> available() const;
  Clock::duration silence() const;  // time since its last answer

  store::Counts counts() const;     // of the newest successful read
  std::uint64_t unawaited() const;  // Counts::unawaited, plus those that were added since
  void added();                     // this process has inserted such a job
  double oldest_waiting_seconds() const;

  // Estimates how long a new job would wait, by the number of jobs that wait and the rate at which they end; a minute
  // at most. 0: no job waits, or the rate is not known yet.
  std::chrono::milliseconds expected_wait() const;

 private:
  void poll();
  void learn(const store::Counts& counts, Clock::time_point now);

  store::JobStore& jobs_;
  StoreErrors& store_errors_;
  mutable std::mutex mutex_;  // guards what follows
  store::Counts counts_;
  std::optional<Error> error_;
  Clock::time_point answered_ = Clock::now();
  std::uint64_t added_ = 0;
  EndRate ends_;
  std::optional<EachSecond> polling_;  // the last member: it uses the others
};

}  // namespace meshgauge::server
