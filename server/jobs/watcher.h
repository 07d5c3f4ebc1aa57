// The jobs that clients of this process wait for or follow, by their ids. Reads their rows when a signal tells of a
// change, and all of them once a second.
//
// Thread safe.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "server/jobs/live_job.h"
#include "server/jobs/store_errors.h"
#include "server/observe/metrics.h"
#include "server/store/job_store.h"
#include "server/store/signals.h"

namespace meshgauge::server {

class Watcher {
 public:
  struct Options {
    std::chrono::seconds keep{86'400};  // a job that is cancelled here
    // Called with each end that is seen, before any client hears of it; quick.
    std::function<void(const LiveJob&, const store::Job& row)> ended = nullptr;
  };

  // Borrows all but the options.
  Watcher(store::JobStore& jobs, StoreErrors& store_errors, Metrics& metrics, Options options);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  void hear(const store::Signal& signal);

  // A job of this process that is not in the store: found by watch(), and read from the store after begin(). A durable
  // one is then followed to its end, with or without clients, since it holds places.
  void expect(const std::shared_ptr<LiveJob>& job);
  void begin(const std::shared_ptr<LiveJob>& job);
  void forget(const LiveJob& job);
  // The job if it was expected, is not in the store, and is never promised to be; else null.
  std::shared_ptr<LiveJob> unstored(const store::JobKey& key) const;

  // The job of a row that was just read and had not ended, one for all clients. Null after stop().
  std::shared_ptr<LiveJob> watch(const store::Job& row);
  // The same of a durable job of before this start, which holds these places.
  void adopt(const store::Job& row, Scheduler::Slot slot, JobSlot counted);

  // No client waits for it any more: asks the store to end it, again and again until its time is over.
  void leave(const std::shared_ptr<LiveJob>& job);

  // Queued jobs run after the next start: lets go of them, and of those that go back to the queue.
  void drain();
  // Lets go of all: tells their clients that this process stops. Asks the store to end what is not durable.
  void stop();

  std::size_t queued() const;  // durable jobs that are followed and wait to be run

 private:
  struct Watched {
    std::weak_ptr<LiveJob> job;
    std::shared_ptr<LiveJob> held;  // by the watcher itself
    bool stored = false;
  };
  using Jobs = std::vector<std::shared_ptr<LiveJob>>;

  std::shared_ptr<LiveJob> watch_under_lock(const store::Job& row);
  void release(const std::shared_ptr<LiveJob>& job);
  void watch_on();
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
  const Options options_;
  mutable std::mutex mutex_;                    // guards what follows
  std::map<std::string, Watched> watched_;      // by id
  std::set<std::string> changed_;               // ids of some of them
  std::vector<std::shared_ptr<LiveJob>> left_;  // to be cancelled
  unsigned round_ = 0;                          // of looking at all
  bool missed_ = false;
  bool leaving_ = false;
  bool draining_ = false;
  bool stopped_ = false;
  bool ending_ = false;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace meshgauge::server
