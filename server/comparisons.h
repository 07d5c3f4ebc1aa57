// POST /v1/comparisons: admit -> receive -> parse -> run on a worker -> respond.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "api/compare.h"
#include "api/request.h"
#include "server/exchange.h"
#include "server/form.h"
#include "server/job_queue.h"
#include "server/observe/metrics.h"
#include "server/settings.h"
#include "server/thread_budget.h"
#include "server/upload.h"

namespace meshgauge::server {

// api::compare_by() with meshes from the sandbox, or what a test puts in its place.
using Compare =
    std::function<Result<api::Comparison>(const api::MeshInput& a, const api::MeshInput& b, const Options& options,
                                          const api::ReadLimits& limits, Control& control)>;

class Comparisons {
 public:
  Comparisons(const Settings& settings, Compare compare, Metrics& metrics);  // which must outlive them

  void create(Exchange& exchange);  // may throw: out of memory
  void refuse_new() { draining_.store(true); }
  void cancel_all() { jobs_.cancel_all(); }

 private:
  struct Job;

  std::optional<api::Problem> receive(Exchange& exchange, Form& form);
  void watch_levels();
  std::shared_ptr<Job> start(JobQueue::Slot slot, Form form, api::Request request, const std::string& id);
  void run(Job& job, JobQueue::Slot slot);
  Result<api::Comparison> measure(Job& job);
  void respond(Exchange& exchange, const Result<api::Comparison>& result) const;

  const Settings settings_;
  const Compare compare_;
  Metrics& metrics_;
  ByteBudget budget_;     // outlives the jobs
  ThreadBudget threads_;  // likewise
  std::atomic<bool> draining_{false};
  JobQueue jobs_;
};

}  // namespace meshgauge::server
