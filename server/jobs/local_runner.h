// Comparisons run in this process: from the scheduler's queue to what is kept of them.
//
//   run -> scheduler -> (durable: claim) -> measure -> (durable: finish; else: record)
//
// Jobs of batches are claimed from the store by a worker of this process, a few at a time, and share its scheduler with
// all others. A durable job that the store cannot let begin, or whose end it cannot take, is parked and tried again.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/access/access.h"
#include "server/jobs/live_jobs.h"
#include "server/jobs/measuring.h"
#include "server/jobs/runner.h"
#include "server/jobs/stores.h"
#include "server/jobs/troubles.h"
#include "server/worker/worker.h"

namespace meshgauge::server {

class LocalRunner final : public Runner {
 public:
  // Borrows all but the first. The scheduler must have ended before this goes, and go after it.
  LocalRunner(const Settings& settings, Stores stores, Access& access, Metrics& metrics, Troubles& troubles,
              const Measuring& measuring, Scheduler& scheduler, const Phase& phase);
  ~LocalRunner() override;

  Result<Done> recover() override;
  Result<Done> available() const override { return Done{}; }
  std::optional<Scheduler::Slot> admit(Scheduler::Kind kind) override { return scheduler_.admit(kind); }
  Scheduler::Figures figures() const override { return scheduler_.figures(); }
  std::chrono::milliseconds expected_wait() const override { return scheduler_.expected_wait(); }
  Queue store_queue() const override { return {}; }
  bool stores_all() const override { return false; }
  void expect(const std::shared_ptr<LiveJob>& job) override { live_.add(job); }
  void forget(const LiveJob& job) override { live_.remove(job); }
  void run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) override;
  std::shared_ptr<LiveJob> here(const store::JobKey& key) const override { return live_.find(key); }
  std::shared_ptr<LiveJob> watch(const store::Job& row) override { return live_.find(row.key); }
  Result<bool> cancel(const store::Job& row) override;
  bool abandon(const std::shared_ptr<LiveJob>& job) override;
  std::optional<api::Problem> give_up(const LiveJob&) const override { return std::nullopt; }
  void look() override;
  void tick() override { retry_parked(); }
  void drain() override;
  void stop() override;

 private:
  // A job that waits for the store, to begin (without `last`) or to end.
  struct Parked {
    std::shared_ptr<LiveJob> job;
    std::optional<Scheduler::Slot> slot;
    std::optional<JobView> last;
    bool cut_short = false;  // it was cancelled, by whomever
  };
  enum class Begun { yes, not_ours, later };

  void work(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot);
  Begun begin(LiveJob& job);
  bool is_queued(const LiveJob& job);
  void conclude(Parked ended);
  void drop(LiveJob& job);
  void leave_to_its_end(LiveJob& job);
  void park(Parked parked);
  void retry_parked();

  const Settings settings_;
  const Stores stores_;
  Access& access_;
  Metrics& metrics_;
  Troubles& troubles_;
  const Measuring& measuring_;
  Scheduler& scheduler_;
  const Phase& phase_;
  const std::string worker_;  // this process, in tokens
  LiveJobs live_;
  std::mutex mutex_;            // guards what follows
  std::vector<Parked> parked_;  // what the store could not be told yet
  std::optional<Worker> batches_;
};

}  // namespace meshgauge::server
