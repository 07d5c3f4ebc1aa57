// The jobs that a worker has claimed and not begun: their order, and how many more to claim.
//
// Order: jobs of no batch first, since a client may wait for each; then those of batches; each in the order of their
// claims. Those whose blobs are not opened yet are passed over; but a small job of a batch is waited for kSoon, unless
// they could not be opened at first, since the one behind it may keep the thread for minutes. A suspected job begins
// when nothing runs, and nothing begins beside it: if it ends its worker, no other job is lost. Jobs that were claimed
// before it begin before it, and nothing is claimed until it has ended.
//
// No other worker can run a buffered job. So only small jobs of batches are buffered beyond the free threads, whose
// runs may be shorter than a claim, and no more than take about a second.
//
// A guest, whose owner had no job running, begins also while all threads are busy: the scheduler has threads for them.
//
// Not thread safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "server/measure/live_job.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// A job that this worker has claimed, until the store has its end or has it back. Guarded by its worker's mutex, except
// `live` (live_job.h).
struct HeldJob {
  using Clock = LiveJob::Clock;
  enum class Stage {
    claimed,  // its blobs are to be opened
    opening,  // a thread opens its blobs
    ready,    // it can run
    running,  // it is in the scheduler
    leaving,  // its end or hand-back is to be stored
  };

  std::shared_ptr<LiveJob> live;
  store::Token token;
  std::optional<store::TimePoint> deadline;
  bool in_batch = false;
  bool suspected = false;
  bool guest = false;  // of an owner that had no job running: it needs no worker that is free (scheduler.h)
  Stage stage = Stage::claimed;
  Clock::time_point claimed{};             // when
  std::optional<Clock::time_point> begun;  // when a thread of the scheduler took it
  bool lost = false;                       // the token is no longer the newest
  unsigned failures = 0;                   // to open its blobs
  Clock::time_point not_before{};          // of the next attempt to open them
  std::optional<store::Progress> told;     // the progress that the store has
  JobView last;                            // of an ended job; its document is in the PendingResult
};

using HeldJobPtr = std::shared_ptr<HeldJob>;

class ClaimBuffer {
 public:
  static constexpr std::size_t kMost = 64;
  static constexpr std::size_t kRefillBelow = 32;
  static constexpr std::uint64_t kMostBytes = static_cast<std::uint64_t>(store::JobStore::kBytesOfOneSecond) / 2;
  static constexpr std::uint64_t kSmallBytes = std::uint64_t{4} << 20;
  static constexpr std::chrono::seconds kSoon{5};  // after the claim

  explicit ClaimBuffer(std::size_t threads) : threads_(threads) {}

  void add(HeldJobPtr job);
  // Takes the next job that may begin at `now`; it counts as running until ended(). null: there is none, or one is
  // waited for: ask again after kSoon.
  HeldJobPtr take(LiveJob::Clock::time_point now);
  void ended(const HeldJob& job);
  void remove(const HeldJob& job);  // a job that was not taken; others are ignored
  std::vector<HeldJobPtr> take_all();

  // How many jobs to claim now, guests apart.
  std::size_t wanted() const;
  bool wants_guest() const;  // whether a guest could begin now, and none is here

  // The first job whose blobs are to be opened at `now`; null: there is none.
  HeldJobPtr to_open(LiveJob::Clock::time_point now) const;
  // When the next such job is due; nullopt: there is none.
  std::optional<LiveJob::Clock::time_point> next_opening() const;

  std::size_t waiting() const { return waiting_.size(); }
  std::size_t running() const { return running_ + guests_running_; }

 private:
  static bool is_small(const HeldJob& job) { return job.in_batch && job.live->bytes <= kSmallBytes; }

  const std::size_t threads_;
  std::list<HeldJobPtr> waiting_;
  std::uint64_t waiting_bytes_ = 0;
  std::size_t running_ = 0;  // guests apart
  std::size_t guests_ = 0;   // waiting or running
  std::size_t guests_running_ = 0;
  std::size_t large_running_ = 0;
  std::size_t suspected_ = 0;  // waiting or running
  bool alone_ = false;         // a suspected job runs
};

}  // namespace meshgauge::server
