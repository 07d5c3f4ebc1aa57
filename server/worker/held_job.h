// A job that this worker has claimed, until the store knows its end or has it back.
#pragma once

#include <memory>
#include <optional>

#include "server/jobs/live_job.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// Its worker guards it, but for `live`: who that belongs to is said there.
struct HeldJob {
  using Clock = LiveJob::Clock;
  enum class Stage {
    claimed,  // its meshes are still to be looked up
    opening,  // ... by a thread that is at it
    ready,    // it can run
    running,  // given to the scheduler
    leaving,  // its end, or that it is handed back, is on its way to the store
  };

  std::shared_ptr<LiveJob> live;
  store::Token token;
  std::optional<store::TimePoint> deadline;
  bool in_batch = false;
  bool suspected = false;
  Stage stage = Stage::claimed;
  std::optional<Clock::time_point> begun;  // a thread of the scheduler has taken it
  bool lost = false;                       // the store has given it to another worker, or has it back
  unsigned failures = 0;                   // to open its meshes
  Clock::time_point not_before{};          // when to try that again
  std::optional<store::Progress> told;     // that the store knows of
  JobView last;                            // when it has ended; the ending has its document
};

using HeldJobPtr = std::shared_ptr<HeldJob>;

}  // namespace meshgauge::server
