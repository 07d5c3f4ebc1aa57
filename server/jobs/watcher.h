// Follows the stored jobs that clients of this process wait for, by their ids. Reads a job's row after a signal of its
// change, and the rows of all of them once a second.
//
// Thread safe.
#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "server/base/threads.h"
#include "server/measure/live_job.h"
#include "server/measure/stores.h"
#include "server/observe/metrics.h"
#include "server/store/job_store.h"
#include "server/store/signals.h"

namespace meshgauge::server {

class Watcher {
 public:
  // Receives the ends of jobs.
  class Listener {
   public:
    virtual ~Listener() = default;
    // Called once for each job that is followed to its end, before any client sees the end; on the watcher's thread, or
    // by stop(). Must not block. `row`: of the ended job.
    virtual void ended(const LiveJob& job, const store::Job& row) = 0;
  };

  // `keep`: for how long a job that is cancelled here is kept. Borrows all others.
  Watcher(store::JobStore& jobs, StoreErrors& store_errors, Metrics& metrics, std::chrono::seconds keep,
          Listener& listener);
  ~Watcher() { stop(); }
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  void hear(const store::Signal& signal);

  // Registers a job of this process before it is stored: watch() finds it. begin() starts reading its row; forget()
  // drops it. A durable job is followed to its end, with or without clients, since it holds places.
  void expect(const std::shared_ptr<LiveJob>& job);
  void begin(const std::shared_ptr<LiveJob>& job);
  void forget(const LiveJob& job);
  // Returns the expected job if it is not durable and not stored; else null.
  std::shared_ptr<LiveJob> unstored(const store::JobKey& key) const;

  // Returns the job of a row, the same object for all clients; null after stop(). Precondition: the row had not ended.
  std::shared_ptr<LiveJob> watch(const store::Job& row);
  // Follows a durable job from before this start, which holds these places.
  void adopt(const store::Job& row, Scheduler::Slot slot, JobSlot counted);

  // For a job whose client has disconnected: requests its cancel, repeatedly until its time is over.
  void leave(const std::shared_ptr<LiveJob>& job);

  // Releases queued jobs, now and later: they run after the next start.
  void drain();
  // Releases all jobs: their clients learn that this process stops. Requests the cancel of those that are not durable.
  void stop();

  std::size_t queued() const;  // followed durable jobs that are queued

 private:
  struct Watched {
    std::weak_ptr<LiveJob> job;
    std::shared_ptr<LiveJob> held;  // set while the watcher itself keeps the job
    bool stored = false;
  };
  using Jobs = std::vector<std::shared_ptr<LiveJob>>;

  std::shared_ptr<LiveJob> watch_under_lock(const store::Job& row);
  void release(const std::shared_ptr<LiveJob>& job);
  void watch_on();
  void tell_end();
  Jobs those_changed();
  Jobs all_watched();
  void poll(const Jobs& jobs);
  void poll_some(std::span<const std::shared_ptr<LiveJob>> jobs);
  void tell(const std::shared_ptr<LiveJob>& job, const store::Job* row);
  void cancel_left();
  bool cancelled(LiveJob& job);

  store::JobStore& jobs_;
  StoreErrors& store_errors_;
  Metrics& metrics_;
  const std::chrono::seconds keep_;
  Listener& listener_;
  mutable std::mutex mutex_;                    // guards the members below
  std::map<std::string, Watched> watched_;      // by id
  std::set<std::string> changed_;               // ids whose rows are to be read
  std::vector<std::shared_ptr<LiveJob>> left_;  // to be cancelled
  unsigned round_ = 0;                          // number of reads of all rows
  bool missed_ = false;
  bool leaving_ = false;
  bool draining_ = false;
  bool stopped_ = false;
  bool ending_ = false;
  std::condition_variable wake_;
  Threads threads_;
};

}  // namespace meshgauge::server
