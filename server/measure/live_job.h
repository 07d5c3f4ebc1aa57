// A job in this process, made of a request or of a row of the store. The thread that runs it, or the watcher of the
// store, updates it; clients wait for changes and read it. Thread safe, except for the members that the worker owns.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/options/request.h"
#include "api/result/response.h"
#include "engine/control.h"
#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/measure/mesh_source.h"
#include "server/measure/scheduler.h"
#include "server/settings/settings.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server {

// The state of a job at one moment.
struct JobView {
  store::Job row;                               // with `document` and `problem` if it has ended
  std::shared_ptr<const api::Request> request;  // what row.options ask for; null: this process has not parsed them
  bool handed_back = false;                     // this process stops and no longer follows the job
  std::string timing;                           // Server-Timing; this and the members below are set when it has ended
  std::vector<api::Stage> stages;
  std::optional<MeshSizes> triangles;
  bool reusable = false;  // store::Ending::reusable
};

// Progress with bounds that this process's engine has certified.
store::Progress certified(double lower, double upper, std::string stage);

// Returns store::BatchItem::work of the job as this process would run it: equal for jobs with the same result, so it
// depends on this process's version. The process that inserts a job stores its own key. The worker that has run the job
// stores its own key again, because during an upgrade it may have another version: results are found by the version
// that computed them.
std::string work_of(const store::NewJob& job);

class LiveJob {
 public:
  using Clock = std::chrono::steady_clock;

  // `parsed`: the options of the job; nullopt: this process has not parsed them, and `request` has the defaults.
  LiveJob(store::NewJob job, std::optional<api::Request> parsed, MeshSource mesh_a, MeshSource mesh_b, bool is_durable,
          Clock::time_point submission = Clock::now());

  const store::JobKey key;
  std::string client;         // that shares are counted for: the owner; without keys, a tag of the address
  const std::uint64_t bytes;  // of both files
  const bool durable;         // stored before it was accepted
  const Clock::time_point submitted;
  api::Request request;  // this and the sources: used by the running thread alone
  MeshSource a;
  MeshSource b;
  Control control;
  std::optional<Error> defect;     // why it cannot run
  std::optional<JobSlot> counted;  // its place among its owner's jobs

  JobView view() const;
  store::JobState state() const;
  std::uint64_t version() const;  // grows with every change

  // Blocks until is_over(), for at most `time`. Returns whether it is.
  bool wait_for_end(std::chrono::milliseconds time) const;
  bool is_over() const;  // it has ended or was handed back
  // Calls `wake` after every change, until the pointer that is returned is destroyed. `wake` must not block.
  std::shared_ptr<const void> on_change(std::function<void()> wake);
  // The same, but only after changes of a job that is over or whose cancel was requested: for clients that wait for its
  // end alone.
  std::shared_ptr<const void> on_end(std::function<void()> wake);

  void cancel();  // for its owner: it ends as cancelled
  bool cancel_requested() const;
  std::optional<store::Progress> progress() const;

  // When a client that waits gives up: the timeout runs from the submission on, in the queue as well.
  Clock::time_point deadline() const { return submitted + request.timeout; }

  // Sets the deadline of `control`, and passes its reports on to progressed(). Call it before the run.
  void set_up_control(Clock::time_point latest);

  // Called by the thread that runs it.
  void started(unsigned tries, store::TimePoint when);
  // Bounds of this process's engine or, before the run, of one of the same version (store::narrowed()).
  void progressed(const store::Progress& progress);
  void ended(JobView last);  // the first call of this or release() counts; view().request stays

  // For a job in the store: called by the watcher.
  void seen(const store::Job& row);       // a row that has not ended
  void release();                         // this process stops and leaves the job to the store
  void hold_place(Scheduler::Slot slot);  // its place in the queue
  void give_places_back();                // that place, and `counted`

 private:
  struct Listener {
    std::function<void()> wake;
    bool ends_only;
  };

  bool over() const { return store::has_ended(view_.row.state) || view_.handed_back; }
  std::shared_ptr<const void> listen(Listener listener);
  template <class Change>
  void change(const Change& how);
  void notify();

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  JobView view_;
  std::uint64_t version_ = 0;
  std::optional<Scheduler::Slot> place_;
  std::vector<std::weak_ptr<const Listener>> listeners_;
};

// Applies the settings that limit every comparison.
api::Request limited(api::Request request, const Settings& settings);

// Returns a job to run, without its bytes. A job whose options this version does not understand has a defect, and fails
// when it runs. `waited`: the time that it has waited in the store.
std::shared_ptr<LiveJob> live_job_of(const store::Job& row, const Settings& settings,
                                     std::chrono::milliseconds waited = {});

// Marks the meshes that are worth caching: those that their owner has stored as meshes.
Result<Done> recognise_meshes(LiveJob& job, store::MeshIndex& meshes);

// Opens the blobs of its meshes: a waiting job holds neither memory nor descriptors. A mesh that no longer exists is
// left without a holder.
Result<Done> open_blobs(LiveJob& job, store::BlobStore& blobs);

}  // namespace meshgauge::server
