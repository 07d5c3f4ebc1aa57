#include "server/jobs/jobs.h"

#include <utility>

#include "server/jobs/local_runner.h"
#include "server/jobs/remote_runner.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::seconds kMaintenanceInterval{1};

}  // namespace

Jobs::Jobs(const Settings& settings, Compare compare, Stores stores, Access& access, Metrics& metrics)
    : settings_(settings),
      stores_(stores),
      access_(access),
      troubles_(metrics),
      threads_(settings.workers),
      measuring_(settings, std::move(compare), metrics, threads_, stores.jobs),
      scheduler_({settings.workers, settings.workers + settings.queue, settings.max_queued_jobs}),
      upkeep_(settings, stores, troubles_) {
  if (stores.shared()) {
    runner_ = std::make_unique<RemoteRunner>(settings, stores, metrics, troubles_, scheduler_);
  } else {
    runner_ =
        std::make_unique<LocalRunner>(settings, stores, access, metrics, troubles_, measuring_, scheduler_, phase_);
  }
  maintenance_ = std::thread([this] { maintain(); });
}

Jobs::~Jobs() {
  stop();
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  maintenance_.join();
  scheduler_.end();
  runner_.reset();
  troubles_.note(stores_.jobs.flush());
}

void Jobs::drain() {
  phase_.draining.store(true);
  runner_->drain();
}

void Jobs::stop() {
  drain();
  phase_.stopping.store(true);
  scheduler_.cancel_all();
  runner_->stop();
}

Result<std::optional<JobView>> Jobs::get(const store::JobKey& key) {
  if (const auto job = live(key)) return std::optional(job->view());
  auto row = stores_.jobs.get(key);
  if (!row) return row.error();
  if (!*row) return std::optional<JobView>();
  JobView view;
  view.row = std::move(**row);
  return std::optional(std::move(view));
}

std::shared_ptr<LiveJob> Jobs::live(const store::JobKey& key) const { return runner_->here(key); }

Result<Jobs::Deleted> Jobs::remove(const store::JobKey& key) {
  const auto job = get(key);
  if (!job) return job.error();
  if (!*job) return Deleted::unknown;
  if (store::has_ended((*job)->row.state)) return forget(key);
  const auto cancelled = runner_->cancel((*job)->row);
  if (!cancelled) return cancelled.error();
  return *cancelled ? Deleted::asked_to_end : Deleted::unknown;
}

Result<Jobs::Deleted> Jobs::forget(const store::JobKey& key) {
  const auto forgotten = stores_.jobs.forget(key);
  if (!forgotten) return forgotten.error();
  if (stores_.maps) stores_.maps->forget(key);
  return Deleted::forgotten;
}

void Jobs::maintain() {
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kMaintenanceInterval, [&] { return ending_; })) {
    lock.unlock();
    runner_->tick();
    upkeep_.tick();
    lock.lock();
  }
}

}  // namespace meshgauge::server
