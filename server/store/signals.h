// What processes that work on one store tell each other, so that nobody need ask it again and again. Best effort: a
// signal may be lost, come twice or late, so whoever waits also looks from time to time.
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
  // Calls `hear` on a thread of its own until stop_listening() or the end, one at a time; it must not block for long
  // nor throw. Once. The store itself sends: insert() and insert_batch() `work`, claims of jobs with a deadline,
  // heartbeats with progress and ends of jobs that are in no batch `changed`, request_cancel() and cancel_batch()
  // `cancel`.
  virtual void listen(Hear hear) = 0;
  virtual void stop_listening() = 0;
};

}  // namespace meshgauge::server::store
