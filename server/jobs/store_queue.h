// How it stands with the queue of a store that many processes work on: asked once a second, for all who want to know at
// once. Thread safe.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "server/jobs/store_errors.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

class StoreQueue {
 public:
  using Clock = std::chrono::steady_clock;

  // Borrows both, and asks for the first time before it returns.
  StoreQueue(store::JobStore& jobs, StoreErrors& store_errors);
  ~StoreQueue();
  StoreQueue(const StoreQueue&) = delete;
  StoreQueue& operator=(const StoreQueue&) = delete;

  // The error of the newest look, or storage_unavailable when the store takes long to answer.
  Result<Done> available() const;
  Clock::duration silence() const;  // since it answered last

  store::Counts counts() const;     // as of the newest look that was answered
  std::uint64_t unawaited() const;  // Counts::unawaited, with those that were added since
  void added();                     // one of them, by this process
  double oldest_waiting_seconds() const;

  // How long a job that came now would wait, by how many end in a second.
  std::chrono::milliseconds expected_wait() const;

 private:
  void poll();
  void keep_looking();
  void learn(const store::Counts& counts, Clock::time_point now);

  store::JobStore& jobs_;
  StoreErrors& store_errors_;
  mutable std::mutex mutex_;  // guards what follows
  store::Counts counts_;
  std::optional<Error> error_;
  Clock::time_point answered_ = Clock::now();
  std::uint64_t added_ = 0;
  double ended_per_second_ = 0;
  std::condition_variable wake_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace meshgauge::server
