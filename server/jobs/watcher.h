// Jobs that others work on, as they go: what clients of this process wait for or watch. Fed by signals, and by looking
// at all of them once a second.
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
#include "server/jobs/troubles.h"
#include "server/observe/metrics.h"
#include "server/store/job_store.h"
#include "server/store/signals.h"

namespace meshgauge::server {

class Watcher {
 public:
  struct Options {
    std::chrono::seconds keep{86'400};                    // a job that is cancelled here
    std::function<void(const LiveJob&)> ended = nullptr;  // told of each end that is seen; quick
  };

  // Borrows all but the options. Listens until its end.
  Watcher(store::JobStore& jobs, store::Signals& signals, Troubles& troubles, Metrics& metrics, Options options);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  // A job of this process that is about to be stored: found by watch(), and looked at from begin() on. One that is
  // durable is followed to its end, whoever waits for it, since it counts among its owner's.
  void expect(const std::shared_ptr<LiveJob>& job);
  void begin(const std::shared_ptr<LiveJob>& job);
  void forget(const LiveJob& job);

  // Of a row that was just read and had not ended. All who ask share one, as long as anybody holds it. Null after
  // stop().
  std::shared_ptr<LiveJob> watch(const store::Job& row);

  // Nobody waits for it any more: asks the store to end it, again and again until its time is over.
  void leave(const std::shared_ptr<LiveJob>& job);

  // Whoever waits is told that this process does not wait any more; what is not durable is to end.
  void stop();

 private:
  struct Watched {
    std::weak_ptr<LiveJob> job;
    std::shared_ptr<LiveJob> held;  // by the watcher itself
    bool stored = false;
  };
  using Jobs = std::vector<std::shared_ptr<LiveJob>>;

  void let_go(const std::shared_ptr<LiveJob>& job);
  void hear(const store::Signal& signal);
  void watch_on();
  Jobs those_changed();
  Jobs all_watched();
  void look_at(const Jobs& jobs);
  void look_at_some(std::span<const std::shared_ptr<LiveJob>> jobs);
  void tell(const std::shared_ptr<LiveJob>& job, const store::Job* row);
  void cancel_left();
  bool cancelled(LiveJob& job);

  store::JobStore& jobs_;
  store::Signals& signals_;
  Troubles& troubles_;
  Metrics& metrics_;
  const Options options_;
  std::mutex mutex_;                            // guards what follows
  std::map<std::string, Watched> watched_;      // by id
  std::set<std::string> changed_;               // ids of some of them
  std::vector<std::shared_ptr<LiveJob>> left_;  // to be cancelled
  unsigned round_ = 0;                          // of looking at all
  bool missed_ = false;
  bool leaving_ = false;
  bool stopped_ = false;
  bool ending_ = false;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace meshgauge::server
