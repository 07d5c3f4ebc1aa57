#include "server/jobs/jobs.h"

#include <utility>

#include "api/digest.h"
#include "server/base/heap.h"
#include "server/settings/memory_plan.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::JobState;

constexpr seconds kMaintenanceInterval{1};
constexpr milliseconds kProgressInterval{100};
constexpr seconds kCancelTime{1};
constexpr milliseconds kUntold{50};  // after the deadline of a queued job: its end may be known a little later
constexpr seconds kLate{5};          // after the deadline of a running job, or while the store is away

// One process uses these stores: it gets every signal, and no other process can take a suspected job.
WorkerOptions embedded_worker() {
  WorkerOptions options;
  options.name = api::random_id();
  options.lease = std::chrono::hours(365L * 24);
  options.progress = kProgressInterval;
  options.poll = seconds(10);
  options.trusted_tries = 2;  // the end of the process loses all running jobs, so one loss means little
  options.pass_over = milliseconds(0);
  return options;
}

}  // namespace

Jobs::Jobs(const Settings& settings, Fetch fetch, Stores stores, Access& access, Metrics& metrics)
    : settings_(settings),
      stores_(stores),
      access_(access),
      metrics_(metrics),
      store_errors_(metrics),
      threads_(settings.workers),
      memory_(memory_for_meshes(settings)),
      measuring_(settings, std::move(fetch), metrics, threads_, memory_, stores.jobs),
      scheduler_({settings.workers, settings.workers + settings.queue, settings.max_queued_jobs}),
      upkeep_(settings, stores, store_errors_),
      watcher_(
          stores.jobs, store_errors_, metrics,
          {seconds(settings.result_ttl_s), [this](const LiveJob& job, const store::Job& row) { ended(job, row); }}) {
  if (stores.shared) {
    queue_.emplace(stores.jobs, store_errors_);
  } else {
    worker_.emplace(settings, stores, measuring_, scheduler_, store_errors_, metrics, embedded_worker());
  }
  stores.signals.listen([this](const store::Signal& signal) {
    watcher_.hear(signal);
    if (worker_) worker_->hear(signal);
  });
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
  stores_.signals.stop_listening();
  scheduler_.end();
  store_errors_.note(stores_.jobs.flush());
}

// Requeues all jobs that were running when the last process ended, whatever their worker.
Result<Done> Jobs::recover() {
  if (!worker_) return Done{};
  const auto now = stores_.jobs.time();
  const auto rows =
      stores_.jobs.recover("", "the service ended while it ran", {now, now + seconds(settings_.result_ttl_s)});
  if (!rows) return rows.error();
  for (const store::Job& row : *rows) {
    watcher_.adopt(row, scheduler_.admit_again(client_of(row)), access_.adopt_job(row.key.owner));
  }
  worker_->start();
  return Done{};
}

void Jobs::drain() {
  draining_.store(true);
  if (!worker_) return;
  worker_->drain();
  watcher_.drain();
}

void Jobs::stop() {
  drain();
  stopping_.store(true);
  scheduler_.cancel_all();
  if (worker_) worker_->stop();
  watcher_.stop();
}

// In the distributed form a durable job holds its slot until it is stored; from then on the store counts it.
std::optional<Scheduler::Slot> Jobs::admit(Kind kind, const std::string& client) {
  return is_full(kind) ? std::nullopt : scheduler_.admit(kind, client);
}

bool Jobs::has_place(Kind kind, const std::string& client) const {
  return !is_full(kind) && scheduler_.has_place(kind, client);
}

bool Jobs::is_full(Kind kind) const {
  return queue_ && kind == Kind::durable && figures().durable_slots >= settings_.max_queued_jobs;
}

Scheduler::Figures Jobs::figures() const {
  Scheduler::Figures figures = scheduler_.figures();
  if (queue_) figures.durable_slots += queue_->unawaited();
  return figures;
}

std::size_t Jobs::waiting() const { return scheduler_.figures().waiting + (worker_ ? watcher_.queued() : 0); }

milliseconds Jobs::expected_wait() const {
  return queue_ ? queue_->expected_wait() : scheduler_.expected_wait(watcher_.queued());
}

void Jobs::run_unstored(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  watcher_.expect(job);
  job->control.set_deadline(job->submitted + job->request.timeout);
  job->control.watch(
      [watched = job.get()](const Progress& p) { watched->progressed(certified(p.lower, p.upper, p.stage)); },
      kProgressInterval);
  scheduler_.submit(std::move(slot),
                    {job->client, job->bytes, job->request.timeout, std::shared_ptr<Control>(job, &job->control),
                     [this, job](Scheduler::Slot held) { measure_unstored(*job, std::move(held)); }});
}

void Jobs::measure_unstored(LiveJob& job, Scheduler::Slot slot) {
  job.started(1, stores_.jobs.time());
  const auto result = measuring_.measured(job);
  end_unstored(job, result, std::move(slot));
}

