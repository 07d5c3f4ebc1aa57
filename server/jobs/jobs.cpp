#include "server/jobs/jobs.h"

#include <algorithm>
#include <cassert>
#include <exception>
#include <utility>

#include "api/digest.h"
#include "api/response.h"
#include "server/jobs/job_document.h"
#include "server/log.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using store::JobState;

constexpr milliseconds kProgressInterval{100};
constexpr seconds kRetryInterval{1};
constexpr seconds kSweepInterval{30};
constexpr seconds kCancelTime{1};
constexpr seconds kTroubleInterval{10};
constexpr seconds kUnusedBlobs{600};         // longer than any upload takes from its bytes to its row
constexpr seconds kLease{365L * 24 * 3600};  // one process works on these stores: it is alive, or recover() knows

StoreFailure failure_of(ErrorCode code) {
  if (code == ErrorCode::storage_full) return StoreFailure::full;
  return code == ErrorCode::storage_unavailable ? StoreFailure::unavailable : StoreFailure::broken;
}

}  // namespace

Jobs::Jobs(const Settings& settings, Compare compare, Stores stores, Access& access, Metrics& metrics)
    : settings_(settings),
      stores_(stores),
      access_(access),
      metrics_(metrics),
      worker_(api::random_id()),
      threads_(settings.workers),
      measuring_(settings, std::move(compare), metrics, threads_, stores.jobs),
      scheduler_({settings.workers, settings.workers + settings.queue, settings.max_queued_jobs}) {
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
  for (const Parked& parked : parked_) drop(*parked.job);
  parked_.clear();  // their slots are the scheduler's, which goes first
  note(stores_.jobs.flush());
}

void Jobs::stop() {
  drain();
  stopping_.store(true);
  scheduler_.cancel_all();
}

void Jobs::register_live(const std::shared_ptr<LiveJob>& job) {
  const std::lock_guard lock(mutex_);
  live_[job->key.id] = job;
}

void Jobs::forget_live(const LiveJob& job) {
  const std::lock_guard lock(mutex_);
  live_.erase(job.key.id);
}

std::shared_ptr<LiveJob> Jobs::live(const store::JobKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = live_.find(key.id);
  return found != live_.end() && found->second->key == key ? found->second : nullptr;
}

void Jobs::enqueue(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  job->control.set_deadline(job->submitted + job->request.timeout);
  job->control.watch(
      [watched = job.get()](const Progress& p) {
        watched->progressed({p.lower, p.upper, p.stage});
      },
      kProgressInterval);
  scheduler_.submit(std::move(slot),
                    {job->key.owner, job->bytes, job->request.timeout, std::shared_ptr<Control>(job, &job->control),
                     [this, job](Scheduler::Slot held) { run(job, std::move(held)); }});
}

void Jobs::run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  if (job->durable) {
    const Begun begun = begin(*job);
    if (begun != Begun::yes) {
      let_go_of_bytes(job->a);
      let_go_of_bytes(job->b);
    }
    if (begun == Begun::later) return park({job, std::move(slot), std::nullopt});
    if (begun == Begun::not_ours) return leave_to_its_end(*job);
  } else {
    job->started(1, store::now());
  }
  const auto result = measuring_.measured(*job);
  measuring_.count(*job, result);
  JobView last = measuring_.told(*job, result, stopping_.load());
  let_go_of_bytes(job->a);
  let_go_of_bytes(job->b);
  job->counted.reset();
  { const Scheduler::Slot done = std::move(slot); }
  conclude({job, std::nullopt, std::move(last), stopped_by_cancel(result)});
}

// queued -> running in the store. The time of a job that nobody need wait for begins here: it may have been in the
// queue for long, or the store out of order.
Jobs::Begun Jobs::begin(LiveJob& job) {
  if (draining_.load()) return Begun::not_ours;
  const auto opened = open_blobs(job);
  note(opened);
  if (!opened) return is_queued(job) ? Begun::later : Begun::not_ours;
  const auto now = store::now();
  auto claimed = stores_.jobs.claim(job.key, worker_, now, now + kLease);
  note(claimed);
  if (!claimed) return Begun::later;
  if (!*claimed) return Begun::not_ours;
  job.token = (*claimed)->token;
  job.started((*claimed)->job.tries, now);
  job.control.set_deadline(LiveJob::Clock::now() + job.request.timeout);
  return Begun::yes;
}

// False: it was cancelled or given up meanwhile. A job whose blob stays unreadable must not be tried for ever.
bool Jobs::is_queued(const LiveJob& job) {
  const auto row = stores_.jobs.get(job.key);
  return !row || (*row && !store::has_ended((*row)->state));
}

// While a durable job waits it holds neither memory nor descriptors: its bytes are in the store. What is not there any
// more is left without a holder.
Result<Done> Jobs::open_blobs(LiveJob& job) {
  for (MeshSource* source : {&job.a, &job.b}) {
    auto blob = stores_.blobs.open({job.key.owner, source->id});
    if (!blob) return blob.error();
    if (*blob) hold_bytes(*source, std::move(**blob));
  }
  return Done{};
}

