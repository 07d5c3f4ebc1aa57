// Who runs the comparisons that Jobs lets in: this process (local_runner.h), or workers elsewhere that share its stores
// (remote_runner.h).
//
//   admit -> (its row is to be stored: expect, then run or forget) -> run -> the LiveJob tells what becomes of it
//
// Thread safe.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "api/problem.h"
#include "server/jobs/live_job.h"
#include "server/jobs/scheduler.h"

namespace meshgauge::server {

// How far the end of this process has come.
struct Phase {
  std::atomic<bool> draining{false};
  std::atomic<bool> stopping{false};
};

class Runner {
 public:
  virtual ~Runner() = default;

  // Begins what was left undone before this start. Called once, first.
  virtual Result<Done> recover() = 0;

  // Whether comparisons can be let in at all; at once, whatever the store does.
  virtual Result<Done> available() const = 0;
  virtual std::optional<Scheduler::Slot> admit(Scheduler::Kind kind) = 0;  // nullopt: the queue is full
  virtual Scheduler::Figures figures() const = 0;
  virtual std::chrono::milliseconds expected_wait() const = 0;
  struct Queue {
    std::uint64_t waiting = 0;  // of all processes that share the store
    double oldest_seconds = 0;  // that one of them has waited
  };
  virtual Queue store_queue() const = 0;  // as it was seen last; empty when the stores are not shared

  // Whether an awaited job, too, must be in the store to be run.
  virtual bool stores_all() const = 0;
  // Of a job that is about to be stored: whoever repeats its idempotency key finds it from here on.
  virtual void expect(const std::shared_ptr<LiveJob>& job) = 0;
  virtual void forget(const LiveJob& job) = 0;  // it did not come to that
  virtual void run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) = 0;

  // The job if it waits or runs in this process, which then knows more of it than the store; else null.
  virtual std::shared_ptr<LiveJob> here(const store::JobKey& key) const = 0;
  // Of a row that was just read: what to wait for. Null: it has ended, or nobody can tell when it does.
  virtual std::shared_ptr<LiveJob> watch(const store::Job& row) = 0;

  // Of a row that was just read and had not ended: asks it to end, and waits a second for that. false: it is gone.
  virtual Result<bool> cancel(const store::Job& row) = 0;
  // Nobody waits any more for a job that is not durable: it is to end. false: it does so soon, and may be waited for.
  virtual bool abandon(const std::shared_ptr<LiveJob>& job) = 0;
  // Why who waits for this job had better not wait on; nullopt: he had.
  virtual std::optional<api::Problem> give_up(const LiveJob& job) const = 0;

  virtual void look() = 0;   // there are jobs of a batch to be run
  virtual void tick() = 0;   // once a second, by one thread
  virtual void drain() = 0;  // see Jobs::drain()
  virtual void stop() = 0;   // see Jobs::stop()
};

}  // namespace meshgauge::server
