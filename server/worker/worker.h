// Runs the jobs of a store: in the process of `serve` in the embedded form, in processes of their own in the
// distributed form.
//
//   claim_some -> ClaimBuffer (blobs are opened) -> Scheduler -> Measuring -> PendingResults (finish_all)
//
// Sends heartbeats for all jobs that it holds, and learns by them which to cancel and which it has lost. While the
// store is away it runs the jobs that it holds, and stores their ends afterwards. It runs only jobs that it has
// claimed, and every write names the token of its claim.
//
// Thread safe.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/base/threads.h"
#include "server/measure/measuring.h"
#include "server/measure/scheduler.h"
#include "server/measure/stores.h"
#include "server/observe/metrics.h"
#include "server/settings/settings.h"
#include "server/worker/claim_buffer.h"
#include "server/worker/pending_results.h"

namespace meshgauge::server {

struct WorkerOptions {
  std::string name;                         // unique, also among past and future processes
  std::chrono::milliseconds lease{75'000};  // without a heartbeat for so long, its jobs are requeued
  std::chrono::milliseconds heartbeat{10'000};
  std::chrono::milliseconds progress{500};  // least time between two reports of a job's progress
  std::chrono::milliseconds poll{1'000};    // interval of claims without a signal
  // A suspected job with more tries than this runs alone.
  unsigned trusted_tries = 1;
  std::chrono::milliseconds pass_over{30'000};  // how long a busy worker passes over suspected jobs
  std::size_t openers = 2;                      // threads that open blobs before jobs run
  // Logs each end that the store has taken, if Settings::log_requests asks for it.
  bool log_jobs = false;
};

class Worker final : private PendingResults::Listener {
 public:
  // Borrows all but settings and options. The scheduler must end after the worker.
  Worker(const Settings& settings, const Stores& stores, const Measuring& measuring, Scheduler& scheduler,
         StoreErrors& store_errors, Metrics& metrics, WorkerOptions options);
  ~Worker() override;  // as stop()
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void start();  // call it once
  void wake();   // claims soon: jobs may be queued, or the store may be back. Does not block
  void hear(const store::Signal& signal);

  // Cancels a job that is held here, whether a thread runs it or not; remembers another key in case its claim is under
  // way.
  void cancel(const store::JobKey& key);

  void drain();  // stops claiming, and hands back jobs that have not begun
  // Drains, cancels running jobs, hands them back with the interval reached, and blocks until that is stored, at most
  // `timeout`. The store requeues jobs that it was not told of when their leases expire. Logs the jobs that were handed
  // back since drain().
  void stop(std::chrono::milliseconds timeout = std::chrono::seconds(5));

  std::size_t running() const;  // jobs that have begun
  std::size_t held() const;     // jobs that are claimed and not yet stored
  std::size_t deliveries_waiting() const { return results_.waiting(); }

 private:
  using Clock = LiveJob::Clock;

  void tell_end();
  void claim_in_background();
  struct Claim {
    std::size_t most = 0;
    store::JobStore::Suspects suspects = store::JobStore::Suspects::passed_over;
    store::JobStore::Clients clients = store::JobStore::Clients::all;
  };
  Claim next_claim();
  void claim(const Claim& what);
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
  void cancel(const HeldJobPtr& job);
  void end(const HeldJobPtr& job, const Result<api::Comparison>& result);
  void free_thread(const HeldJob& job);
  void conclude(const HeldJobPtr& job, const Result<api::Comparison>& result);
  void withdraw(const HeldJobPtr& job);
  void leave(PendingResult delivery);
  void delivered(const PendingResult& delivery, PendingResults::Outcome outcome) override;
  void failed(const Error& error) override;

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

  mutable std::mutex mutex_;  // guards the members below, down to ending_
  std::condition_variable claim_wake_;
  std::condition_variable open_wake_;
  std::condition_variable keep_wake_;
  std::condition_variable idle_;
  ClaimBuffer buffer_;
  std::vector<HeldJobPtr> held_;         // all
  std::deque<store::JobKey> cancelled_;  // newest keys of jobs that are not held
  std::size_t given_ = 0;                // number of jobs in the scheduler
  Clock::time_point next_claim_{};
  Clock::time_point asked_for_suspects_{};  // time of the newest claim with suspects
  bool claiming_ = false;                   // a claim is under way, or it is unknown whether one was stored
  bool look_again_ = false;                 // wake() was called since the claim began
  std::chrono::milliseconds claim_pause_{0};
  bool draining_ = false;
  std::vector<std::string> handed_back_;  // ids of jobs handed back since drain()
  bool ending_ = false;

  std::uint64_t claims_ = 0;         // used by the claiming thread alone
  std::vector<std::string> unsure_;  // used by the claiming thread alone: names of claims that may have been stored

  PendingResults results_;
  Threads threads_;
};

}  // namespace meshgauge::server
