#include "server/jobs/local_runner.h"

#include <utility>

#include "api/digest.h"
#include "server/jobs/kept_blobs.h"
#include "server/jobs/revived.h"
#include "server/log.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using store::JobState;

constexpr milliseconds kProgressInterval{100};
constexpr seconds kCancelTime{1};
constexpr seconds kLease{365L * 24 * 3600};  // one process works on these stores: it is alive, or recover() knows
constexpr milliseconds kLook{500};           // for batches that were cancelled
constexpr seconds kPoll{10};                 // for what look() did not tell of

}  // namespace

LocalRunner::LocalRunner(const Settings& settings, Stores stores, Access& access, Metrics& metrics, Troubles& troubles,
                         const Measuring& measuring, Scheduler& scheduler, const Phase& phase)
    : settings_(settings),
      stores_(stores),
      access_(access),
      metrics_(metrics),
      troubles_(troubles),
      measuring_(measuring),
      scheduler_(scheduler),
      phase_(phase),
      worker_(api::random_id()) {
  if (!stores.batches) return;
  WorkerOptions options;
  options.name = worker_ + "-batches";
  options.lease = kLease;
  options.heartbeat = kLook;
  options.poll = kPoll;
  options.which = store::JobStore::Which::of_batches;
  // Without the accounts of owners: a batch does not count among their jobs.
  batches_.emplace(settings, stores, measuring, scheduler, nullptr, metrics, std::move(options));
}

LocalRunner::~LocalRunner() {
  for (const Parked& parked : parked_) drop(*parked.job);
}

Result<Done> LocalRunner::recover() {
  const auto now = stores_.jobs.time();
  auto rows = stores_.jobs.recover("", "the service ended while it ran", {now, now + seconds(settings_.result_ttl_s)});
  if (!rows) return rows.error();
  for (const store::Job& row : *rows) {
    const auto job = revived(row, settings_, stores_.meshes);
    if (!job) return job.error();
    (*job)->counted.emplace(access_.adopt_job(row.key.owner));
    run(*job, scheduler_.admit_again());
  }
  if (batches_) batches_->start();
  return Done{};
}

void LocalRunner::look() {
  if (batches_) batches_->wake();
}

void LocalRunner::drain() {
  if (batches_) batches_->drain();
}

void LocalRunner::stop() {
  if (batches_) batches_->stop();
}

void LocalRunner::run(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  live_.add(job);
  job->control.set_deadline(job->submitted + job->request.timeout);
  job->control.watch(
      [watched = job.get()](const Progress& p) { watched->progressed(certified(p.lower, p.upper, p.stage)); },
      kProgressInterval);
  scheduler_.submit(std::move(slot),
                    {job->key.owner, job->bytes, job->request.timeout, std::shared_ptr<Control>(job, &job->control),
                     [this, job](Scheduler::Slot held) { work(job, std::move(held)); }});
}

void LocalRunner::work(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  if (job->durable) {
    const Begun begun = begin(*job);
    if (begun != Begun::yes) {
      let_go_of_bytes(job->a);
      let_go_of_bytes(job->b);
    }
    if (begun == Begun::later) return park({job, std::move(slot), std::nullopt});
    if (begun == Begun::not_ours) return leave_to_its_end(*job);
  } else {
    job->started(1, stores_.jobs.time());
  }
  const auto result = measuring_.measured(*job);
  measuring_.count(*job, result);
  JobView last = measuring_.told(*job, result, phase_.stopping.load());
  let_go_of_bytes(job->a);
  let_go_of_bytes(job->b);
  job->counted.reset();
  { const Scheduler::Slot done = std::move(slot); }
  conclude({job, std::nullopt, std::move(last), stopped_by_cancel(result)});
}

// queued -> running in the store. The time of a job that nobody need wait for begins here: it may have been in the
// queue for long, or the store out of order.
LocalRunner::Begun LocalRunner::begin(LiveJob& job) {
  if (phase_.draining.load()) return Begun::not_ours;
  const auto opened = open_blobs(job, stores_.blobs);
  troubles_.note(opened);
  if (!opened) return is_queued(job) ? Begun::later : Begun::not_ours;
  const auto now = stores_.jobs.time();
  auto claimed = stores_.jobs.claim(job.key, worker_, now, now + kLease);
  troubles_.note(claimed);
  if (!claimed) return Begun::later;
  if (!*claimed) return Begun::not_ours;
  job.token = (*claimed)->token;
  job.started((*claimed)->job.tries, now);
  job.control.set_deadline(LiveJob::Clock::now() + job.request.timeout);
  return Begun::yes;
}

