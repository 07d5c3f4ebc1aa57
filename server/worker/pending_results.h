// The ends of a worker's jobs that are to be stored.
//
// One thread stores them in groups: the first at once, and those that arrive meanwhile together. So small jobs share
// the time of one commit, and a single job waits for no other. What the store does not take waits here and is tried
// again; an end that may have been stored already is stored again, which changes nothing.
//
// Thread safe.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/base/threads.h"
#include "server/store/job_store.h"
#include "server/worker/claim_buffer.h"

namespace meshgauge::server {

struct PendingResult {
  HeldJobPtr job;
  std::optional<store::Ending> ending;      // nullopt: the job is handed back
  std::optional<store::Progress> progress;  // stored with a hand-back
  std::string blame;                        // `last_error` of JobStore::hand_back()
};

class PendingResults {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Outcome {
    stored,
    refused,  // the token is no longer the newest
  };

  // Receives the outcomes. Called on the delivering thread; no call may wait for results.
  class Listener {
   public:
    virtual ~Listener() = default;
    // Called once for each result, when the store has answered; again later if it throws std::bad_alloc.
    virtual void delivered(const PendingResult& delivery, Outcome outcome) = 0;
    // Called with each error of the store. The results that it concerns stay here and are tried again, or their jobs
    // are handed back.
    virtual void failed(const Error& error) = 0;
  };

  struct Settings {
    std::chrono::seconds keep{86'400};  // for how long a job that the store ends is kept
    std::chrono::milliseconds first_pause{100};
    std::chrono::milliseconds longest_pause{2'000};
  };

  static constexpr std::size_t kGroup = 256;
  static constexpr std::uint64_t kGroupBytes = std::uint64_t{8} << 20;
  static constexpr std::size_t kFull = 4096;
  static constexpr std::uint64_t kFullBytes = std::uint64_t{128} << 20;

  // Borrows the store and the listener.
  PendingResults(store::JobStore& jobs, Settings settings, Listener& listener);
  ~PendingResults() = default;  // drops what waits
  PendingResults(const PendingResults&) = delete;
  PendingResults& operator=(const PendingResults&) = delete;

  void add(PendingResult delivery);  // also when full()
  void hurry();                      // tries again now: the store may be back
  std::size_t waiting() const;
  bool full() const;  // the worker should claim no more
  bool wait_until_empty(Clock::time_point until) const;

 private:
  using Group = std::vector<PendingResult>;

  void deliver_in_background();
  void tell_end();
  Group next_group();
  bool deliver(Group& group);
  std::optional<Error> store_endings(Group& group);
  std::optional<Error> give_back(const PendingResult& delivery);
  std::optional<Error> one_by_one(Group& group);
  void settle(const PendingResult& delivery, Outcome outcome);

  store::JobStore& jobs_;
  const Settings settings_;
  Listener& listener_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  mutable std::condition_variable emptied_;
  std::deque<PendingResult> waiting_;
  std::size_t unsettled_ = 0;  // waiting or being stored
  std::uint64_t unsettled_bytes_ = 0;
  bool hurry_ = false;
  bool ending_ = false;
  Threads threads_;
};

}  // namespace meshgauge::server
