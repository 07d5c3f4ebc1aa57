// One comparison on the thread that it is run on: from its sources to what is kept and told of it.
#pragma once

#include <functional>
#include <memory>

#include "api/compare.h"
#include "server/jobs/live_job.h"
#include "server/observe/metrics.h"
#include "server/settings.h"
#include "server/store/job_store.h"
#include "server/thread_budget.h"

namespace meshgauge::server {

// api::compare_prepared() with meshes from the cache and the sandbox, or what a test puts in its place.
using Compare = std::function<Result<api::Comparison>(const MeshSource& a, const MeshSource& b,
                                                      const api::ComparisonOptions& options,
                                                      const api::ReadLimits& limits, Control& control)>;

// A mesh of a comparison, from the cache or the sandbox.
using Fetch = std::function<Result<std::shared_ptr<const api::PreparedMesh>>(
    const MeshSource& source, const api::ReadLimits& limits, Control& control)>;

// Thread safe. Borrows all but the first two.
class Measuring {
 public:
  // `clock`: whose time() a result bears.
  Measuring(const Settings& settings, Compare compare, Metrics& metrics, ThreadBudget& threads,
            const store::JobStore& clock)
      : settings_(settings), compare_(std::move(compare)), metrics_(metrics), threads_(threads), clock_(clock) {}

  // The job's edge: whatever is thrown ends here.
  Result<api::Comparison> measured(LiveJob& job) const;
  void count(LiveJob& job, const Result<api::Comparison>& result) const;
  // The job as it has ended. `stopping`: the process does.
  JobView told(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

 private:
  Result<api::Comparison> measure(LiveJob& job) const;
  JobView concluded(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

  const Settings settings_;
  const Compare compare_;
  Metrics& metrics_;
  ThreadBudget& threads_;
  const store::JobStore& clock_;
};

// Whether it was ended by Control::cancel() before it was through.
bool stopped_by_cancel(const Result<api::Comparison>& result);

}  // namespace meshgauge::server
