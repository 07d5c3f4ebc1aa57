// A job that this worker has claimed, until the store has its end or has it back.
#pragma once

#include <memory>
#include <optional>

#include "server/measure/live_job.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// Guarded by its worker's mutex, except `live` (live_job.h).
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

}  // namespace meshgauge::server
