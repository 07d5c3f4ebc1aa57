#include "server/jobs/remote_runner.h"

#include <utility>

#include "server/jobs/kept_blobs.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::seconds;
using store::JobState;

constexpr seconds kRemoving{1};  // at a time: who calls has to look after more than meshes
constexpr std::size_t kMostUnneeded = 10'000;
constexpr seconds kCancelTime{1};
constexpr seconds kUntold{1};  // beyond a deadline, for the news of an end that came in time
constexpr seconds kLate{5};    // ... of one that was begun, or while the store is gone

}  // namespace

RemoteRunner::RemoteRunner(const Settings& settings, Stores stores, Metrics& metrics, Troubles& troubles,
                           Scheduler& scheduler)
    : settings_(settings),
      stores_(stores),
      metrics_(metrics),
      troubles_(troubles),
      scheduler_(scheduler),
      queue_(stores.jobs, troubles),
      watcher_(stores.jobs, *stores.signals, troubles, metrics,
               {seconds(settings.result_ttl_s), [this](const LiveJob& job) { ended(job); }}) {}

// The slot of a durable one is held until it is in the store, and counts there from then on.
std::optional<Scheduler::Slot> RemoteRunner::admit(Scheduler::Kind kind) {
  const bool full = kind == Scheduler::Kind::durable && figures().durable_slots >= settings_.max_queued_jobs;
  return full ? std::nullopt : scheduler_.admit(kind);
}

Scheduler::Figures RemoteRunner::figures() const {
  Scheduler::Figures figures = scheduler_.figures();
  figures.durable_slots += queue_.unawaited();
  return figures;
}

void RemoteRunner::run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  if (job->durable) queue_.added();
  if (slot.kind() == Scheduler::Kind::awaited) job->hold_place(std::move(slot));
  watcher_.begin(job);
}

std::shared_ptr<LiveJob> RemoteRunner::watch(const store::Job& row) {
  return store::has_ended(row.state) ? nullptr : watcher_.watch(row);
}

Result<bool> RemoteRunner::cancel(const store::Job& row) {
  const auto now = stores_.jobs.time();
  const auto state = stores_.jobs.request_cancel(row.key, {now, now + seconds(settings_.result_ttl_s)});
  if (!state) return state.error();
  if (!*state) return false;
  if (**state == JobState::cancelled) {
    const auto request = api::parse_options(row.options, request_limits(settings_));
    metrics_.job_cancelled_early(request ? request->options.strategy : Strategy{});
  }
  if (**state != JobState::running) return true;
  if (const auto job = watcher_.watch(row)) job->wait_for_end(kCancelTime);
  return true;
}

bool RemoteRunner::abandon(const std::shared_ptr<LiveJob>& job) {
  watcher_.leave(job);
  return true;
}

// The end of an awaited job is its deadline, which its worker keeps; a durable one goes on in any case.
std::optional<Problem> RemoteRunner::give_up(const LiveJob& job) const {
  const bool there = queue_.available().ok();
  if (job.durable) {
    if (there || queue_.silence() < job.request.timeout) return std::nullopt;
    return Problem{
        ProblemKind::storage_unavailable, "the store is out of order; the comparison runs when it is back", {}};
  }
  const bool begun = job.view().row.state != JobState::queued;
  const auto late = begun || !there ? kLate : kUntold;
  if (LiveJob::Clock::now() < job.submitted + job.request.timeout + late) return std::nullopt;
  if (!there) return Problem{ProblemKind::storage_unavailable, "the store is out of order, and the time is over", {}};
  return Problem{ProblemKind::out_of_time, "the time was over before a worker was through", {}};
}

void RemoteRunner::ended(const LiveJob& job) {
  const std::lock_guard lock(mutex_);
  for (const MeshSource* source : {&job.a, &job.b}) {
    if (!source->id.empty() && !source->kept) unneeded_.push_back({job.key.owner, source->id});
  }
  while (unneeded_.size() > kMostUnneeded) unneeded_.pop_front();
}

// What the store is not there to be asked about, and the oldest of what comes faster than it goes, is for a sweep.
void RemoteRunner::tick() {
  const auto until = LiveJob::Clock::now() + kRemoving;
  while (LiveJob::Clock::now() < until) {
    store::BlobKey key;
    {
      const std::lock_guard lock(mutex_);
      if (unneeded_.empty()) return;
      key = std::move(unneeded_.front());
      unneeded_.pop_front();
    }
    const auto removed = remove_if_unreferenced(stores_, key);
    troubles_.note(removed);
    if (removed) continue;
    const std::lock_guard lock(mutex_);
    return unneeded_.clear();
  }
}

}  // namespace meshgauge::server
