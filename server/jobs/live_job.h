// A job as this process knows it: the thread that runs it, or the watcher of the store, writes what happens; clients
// wait for that and read it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/request.h"
#include "api/response.h"
#include "engine/control.h"
#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/jobs/mesh_source.h"
#include "server/jobs/scheduler.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// A job as it stands.
struct JobView {
  store::Job row;            // `document` and `problem` when it has ended
  bool handed_back = false;  // this process stops, and does not follow the job any more
  std::string timing;        // Server-Timing; this and what follows: once it has ended
  std::vector<api::Stage> stages;
  std::optional<MeshSizes> triangles;
  bool reusable = false;  // store::Ending::reusable
};

// Of this process's engine.
store::Progress certified(double lower, double upper, std::string stage);

class LiveJob {
 public:
  using Clock = std::chrono::steady_clock;

  LiveJob(store::NewJob job, api::Request job_request, MeshSource mesh_a, MeshSource mesh_b, bool is_durable,
          Clock::time_point submission = Clock::now());

  const store::JobKey key;
  const std::uint64_t bytes;  // of both files
  const bool durable;         // in the store since before it was accepted
  const Clock::time_point submitted;
  api::Request request;  // the worker's, as are the sources
  MeshSource a;
  MeshSource b;
  Control control;
  std::optional<Error> defect;     // why it cannot run
  std::optional<JobSlot> counted;  // among its owner's jobs

  JobView view() const;
  std::uint64_t version() const;  // grows with every change

  // Waits until the job has ended, was handed back, or changed since `version`; at most `time`.
  bool wait_for_end(std::chrono::milliseconds time) const;
  void wait_for_change(std::uint64_t since, std::chrono::milliseconds time) const;

  void cancel();  // by its owner: it ends as cancelled
  bool cancel_requested() const;
  std::optional<store::Progress> progress() const;

  // What happened: called by the thread that runs it.
  void started(unsigned tries, store::TimePoint when);
  // By this process's engine, or, before it begins, by another of the same version (store::narrowed()).
  void progressed(const store::Progress& progress);
  void ended(JobView last);  // this and release(): the first one counts

  // The same of a job in the store: called by the watcher.
  void seen(const store::Job& row);       // which has not ended
  void release();                         // this process stops; the job is left to the store
  void hold_place(Scheduler::Slot slot);  // in the queue
  void give_places_back();                // that one, and `counted`

 private:
  bool over() const { return store::has_ended(view_.row.state) || view_.handed_back; }
  template <class Change>
  void change(const Change& how);

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  JobView view_;
  std::uint64_t version_ = 0;
  std::optional<Scheduler::Slot> place_;
};

}  // namespace meshgauge::server