// False: it was cancelled or given up meanwhile. A job whose blob stays unreadable must not be tried for ever.
bool LocalRunner::is_queued(const LiveJob& job) {
  const auto row = stores_.jobs.get(job.key);
  return !row || (*row && !store::has_ended((*row)->state));
}

// Whatever ends a durable job that nobody asked to end is the end of this process: another one will run it.
void LocalRunner::conclude(Parked ended) {
  LiveJob& job = *ended.job;
  const store::Job& row = ended.last->row;
  const bool interrupted = phase_.stopping.load() && ended.cut_short && !row.cancel_requested;
  if (job.durable && interrupted) {
    const auto now = stores_.jobs.time();
    if (row.progress) troubles_.note(stores_.jobs.heartbeat(*job.token, now + kLease, *row.progress));
    troubles_.note(stores_.jobs.hand_back(*job.token, "", {now, *row.expires}));
    return drop(job);
  }
  if (!job.durable) {
    stores_.jobs.record(row);
  } else {
    const auto stored = stores_.jobs.finish(*job.token, {row.state, row.document, row.problem, *row.finished,
                                                         *row.expires, row.verdict, ended.last->reusable});
    troubles_.note(stored);
    if (!stored) return park(std::move(ended));
    if (!*stored) log_event("store", "job " + job.key.id + " was taken over by another worker");
    release_blobs(stores_, troubles_, job.key.owner, job.a.id, job.b.id);
  }
  live_.remove(job);
  job.ended(std::move(*ended.last));
}

// This process will not run it: the next one finds it in the store.
void LocalRunner::drop(LiveJob& job) {
  live_.remove(job);
  job.handed_back();
}

// Of a job that was not to be claimed: it has ended by itself, or this process stops.
void LocalRunner::leave_to_its_end(LiveJob& job) {
  const auto row = stores_.jobs.get(job.key);
  if (!row || !*row || !store::has_ended((*row)->state)) return drop(job);
  release_blobs(stores_, troubles_, job.key.owner, (*row)->mesh_a, (*row)->mesh_b);
  JobView last;
  last.row = **row;
  live_.remove(job);
  job.ended(std::move(last));
}

// What runs here hears of it before the disk does.
Result<bool> LocalRunner::cancel(const store::Job& row) {
  const auto job = here(row.key);
  if (job) job->cancel();
  if (!job || job->durable) {
    const auto now = stores_.jobs.time();
    const auto state = stores_.jobs.request_cancel(row.key, {now, now + seconds(settings_.result_ttl_s)});
    if (!state) return state.error();
    if (!*state) return false;
    if (batches_ && **state == JobState::running) batches_->cancel(row.key);
    if (job && **state == JobState::cancelled) {
      // Else its worker was quicker, and has counted it.
      if (job->view().row.state == JobState::queued) metrics_.job_cancelled_early(job->request.options.strategy);
      leave_to_its_end(*job);
      scheduler_.withdraw(job->control);
    }
  }
  if (job) job->wait_for_end(kCancelTime);
  return true;
}

bool LocalRunner::abandon(const std::shared_ptr<LiveJob>& job) {
  job->control.cancel();
  return false;
}

void LocalRunner::park(Parked parked) {
  if (phase_.stopping.load()) return drop(*parked.job);
  if (!std::exchange(parked.job->has_waited, true)) {
    log_event("store", "job " + parked.job->key.id + " waits for the store");
  }
  const std::lock_guard lock(mutex_);
  parked_.push_back(std::move(parked));
}

void LocalRunner::retry_parked() {
  {
    const std::lock_guard lock(mutex_);
    if (parked_.empty()) return;
  }
  if (!phase_.stopping.load()) {  // else they are dropped, whatever the store says
    const auto written = stores_.jobs.check();
    troubles_.note(written);
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
      run(waiting.job, std::move(*waiting.slot));
    }
  }
}

}  // namespace meshgauge::server
