// Caches the counts of a queue that several processes share: a thread reads them once a second. Thread safe.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>

#include "server/base/each_second.h"
#include "server/measure/stores.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

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

  // Estimates how long a new job would wait, by the number of jobs that end in a second.
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
  double ended_per_second_ = 0;
  std::optional<EachSecond> polling_;  // the last member: it uses the others
};

}  // namespace meshgauge::server
