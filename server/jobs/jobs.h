// Every comparison that this service runs, whoever waits for it: from its submission to what is kept of it.
//
//   submit -> (durable: blobs and row are stored) -> scheduler -> run on a worker -> (durable: finish; else: record)
//
// A durable job was promised to be done: it is in the store before anybody is told so, runs again after a crash, and
// nobody's going away ends it. Any other job lives in this process, and only its end is kept.
//
// Thread safe.
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "server/access/access.h"
#include "server/jobs/live_job.h"
#include "server/jobs/measuring.h"
#include "server/jobs/scheduler.h"
#include "server/maps/map_cache.h"
#include "server/observe/metrics.h"
#include "server/settings.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/mesh_index.h"
#include "server/thread_budget.h"

namespace meshgauge::server {

struct Stores {
  store::JobStore& jobs;
  store::MeshIndex& meshes;
  store::BlobStore& blobs;
  MeshCache& cache;
  MapCache* maps = nullptr;  // none: no deviation maps are made
};

// Access::hold_storage() beside what the owner's blobs take when it asks. Whoever puts a blob that is not there holds
// its bytes until the blob is put: so all of an owner's together never pass the limit. Nothing is held, or denied, for
// 0.
std::variant<StorageHold, Denial> hold_storage(Access& access, store::BlobStore& blobs, const std::string& owner,
                                               std::uint64_t bytes, std::uint64_t max_stored_bytes);

// At once, so that nobody's deleted bytes fill the disk until the next sweep.
Result<bool> remove_if_unreferenced(const Stores& stores, const store::BlobKey& key);

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

  // Borrows all but the first two.
  Jobs(const Settings& settings, Compare compare, Stores stores, Access& access, Metrics& metrics);
  ~Jobs();  // as stop()
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  // Begins what was left undone before this start. Called once, first.
  Result<Done> recover();

  std::optional<Scheduler::Slot> admit(Kind kind) { return scheduler_.admit(kind); }
  Submitted submit(Scheduler::Slot slot, Submission submission);
  // Whether its idempotency key is one of a comparison that is kept, whatever is asked for now.
  Result<bool> repeats(const Submission& submission);
  // That comparison, if the same is asked for: by the bytes or the ids of the meshes, and the options.
  Submitted repeated(Submission& submission);

  // nullopt: this owner has no such job.
  Result<std::optional<JobView>> get(const store::JobKey& key);
  std::shared_ptr<LiveJob> live(const store::JobKey& key) const;  // null: it does not wait or run here
  // Asks a job that has not ended to end, and waits a second for that; forgets one that has.
  enum class Deleted { unknown, asked_to_end, forgotten };
  Result<Deleted> remove(const store::JobKey& key);

  // Other work than a comparison, on the same workers and in the same order.
  void work(Scheduler::Slot slot, Scheduler::Task task) { scheduler_.submit(std::move(slot), std::move(task)); }
  bool withdraw(const Control& control) { return scheduler_.withdraw(control); }
  ThreadBudget& threads() { return threads_; }
  bool draining() const { return draining_.load(); }
  bool stopping() const { return stopping_.load(); }

  Scheduler::Figures figures() const { return scheduler_.figures(); }
  std::chrono::milliseconds expected_wait() const { return scheduler_.expected_wait(); }

  // No durable job begins any more: the next start runs it. What runs goes on.
  void drain() { draining_.store(true); }

  // Ends what runs and waits: awaited jobs with the interval they have reached, durable ones go back to the store.
  void stop();

 private:
  // A job that waits for the store, to begin (without `last`) or to end.
  struct Parked {
    std::shared_ptr<LiveJob> job;
    std::optional<Scheduler::Slot> slot;
    std::optional<JobView> last;
    bool cut_short = false;  // it was cancelled, by whomever
  };
  enum class Begun { yes, not_ours, later };

  Result<Done> revive(const store::Job& row);
  Result<Done> recognise(const std::string& owner, MeshSource& source);
  api::Request limited(api::Request request) const;
  Submitted submit_durable(Scheduler::Slot slot, Submission submission);
  std::optional<Denial> keep_blobs(const Submission& submission);
  std::optional<Denial> keep_blob(const std::string& owner, const MeshSource& source);
  void release_blobs(const std::string& owner, const std::string& a, const std::string& b);
  std::shared_ptr<LiveJob> job_of(Submission submission) const;
  Submitted found(const store::Job& row, bool conflict);
  Submitted insert(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);
  void enqueue(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);

  void run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);
  Begun begin(LiveJob& job);
  bool is_queued(const LiveJob& job);
  Result<Done> open_blobs(LiveJob& job);
  void conclude(Parked ended);
  void drop(LiveJob& job);
  void leave_to_its_end(LiveJob& job);

  void register_live(const std::shared_ptr<LiveJob>& job);
  void forget_live(const LiveJob& job);
  void park(Parked parked);
  void maintain();
  void retry_parked();
  void note(const auto& result) {
    if (!result) failed(result.error());
  }
  void failed(const Error& error);
  void sweep();

  const Settings settings_;
  const Stores stores_;
  Access& access_;
  Metrics& metrics_;
  const std::string worker_;  // this process, in tokens
  ThreadBudget threads_;
  const Measuring measuring_;
  std::atomic<bool> draining_{false};
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;                              // guards what follows, but the scheduler
  std::map<std::string, std::shared_ptr<LiveJob>> live_;  // by id
  std::vector<Parked> parked_;                            // what the store could not be told yet
  std::string trouble_;                                   // that the store had last
  LiveJob::Clock::time_point trouble_told_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::thread maintenance_;
  Scheduler scheduler_;
};

}  // namespace meshgauge::server