// Gives the places back before the answer: the client may send the next request at once.
void Jobs::end_unstored(LiveJob& job, const Result<api::Comparison>& result, std::optional<Scheduler::Slot> slot) {
  measuring_.count(job, result);
  JobView last = measuring_.last_view(job, result, stopping_.load());
  release_bytes(job.a);
  release_bytes(job.b);
  job.give_places_back();
  slot.reset();
  stores_.jobs.record(last.row);
  watcher_.forget(job);
  job.ended(std::move(last));
}

Result<std::optional<JobView>> Jobs::get(const store::JobKey& key) {
  if (const auto job = watcher_.unstored(key)) return std::optional(job->view());
  auto row = stores_.jobs.get(key);
  if (!row) return row.error();
  if (!*row) return std::optional<JobView>();
  JobView view;
  view.row = std::move(**row);
  return std::optional(std::move(view));
}

std::shared_ptr<LiveJob> Jobs::watch(const JobView& job) {
  return store::has_ended(job.row.state) ? nullptr : watcher_.watch(job.row);
}

Result<Jobs::Deleted> Jobs::remove(const store::JobKey& key) {
  const auto job = get(key);
  if (!job) return job.error();
  if (!*job) return Deleted::unknown;
  if (store::has_ended((*job)->row.state)) return forget(key);
  const auto cancelled = cancel((*job)->row);
  if (!cancelled) return cancelled.error();
  return *cancelled ? Deleted::asked_to_end : Deleted::unknown;
}

Result<Done> Jobs::cancel(const store::JobKey& key) {
  const auto job = get(key);
  if (!job) return job.error();
  if (!*job || store::has_ended((*job)->row.state)) return Done{};
  const auto cancelled = cancel((*job)->row);
  if (!cancelled) return cancelled.error();
  return Done{};
}

// false: the job no longer exists.
Result<bool> Jobs::cancel(const store::Job& row) {
  const auto job = watcher_.watch(row);
  if (const auto unstored = watcher_.unstored(row.key)) {
    unstored->cancel();
  } else {
    const auto now = stores_.jobs.time();
    const auto state = stores_.jobs.request_cancel(row.key, {now, now + seconds(settings_.result_ttl_s)});
    if (!state) return state.error();
    if (!*state) return false;
    if (**state == JobState::cancelled) {
      const auto request = api::parse_options(row.options, request_limits(settings_));
      metrics_.job_cancelled_early(request ? request->options.strategy : Strategy{});
    }
  }
  if (job) job->wait_for_end(kCancelTime);
  return true;
}

Result<Jobs::Deleted> Jobs::forget(const store::JobKey& key) {
  const auto forgotten = stores_.jobs.forget(key);
  if (!forgotten) return forgotten.error();
  if (stores_.maps) stores_.maps->forget(key);
  return Deleted::forgotten;
}

bool Jobs::abandon(const std::shared_ptr<LiveJob>& job) {
  if (queue_) {
    watcher_.leave(job);
  } else {
    job->control.cancel();
  }
  return queue_.has_value();
}

void Jobs::end_if_over(LiveJob& job) {
  if (queue_ || job.durable) return;
  // Not control.check(): of a job that runs, that is for its own threads.
  const bool over = job.control.cancelled() || LiveJob::Clock::now() >= job.submitted + job.request.timeout;
  if (!over || !scheduler_.withdraw(job.control)) return;
  end_unstored(job, api::in_time(job.control, "a thread was free for it").error(), std::nullopt);
}

// An awaited job ends by its deadline, which its worker keeps; a durable one goes on in any case.
std::optional<Problem> Jobs::give_up(const LiveJob& job) const {
  if (!queue_) return std::nullopt;
  const bool there = queue_->available().ok();
  if (job.durable) {
    if (there || queue_->silence() < job.request.timeout) return std::nullopt;
    return Problem{
        ProblemKind::storage_unavailable, "the store does not answer; the comparison runs when it does again", {}};
  }
  const bool begun = job.view().row.state != JobState::queued;
  const milliseconds late = begun || !there ? kLate : kUntold;
  if (LiveJob::Clock::now() < job.submitted + job.request.timeout + late) return std::nullopt;
  if (!there)
    return Problem{ProblemKind::storage_unavailable,
                   "the store does not answer, and the timeout of the request has passed; send it again later",
                   {}};
  return Problem{ProblemKind::out_of_time, "no worker ended the comparison within the timeout of the request", {}};
}

void Jobs::ended(const LiveJob& job, const store::Job& row) {
  if (!stores_.shared) return release_blobs(stores_, store_errors_, row.key.owner, row.mesh_a, row.mesh_b);
  for (const MeshSource* source : {&job.a, &job.b}) {
    if (!source->id.empty() && !source->kept) upkeep_.remove_unless_used({job.key.owner, source->id});
  }
}

void Jobs::maintain() {
  const NeverFails never_fails;
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kMaintenanceInterval, [&] { return ending_; })) {
    lock.unlock();
    upkeep_.tick();
    lock.lock();
  }
}

}  // namespace meshgauge::server
