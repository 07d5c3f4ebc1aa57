// Runs the jobs of a store: `serve`'s own in the embedded form, and one process of several in the distributed form.
//
//   claim_some -> stock (meshes are looked up) -> scheduler -> Measuring -> deliveries (finish_all)
//
// Whatever it holds it tells the store that it is alive, and hears from it whom to cancel and what it has lost. While
// the store is away it goes on with what it holds, and delivers that afterwards. It never runs a job that it has not
// claimed, and whatever it writes names the token of its claim.
//
// Thread safe.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/jobs/measuring.h"
#include "server/jobs/scheduler.h"
#include "server/jobs/store_errors.h"
#include "server/jobs/stores.h"
#include "server/observe/metrics.h"
#include "server/settings.h"
#include "server/worker/claim_buffer.h"
#include "server/worker/held_job.h"
#include "server/worker/pending_results.h"

namespace meshgauge::server {

struct WorkerOptions {
  std::string name;                         // of this process alone, now and later
  std::chrono::milliseconds lease{75'000};  // after which others may take what it holds and says nothing of
  std::chrono::milliseconds heartbeat{10'000};
  std::chrono::milliseconds progress{500};  // at least between two tellings of how far a job is
  std::chrono::milliseconds poll{1'000};    // how often it looks for jobs that nobody told it of
  // A suspected job runs alone once it was begun more often than this. Another process may take it before.
  unsigned trusted_tries = 1;
  std::chrono::milliseconds pass_over{30'000};          // how long it passes suspected jobs over while it is never idle
  std::size_t openers = 2;                              // threads that look up meshes before jobs run
  std::function<void(const JobView&)> ended = nullptr;  // told of each end that the store has taken
};

class Worker {
 public:
  // Borrows all but settings and options. The scheduler must outlive the worker, and end after it.
  Worker(const Settings& settings, Stores stores, const Measuring& measuring, Scheduler& scheduler,
         StoreErrors& store_errors, Metrics& metrics, WorkerOptions options);
  ~Worker();  // as stop()
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void start();  // once
  void wake();   // there may be something to claim, or the store may be back again; quick
  void hear(const store::Signal& signal);

  // Of a job that runs here or waits to; else nothing, until it is claimed within the next moments.
  void cancel(const store::JobKey& key);

  void drain();  // claims no more, and hands back what has not begun
  // Drains, cancels what runs, hands it back with the interval that it has reached, and waits until the store knows:
  // at most `timeout`, if the store does not answer. What it is not told by then it finds when the lease is over. Logs
  // which jobs went back since drain().
  void stop(std::chrono::milliseconds timeout = std::chrono::seconds(5));

  std::size_t running() const;  // that have begun
  std::size_t held() const;     // claimed, and not yet delivered
  std::size_t deliveries_waiting() const { return results_.waiting(); }

 private:
  using Clock = LiveJob::Clock;

  void claim_in_background();
  void claim(std::size_t most, store::JobStore::Suspects suspects);
  store::JobStore::Suspects suspects_now();
  bool take_back_unsure();
  void adopt(const std::vector<HeldJobPtr>& claimed);
  HeldJobPtr held_of(const store::Claimed& claimed) const;

  void open_in_background();
  void open(const HeldJobPtr& job);
  std::optional<Error> look_up(LiveJob& job);

  void begin_what_can();
  void submit(const HeldJobPtr& job);
  void run(const HeldJobPtr& job, Scheduler::Slot slot);
  bool begin(HeldJob& job);
  void conclude(const HeldJobPtr& job, const Result<api::Comparison>& result);
  void withdraw(const HeldJobPtr& job);
  void leave(PendingResult delivery);
  void delivered(const PendingResult& delivery, PendingResults::Outcome outcome);

  void keep_in_background();
  struct Telling {
    std::vector<HeldJobPtr> jobs;
    std::vector<store::Beat> beats;
  };
  std::map<std::string, Telling> due(bool everything);
  bool tell(const std::map<std::string, Telling>& due);
  void hear(const HeldJobPtr& job, const store::Beat& beat, store::Heartbeat heard);

  const Settings settings_;
  const Stores stores_;
  const Measuring& measuring_;
  Scheduler& scheduler_;
  Metrics& metrics_;
  const WorkerOptions options_;
  StoreErrors& store_errors_;

  mutable std::mutex mutex_;  // guards what follows, but the deliveries
  std::condition_variable claim_wake_;
  std::condition_variable open_wake_;
  std::condition_variable keep_wake_;
  std::condition_variable idle_;
  ClaimBuffer buffer_;
  std::vector<HeldJobPtr> held_;         // all
  std::deque<store::JobKey> cancelled_;  // the newest of those that are not held
  std::size_t given_ = 0;                // to the scheduler, and not through
  Clock::time_point next_claim_{};
  Clock::time_point asked_for_suspects_{};  // when it last did
  bool claiming_ = false;                   // a claim is under way, or it is not known whether it was stored
  bool look_again_ = false;                 // something happened since it began
  std::chrono::milliseconds claim_pause_{0};
  bool draining_ = false;
  std::vector<std::string> handed_back_;  // since it drains: ids of jobs that the store has back
  bool ending_ = false;

  std::uint64_t claims_ = 0;         // the claiming thread's
  std::vector<std::string> unsure_;  // likewise: names under which jobs may have been claimed without our knowledge

  PendingResults results_;
  std::vector<std::thread> threads_;
};

}  // namespace meshgauge::server
