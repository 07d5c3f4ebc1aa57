// Notifies the threads and processes that use one store of changes in it. Best effort: a signal may be lost, late or
// repeated, so a listener must also poll now and then.
#pragma once

#include <functional>
#include <mutex>
#include <utility>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

struct Signal {
  enum class Kind {
    work,     // jobs were queued; `job` is empty
    changed,  // `job` was claimed, has progressed or has ended
    cancel,   // a cancel of `job` was requested
    missed,   // signals may have been lost: read everything; `job` is empty
  };
  Kind kind = Kind::missed;
  JobKey job;
};

class Signals {
 public:
  virtual ~Signals() = default;

  using Hear = std::function<void(const Signal&)>;
  // Calls `hear` on any thread, one call at a time, until stop_listening() or the end of this object. `hear` must not
  // block for long, throw, or call the store. One listener at a time. What the store sends:
  //   work     insert(), insert_batch(), hand_back()
  //   changed  claims of jobs with a deadline; heartbeats with progress and ends of jobs of no batch (SQLite: all jobs)
  //   cancel   request_cancel() and cancel_batch(), of running jobs
  virtual void listen(Hear hear) = 0;
  virtual void stop_listening() = 0;
};

// Signals within one process, on the sender's thread.
class MemorySignals final : public Signals {
 public:
  void listen(Hear hear) override {
    const std::lock_guard lock(mutex_);
    hear_ = std::move(hear);
  }
  void stop_listening() override { listen(nullptr); }

  void tell(Signal::Kind kind, const JobKey& job = {}) {
    const std::lock_guard lock(mutex_);
    if (hear_) hear_({kind, job});
  }

 private:
  std::mutex mutex_;  // held while `hear_` runs
  Hear hear_;
};

}  // namespace meshgauge::server::store
