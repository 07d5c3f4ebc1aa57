// Comparisons run by workers that share this process's stores: all go through the store's queue, awaited ones with a
// deadline, and are watched until their end. The scheduler here counts the clients that wait.
//
// Meshes that came with a comparison are removed soon after its end, unless something else refers to them.
#pragma once

#include <deque>
#include <mutex>

#include "server/jobs/runner.h"
#include "server/jobs/store_queue.h"
#include "server/jobs/stores.h"
#include "server/jobs/troubles.h"
#include "server/jobs/watcher.h"
#include "server/settings.h"

namespace meshgauge::server {

class RemoteRunner final : public Runner {
 public:
  // Borrows all but the first. Precondition: stores.shared().
  RemoteRunner(const Settings& settings, Stores stores, Metrics& metrics, Troubles& troubles, Scheduler& scheduler);

  Result<Done> recover() override { return Done{}; }
  Result<Done> available() const override { return queue_.available(); }
  std::optional<Scheduler::Slot> admit(Scheduler::Kind kind) override;
  Scheduler::Figures figures() const override;
  std::chrono::milliseconds expected_wait() const override { return queue_.expected_wait(); }
  Queue store_queue() const override { return {queue_.counts().queued, queue_.oldest_waiting_seconds()}; }
  bool stores_all() const override { return true; }
  void expect(const std::shared_ptr<LiveJob>& job) override { watcher_.expect(job); }
  void forget(const LiveJob& job) override { watcher_.forget(job); }
  void run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) override;
  std::shared_ptr<LiveJob> here(const store::JobKey&) const override { return nullptr; }
  std::shared_ptr<LiveJob> watch(const store::Job& row) override;
  Result<bool> cancel(const store::Job& row) override;
  bool abandon(const std::shared_ptr<LiveJob>& job) override;
  std::optional<api::Problem> give_up(const LiveJob& job) const override;
  void look() override {}  // the store tells the workers
  void tick() override;
  void drain() override {}
  void stop() override { watcher_.stop(); }

 private:
  void ended(const LiveJob& job);

  const Settings settings_;
  const Stores stores_;
  Metrics& metrics_;
  Troubles& troubles_;
  Scheduler& scheduler_;
  std::mutex mutex_;                     // guards what follows
  std::deque<store::BlobKey> unneeded_;  // by what has ended here
  StoreQueue queue_;
  Watcher watcher_;
};

}  // namespace meshgauge::server
