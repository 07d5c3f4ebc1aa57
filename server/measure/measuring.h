// Measures one comparison on the calling thread: from its sources to its stored result.
#pragma once

#include <functional>
#include <memory>

#include "api/compare.h"
#include "server/measure/live_job.h"
#include "server/measure/memory_budget.h"
#include "server/measure/thread_budget.h"
#include "server/observe/metrics.h"
#include "server/settings/settings.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// Loads a mesh: from the cache and the sandbox, or by a test's replacement. Reserves its memory; when that must begin
// again, the result is meaningless. Errors as of api::compare(). Thread safe.
using Fetch =
    std::function<Result<api::SharedMesh>(const MeshSource& source, MemoryReservation& memory, Control& control)>;

// Thread safe. Borrows all but the first two.
class Measuring {
 public:
  // `clock`: its time() dates results.
  Measuring(const Settings& settings, Fetch fetch, Metrics& metrics, ThreadBudget& threads, MemoryBudget& memory,
            const store::JobStore& clock)
      : settings_(settings),
        fetch_(std::move(fetch)),
        metrics_(metrics),
        threads_(threads),
        memory_(memory),
        clock_(clock) {}

  // Measures the job. Turns every exception into an Error.
  Result<api::Comparison> measured(LiveJob& job) const;
  void count(LiveJob& job, const Result<api::Comparison>& result) const;
  // Returns the ended job. `stopping`: this process stops.
  JobView last_view(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

 private:
  Result<api::Comparison> measure(LiveJob& job) const;
  Result<api::Comparison> measure_within(MemoryReservation& memory, LiveJob& job, api::StageTimes times) const;
  JobView concluded(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

  const Settings settings_;
  const Fetch fetch_;
  Metrics& metrics_;
  ThreadBudget& threads_;
  MemoryBudget& memory_;
  const store::JobStore& clock_;
};

// Whether Control::cancel() ended the comparison early.
bool stopped_by_cancel(const Result<api::Comparison>& result);

}  // namespace meshgauge::server
