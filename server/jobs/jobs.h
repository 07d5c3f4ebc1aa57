// Every comparison that this service accepts, from its submission to its stored result, in both forms.
//
//   stored:   submit -> row and blobs in the store -> a Worker, here or in other processes -> Watcher -> clients
//   unstored: submit -> scheduler -> measure -> client -> record
//
// A durable job is in the store before its client gets the 202, runs again after a crash, and is not cancelled when the
// client disconnects. Any other job ends with its client's connection. In the embedded form this process has the
// worker, and a job that is not durable is stored only when it has ended. In the distributed form every job is stored,
// with a deadline if a client waits for it, and the scheduler counts the clients that wait.
//
// Thread safe.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "server/access/access.h"
#include "server/base/each_second.h"
#include "server/jobs/store_queue.h"
#include "server/jobs/upkeep.h"
#include "server/jobs/watcher.h"
#include "server/measure/kept_blobs.h"
#include "server/measure/live_job.h"
#include "server/measure/measuring.h"
#include "server/measure/scheduler.h"
#include "server/measure/stores.h"
#include "server/observe/metrics.h"
#include "server/sandbox/memory_budget.h"
#include "server/settings/settings.h"
#include "server/worker/worker.h"

namespace meshgauge::server {

struct Submission {
  store::JobKey key;
  std::string client;  // that shares are counted for (share.h)
  api::Request request;
  std::string options;  // the JSON that `request` was read from
  MeshSource a;
  MeshSource b;
  bool durable = false;
  std::string idempotency_key;  // durable only; empty: none
  std::string trace;
  std::optional<JobSlot> counted;  // its place among its owner's jobs
};

class Jobs final : private Watcher::Listener {
 public:
  using Kind = Scheduler::Kind;
  // The job to wait for; or the job that its idempotency key names, if that has ended; or a refusal.
  using Submitted = std::variant<std::shared_ptr<LiveJob>, JobView, Denial>;

  // Borrows all but the first. Listens to the stores' signals during its lifetime.
  Jobs(const Settings& settings, MeshLoader& loader, const Stores& stores, Access& access, Metrics& metrics);
  ~Jobs() override;  // as stop()
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  // Requeues the jobs that were running when the last process ended, and starts the worker. Call it once, first.
  Result<Done> recover();

  // An error: the store does not answer, so no comparison can be accepted. Never blocks.
  Result<Done> available() const { return queue_ ? queue_->available() : Done{}; }
  // nullopt: the queue is full, and the client has its share of it (share.h).
  std::optional<Scheduler::Slot> admit(Kind kind, const std::string& client);
  bool has_place(Kind kind, const std::string& client) const;  // whether admit() would succeed now
  bool has_place_for_new_client(Kind kind) const;              // one that has no place yet
  Submitted submit(Scheduler::Slot slot, Submission submission);
  // Whether a stored comparison has the submission's idempotency key.
  Result<bool> repeats(const Submission& submission);
  // Returns that comparison if the meshes and the text of the options are the same, byte by byte; else a conflict.
  Submitted repeated(Submission& submission);

  // nullopt: the owner has no such job.
  Result<std::optional<JobView>> get(const store::JobKey& key);
  // Returns the job of a view from get(), to wait for it. Null: it has ended, or this process stops.
  std::shared_ptr<LiveJob> watch(const JobView& job);
  // Requests the cancel of a job, and blocks up to a second for its end. Nothing happens to one that has ended, or that
  // there is not.
  Result<Done> cancel(const store::JobKey& key);
  // Requests the cancel of a job that has not ended, and blocks up to a second for its end; removes an ended one.
  enum class Deleted { unknown, asked_to_end, forgotten };
  Result<Deleted> remove(const store::JobKey& key);

  // Ends a job that is not durable and whose client has disconnected. false: it ends soon, in this process.
  bool abandon(const std::shared_ptr<LiveJob>& job);
  // Ends a job that waits for a thread and is not stored, if its cancel was requested, its client has disconnected, or
  // its timeout has passed. Call it then. Does not block.
  void end_if_over(LiveJob& job);
  // Returns the reason to stop waiting for this job, or nullopt to keep waiting.
  std::optional<api::Problem> give_up(const LiveJob& job) const;

  // For work other than comparisons, on the same threads and in the same order.
  std::optional<Scheduler::Slot> admit_work(const std::string& client) {
    return scheduler_.admit(Kind::awaited, client);
  }
  void work(Scheduler::Slot slot, Scheduler::Task task) { scheduler_.submit(std::move(slot), std::move(task)); }
  bool withdraw(const Control& control) { return scheduler_.withdraw(control); }
  std::chrono::milliseconds expected_wait_for_work() const { return scheduler_.expected_wait(); }
  ThreadBudget& threads() { return threads_; }
  MemoryBudget& memory() { return memory_; }
  bool draining() const { return draining_.load(); }
  bool stopping() const { return stopping_.load(); }

  Scheduler::Figures figures() const;                        // distributed form: counts durable jobs of all front ends
  std::size_t waiting() const;                               // jobs that wait for a thread of this process
  std::chrono::milliseconds expected_wait(Kind kind) const;  // of a new job
  const StoreQueue* store_queue() const { return queue_ ? &*queue_ : nullptr; }  // null: the embedded form

  // Begins no further stored job. Running jobs go on.
  void drain();

  // Ends all jobs here: awaited ones with the interval that they have reached; stored ones go back to the store.
  void stop();

 private:
  bool is_full(Kind kind) const;  // of the distributed form
  void run_unstored(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);
  void measure_unstored(LiveJob& job, Scheduler::Slot slot);
  void end_unstored(LiveJob& job, const Result<api::Comparison>& result, std::optional<Scheduler::Slot> slot);
  Submitted submit_stored(Scheduler::Slot slot, Submission submission);
  std::optional<Denial> keep_blobs(const Submission& submission);
  std::optional<Denial> keep_blob(const std::string& owner, const MeshSource& source);
  std::shared_ptr<LiveJob> job_of(Submission submission) const;
  Submitted found(const store::Job& row, bool conflict);
  Access::CountJobs unended_of(const std::string& owner);
  Submitted denied(const store::NewJob& row, Denial denial);
  Submitted insert(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);
  Result<bool> cancel(const store::Job& row);
  Result<Deleted> forget(const store::JobKey& key);
  void ended(const LiveJob& job, const store::Job& row) override;

  const Settings settings_;
  const Stores stores_;
  Access& access_;
  Metrics& metrics_;
  std::atomic<bool> draining_{false};
  std::atomic<bool> stopping_{false};
  StoreErrors store_errors_;
  ThreadBudget threads_;
  MemoryBudget memory_;
  const Measuring measuring_;
  Scheduler scheduler_;
  Upkeep upkeep_;
  std::optional<StoreQueue> queue_;  // of the distributed form
  Watcher watcher_;
  std::optional<Worker> worker_;  // of the embedded form
  std::optional<EachSecond> upkeep_thread_;
};

}  // namespace meshgauge::server
