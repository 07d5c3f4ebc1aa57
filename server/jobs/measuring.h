// One comparison on the thread that it is run on: from its sources to what is kept and told of it.
#pragma once

#include <functional>
#include <memory>

#include "api/compare.h"
#include "server/jobs/live_job.h"
#include "server/jobs/thread_budget.h"
#include "server/observe/metrics.h"
#include "server/settings.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// Where meshes come from: the cache and the sandbox, or what a test puts in their place. An Error is as that of
// api::compare(). Thread safe.
using Fetch = std::function<Result<api::SharedMesh>(const MeshSource& source, Control& control)>;

// Thread safe. Borrows all but the first two.
class Measuring {
 public:
  // `clock`: whose time() a result bears.
  Measuring(const Settings& settings, Fetch fetch, Metrics& metrics, ThreadBudget& threads,
            const store::JobStore& clock)
      : settings_(settings), fetch_(std::move(fetch)), metrics_(metrics), threads_(threads), clock_(clock) {}

  // The job's edge: whatever is thrown ends here.
  Result<api::Comparison> measured(LiveJob& job) const;
  void count(LiveJob& job, const Result<api::Comparison>& result) const;
  // The job as it has ended. `stopping`: the process does.
  JobView last_view(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

 private:
  Result<api::Comparison> measure(LiveJob& job) const;
  JobView concluded(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

  const Settings settings_;
  const Fetch fetch_;
  Metrics& metrics_;
  ThreadBudget& threads_;
  const store::JobStore& clock_;
};

// Whether it was ended by Control::cancel() before it was through.
bool stopped_by_cancel(const Result<api::Comparison>& result);

}  // namespace meshgauge::server
