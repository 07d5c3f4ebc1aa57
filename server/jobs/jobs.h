// Every comparison that this service lets in, whoever waits for it: from its submission to what is kept of it.
//
//   submit -> (to be stored: blobs and row) -> a Runner, here or elsewhere -> get, watch, remove
//
// A durable job was promised to be done: it is in the store before anybody is told so, runs again after a crash, and
// nobody's going away ends it. Any other job is its client's, and only its end is kept.
//
// Thread safe.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "server/access/access.h"
#include "server/jobs/kept_blobs.h"
#include "server/jobs/live_job.h"
#include "server/jobs/measuring.h"
#include "server/jobs/runner.h"
#include "server/jobs/scheduler.h"
#include "server/jobs/stores.h"
#include "server/jobs/troubles.h"
#include "server/jobs/upkeep.h"
#include "server/observe/metrics.h"
#include "server/settings.h"
#include "server/thread_budget.h"

namespace meshgauge::server {

struct Submission {
  store::JobKey key;
  api::Request request;
  std::string options;  // the JSON that `request` was read from
  MeshSource a;
  MeshSource b;
  bool durable = false;
  std::string idempotency_key;  // durable only; empty: none
  std::string trace;
  std::optional<JobSlot> counted;  // among its owner's jobs
};

class Jobs {
 public:
  using Kind = Scheduler::Kind;
  // What a submission became: a job to wait for, one that has ended already (its idempotency key was seen before), or
  // a refusal.
  using Submitted = std::variant<std::shared_ptr<LiveJob>, JobView, Denial>;

  // Borrows all but the first two. Comparisons run here unless the stores are shared.
  Jobs(const Settings& settings, Compare compare, Stores stores, Access& access, Metrics& metrics);
  ~Jobs();  // as stop()
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  // Begins what was left undone before this start. Called once, first.
  Result<Done> recover() { return runner_->recover(); }

  // Whether comparisons can be let in at all; at once, whatever the store does.
  Result<Done> available() const { return runner_->available(); }
  std::optional<Scheduler::Slot> admit(Kind kind) { return runner_->admit(kind); }
  Submitted submit(Scheduler::Slot slot, Submission submission);
  // Whether its idempotency key is one of a comparison that is kept, whatever is asked for now.
  Result<bool> repeats(const Submission& submission);
  // That comparison, if the same is asked for: by the bytes or the ids of the meshes, and the options.
  Submitted repeated(Submission& submission);

  // nullopt: this owner has no such job.
  Result<std::optional<JobView>> get(const store::JobKey& key);
  // Of one that get() gave: what to wait for. Null: it has ended, or nobody here can tell when it does.
  std::shared_ptr<LiveJob> watch(const JobView& job) { return runner_->watch(job.row); }
  std::shared_ptr<LiveJob> live(const store::JobKey& key) const;  // null: it does not wait or run here
  // Asks a job that has not ended to end, and waits a second for that; forgets one that has.
  enum class Deleted { unknown, asked_to_end, forgotten };
  Result<Deleted> remove(const store::JobKey& key);

  // For who waits for a job. abandon(): see Runner.
  bool abandon(const std::shared_ptr<LiveJob>& job) { return runner_->abandon(job); }
  std::optional<api::Problem> give_up(const LiveJob& job) const { return runner_->give_up(job); }

  // Other work than a comparison, on the same workers and in the same order.
  std::optional<Scheduler::Slot> admit_work() { return scheduler_.admit(Kind::awaited); }
  void work(Scheduler::Slot slot, Scheduler::Task task) { scheduler_.submit(std::move(slot), std::move(task)); }
  bool withdraw(const Control& control) { return scheduler_.withdraw(control); }
  std::chrono::milliseconds expected_wait_for_work() const { return scheduler_.expected_wait(); }
  ThreadBudget& threads() { return threads_; }
  bool draining() const { return phase_.draining.load(); }
  bool stopping() const { return phase_.stopping.load(); }

  Scheduler::Figures figures() const { return runner_->figures(); }
  std::chrono::milliseconds expected_wait() const { return runner_->expected_wait(); }
  Runner::Queue store_queue() const { return runner_->store_queue(); }

  // There are jobs of a batch in the store.
  void look() { runner_->look(); }

  // No durable job begins here any more. What runs goes on.
  void drain();

  // Ends what runs and waits here: awaited jobs with the interval they have reached, durable ones go back to the store.
  void stop();

 private:
  Submitted submit_stored(Scheduler::Slot slot, Submission submission);
  std::optional<Denial> keep_blobs(const Submission& submission);
  std::optional<Denial> keep_blob(const std::string& owner, const MeshSource& source);
  std::shared_ptr<LiveJob> job_of(Submission submission) const;
  Submitted found(const store::Job& row, bool conflict);
  Access::CountJobs unended_of(const std::string& owner);
  Submitted denied(const store::NewJob& row, Denial denial);
  Submitted insert(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);
  Result<Deleted> forget(const store::JobKey& key);
  void maintain();

  const Settings settings_;
  const Stores stores_;
  Access& access_;
  Phase phase_;
  Troubles troubles_;
  ThreadBudget threads_;
  const Measuring measuring_;
  Scheduler scheduler_;
  std::unique_ptr<Runner> runner_;  // before the scheduler it has slots of
  Upkeep upkeep_;
  std::mutex mutex_;  // guards ending_
  bool ending_ = false;
  std::condition_variable wake_;
  std::thread maintenance_;
};

}  // namespace meshgauge::server
