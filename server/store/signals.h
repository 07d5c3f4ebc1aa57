// Tells the threads and processes that work on one store what changed in it, so that they need not poll. Best effort: a
// signal may be lost, come twice or late, so a listener also looks from time to time.
#pragma once

#include <functional>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

struct Signal {
  enum class Kind {
    work,     // jobs were put into the queue; `job` is empty
    changed,  // of `job`: it was claimed, has progressed or ended
    cancel,   // `job` is to end
    missed,   // some may have been lost: look at everything; `job` is empty
  };
  Kind kind = Kind::missed;
  JobKey job;
};

class Signals {
 public:
  virtual ~Signals() = default;

  using Hear = std::function<void(const Signal&)>;
  // Calls `hear` until stop_listening() or the end, one call at a time, on any thread. `hear` must not block for long,
  // throw, or call the store. One listener at a time. The store itself sends: insert(), insert_batch() and hand_back()
  // `work`; claims of jobs with a deadline, heartbeats with progress and ends of jobs that are in no batch `changed`
  // (SQLite: of every job); request_cancel() and cancel_batch() `cancel`.
  virtual void listen(Hear hear) = 0;
  virtual void stop_listening() = 0;
};

}  // namespace meshgauge::server::store