// Whatever ends a durable job that nobody asked to end is the end of this process: another one will run it.
void Jobs::conclude(Parked ended) {
  LiveJob& job = *ended.job;
  const store::Job& row = ended.last->row;
  const bool interrupted = stopping_.load() && ended.cut_short && !row.cancel_requested;
  if (job.durable && interrupted) {
    if (row.progress) note(stores_.jobs.heartbeat(*job.token, store::now() + kLease, *row.progress));
    note(stores_.jobs.hand_back(*job.token, "", {store::now(), *row.expires}));
    return drop(job);
  }
  if (!job.durable) {
    stores_.jobs.record(row);
  } else {
    const auto stored = stores_.jobs.finish(*job.token, {row.state, row.document, row.problem, *row.finished,
                                                         *row.expires, row.verdict, ended.last->reusable});
    note(stored);
    if (!stored) return park(std::move(ended));
    if (!*stored) log_event("store", "job " + job.key.id + " was taken over by another worker");
    release_blobs(job.key.owner, job.a.id, job.b.id);
  }
  forget_live(job);
  job.ended(std::move(*ended.last));
}

// A failure of the store is counted and told, whatever becomes of it; the same one not again and again.
void Jobs::failed(const Error& error) {
  metrics_.store_failed(failure_of(error.code));
  const std::string& message = error.message;
  {
    const auto now = LiveJob::Clock::now();
    const std::lock_guard lock(mutex_);
    if (message == trouble_ && now - trouble_told_ < kTroubleInterval) return;
    trouble_ = message;
    trouble_told_ = now;
  }
  log_event("store", message);
}

// This process will not run it: the next one finds it in the store.
void Jobs::drop(LiveJob& job) {
  forget_live(job);
  job.handed_back();
}

// Of a job that was not to be claimed: it has ended by itself, or this process stops.
void Jobs::leave_to_its_end(LiveJob& job) {
  const auto row = stores_.jobs.get(job.key);
  if (!row || !*row || !store::has_ended((*row)->state)) return drop(job);
  release_blobs(job.key.owner, (*row)->mesh_a, (*row)->mesh_b);
  JobView last;
  last.row = **row;
  forget_live(job);
  job.ended(std::move(last));
}

void Jobs::park(Parked parked) {
  if (stopping_.load()) return drop(*parked.job);
  if (!std::exchange(parked.job->has_waited, true)) {
    log_event("store", "job " + parked.job->key.id + " waits for the store");
  }
  const std::lock_guard lock(mutex_);
  parked_.push_back(std::move(parked));
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

// What runs here hears of it before the disk does.
Result<Jobs::Deleted> Jobs::remove(const store::JobKey& key) {
  const auto job = live(key);
  if (job) job->cancel();
  if (!job || job->durable) {
    const auto now = store::now();
    const auto state = stores_.jobs.request_cancel(key, {now, now + seconds(settings_.result_ttl_s)});
    if (!state) return state.error();
    if (!*state) return Deleted::unknown;
    if (job && **state == JobState::cancelled) {
      // Else its worker was quicker, and has counted it.
      if (job->view().row.state == JobState::queued) metrics_.job_cancelled_early(job->request.options.strategy);
      leave_to_its_end(*job);
      scheduler_.withdraw(job->control);
    } else if (store::has_ended(**state)) {
      const auto forgotten = stores_.jobs.forget(key);
      if (!forgotten) return forgotten.error();
      if (stores_.maps) stores_.maps->forget(key);
      return Deleted::forgotten;
    }
  }
  if (job) job->wait_for_end(kCancelTime);
  return Deleted::asked_to_end;
}

void Jobs::maintain() {
  auto next_sweep = LiveJob::Clock::now();  // soon: a service that is killed again and again is to sweep as well
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kRetryInterval, [&] { return ending_; })) {
    lock.unlock();
    retry_parked();
    if (LiveJob::Clock::now() >= next_sweep) {
      sweep();
      next_sweep = LiveJob::Clock::now() + kSweepInterval;
    }
    lock.lock();
  }
}

void Jobs::retry_parked() {
  {
    const std::lock_guard lock(mutex_);
    if (parked_.empty()) return;
  }
  if (!stopping_.load()) {  // else they are dropped, whatever the store says
    const auto written = stores_.jobs.check();
    note(written);
    if (!written) return;
  }
  std::vector<Parked> parked;
  {
    const std::lock_guard lock(mutex_);
    parked.swap(parked_);
  }
  for (Parked& waiting : parked) {
    if (waiting.last) {
      conclude(std::move(waiting));
    } else {
      enqueue(waiting.job, std::move(*waiting.slot));
    }
  }
}

// What is thrown for want of memory ends here: it is for the next sweep, not the end of the process.
void Jobs::sweep() try {
  const auto now = store::now();
  const auto swept = stores_.jobs.sweep_jobs({now, now + seconds(settings_.result_ttl_s)}, settings_.max_kept_results);
  note(swept);
  if (stores_.maps && swept) {
    stores_.maps->sweep([this](const store::JobKey& key) {
      const auto row = stores_.jobs.get(key);
      return !row || *row;
    });
  }
  note(stores_.meshes.sweep_meshes(now));
  const auto used = stores_.jobs.used_blobs();
  note(used);
  if (used) note(stores_.blobs.remove_unused(*used, kUnusedBlobs));
} catch (const std::exception& error) {
  log_event("store", std::string("a sweep was broken off: ") + error.what());
}

}  // namespace meshgauge::server
