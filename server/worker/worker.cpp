#include "server/worker/worker.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "api/load.h"
#include "server/measure/equal_work.h"
#include "server/measure/kept_blobs.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Stage = HeldJob::Stage;

constexpr milliseconds kProgressInterval{100};
constexpr std::size_t kMostCancelled = 1000;
constexpr std::size_t kMostNamed = 50;  // ids in one line of the log

// The last progress, with the final interval.
store::Progress interval_of(const Outcome& outcome, const std::optional<store::Progress>& seen) {
  return certified(outcome.lower, outcome.upper, seen ? seen->stage : "");
}

// "3 jobs: ID, ID, ID". Names as many as fit into a line of the log.
std::string list_of(const std::vector<std::string>& ids) {
  const std::size_t shown = std::min(ids.size(), kMostNamed);
  std::string list = std::to_string(ids.size()) + (ids.size() == 1 ? " job: " : " jobs: ");
  for (std::size_t i = 0; i < shown; ++i) list += (i == 0 ? "" : ", ") + ids[i];
  return shown == ids.size() ? list : list + " and " + std::to_string(ids.size() - shown) + " more";
}

}  // namespace

Worker::Worker(const Settings& settings, Stores stores, const Measuring& measuring, Scheduler& scheduler,
               StoreErrors& store_errors, Metrics& metrics, WorkerOptions options)
    : settings_(settings),
      stores_(stores),
      measuring_(measuring),
      scheduler_(scheduler),
      metrics_(metrics),
      options_(std::move(options)),
      store_errors_(store_errors),
      buffer_(settings.workers),
      results_(
          stores.jobs, {seconds(settings.result_ttl_s)},
          [this](const PendingResult& delivery, PendingResults::Outcome outcome) { delivered(delivery, outcome); },
          [this](const Error& error) { store_errors_.note(Result<Done>(error)); }) {
  metrics_.watch(Level::deliveries_waiting, [this] { return static_cast<double>(results_.waiting()); });
}

Worker::~Worker() { stop(); }

void Worker::start() {
  threads_.emplace_back([this] { claim_in_background(); });
  threads_.emplace_back([this] { keep_in_background(); });
  for (std::size_t i = 0; i < options_.openers; ++i) threads_.emplace_back([this] { open_in_background(); });
}

void Worker::wake() {
  {
    const std::lock_guard lock(mutex_);
    look_again_ = true;
    next_claim_ = Clock::now();
    claim_pause_ = milliseconds(0);
  }
  claim_wake_.notify_all();
  results_.hurry();
}

void Worker::hear(const store::Signal& signal) {
  using Kind = store::Signal::Kind;
  if (signal.kind == Kind::cancel) return cancel(signal.job);
  if (signal.kind == Kind::work || signal.kind == Kind::missed) wake();
}

// Remembers a key that is not held: its claim may be under way.
void Worker::cancel(const store::JobKey& key) {
  std::vector<HeldJobPtr> found;
  {
    const std::lock_guard lock(mutex_);
    std::copy_if(held_.begin(), held_.end(), std::back_inserter(found),
                 [&](const auto& job) { return job->live->key == key; });
    if (found.empty()) cancelled_.push_back(key);
    if (cancelled_.size() > kMostCancelled) cancelled_.pop_front();
  }
  for (const HeldJobPtr& job : found) cancel(job);
}

// A job that a thread has taken or opens ends there. Another one ends here: all threads may be busy for long.
void Worker::cancel(const HeldJobPtr& job) {
  LiveJob& live = *job->live;
  live.cancel();
  bool buffered = false;
  {
    const std::lock_guard lock(mutex_);
    buffered = job->stage == Stage::claimed || job->stage == Stage::ready;
    if (buffered) {
      buffer_.remove(*job);
      job->stage = Stage::leaving;
    }
  }
  if (!buffered && !scheduler_.withdraw(live.control)) return;
  end(job, api::in_time(live.control, "a thread was free for it").error());
  buffered ? begin_what_can() : free_thread(*job);
}

std::size_t Worker::running() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(
      held_.begin(), held_.end(), [](const HeldJobPtr& job) { return job->stage == Stage::running && job->begun; }));
}

std::size_t Worker::held() const {
  const std::lock_guard lock(mutex_);
  return held_.size();
}

void Worker::drain() {
  std::vector<HeldJobPtr> waiting;
  std::vector<HeldJobPtr> given;
  {
    const std::lock_guard lock(mutex_);
    draining_ = true;
    waiting = buffer_.take_all();
    for (const HeldJobPtr& job : waiting) job->stage = Stage::leaving;
    for (const HeldJobPtr& job : held_) {
      if (job->stage == Stage::running && !job->begun) given.push_back(job);
    }
  }
  claim_wake_.notify_all();
  for (const HeldJobPtr& job : waiting) leave({job, std::nullopt, std::nullopt, ""});
  for (const HeldJobPtr& job : given) withdraw(job);
}

// Hands the job back unless a thread of the scheduler has taken it meanwhile.
void Worker::withdraw(const HeldJobPtr& job) {
  if (!scheduler_.withdraw(job->live->control)) return;
  bool lost = false;
  {
    const std::lock_guard lock(mutex_);
    job->stage = Stage::leaving;
    lost = job->lost;
  }
  if (!lost) leave({job, std::nullopt, std::nullopt, ""});
  free_thread(*job);
}

void Worker::stop(milliseconds timeout) {
  drain();
  {
    std::unique_lock lock(mutex_);
    for (const HeldJobPtr& job : held_) {
      if (job->stage == Stage::running) job->live->control.cancel();
    }
    idle_.wait(lock, [&] { return given_ == 0; });
  }
  if (threads_.empty()) return;
  const auto until = PendingResults::Clock::now() + timeout;
  {
    std::unique_lock lock(mutex_);  // jobs of a claim that is under way must go back, too
    idle_.wait_until(lock, until, [&] { return !claiming_; });
  }
  results_.wait_until_empty(until);
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  for (auto* waiting : {&claim_wake_, &open_wake_, &keep_wake_}) waiting->notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  const std::lock_guard lock(mutex_);
  if (!handed_back_.empty()) log_event("handed_back", list_of(handed_back_));
}

void Worker::begin_what_can() {
  std::vector<HeldJobPtr> next;
  {
    const std::lock_guard lock(mutex_);
    while (HeldJobPtr job = buffer_.take(Clock::now())) next.push_back(std::move(job));
    given_ += next.size();
  }
  for (const HeldJobPtr& job : next) submit(job);
  if (!next.empty()) claim_wake_.notify_all();
}

void Worker::submit(const HeldJobPtr& job) {
  const std::shared_ptr<LiveJob>& live = job->live;
  scheduler_.submit(scheduler_.uncounted(),
                    {live->client, live->bytes, live->request.timeout, std::shared_ptr<Control>(live, &live->control),
                     [this, job](Scheduler::Slot slot) { run(job, std::move(slot)); }});
  if (live->cancel_requested()) cancel(job);  // cancel() may have looked before it waited there
}

void Worker::run(const HeldJobPtr& job, Scheduler::Slot slot) {
  if (begin(*job)) end(job, measuring_.measured(*job->live));
  { const Scheduler::Slot done = std::move(slot); }
  free_thread(*job);
}

void Worker::end(const HeldJobPtr& job, const Result<api::Comparison>& result) {
  measuring_.count(*job->live, result);
  release_bytes(job->live->a);
  release_bytes(job->live->b);
  conclude(job, result);
}

// The last access to this worker is under its lock: after that it may be destroyed.
void Worker::free_thread(const HeldJob& job) {
  {
    const std::lock_guard lock(mutex_);
    buffer_.ended(job);
    if (job.lost) std::erase_if(held_, [&](const HeldJobPtr& held) { return held.get() == &job; });
  }
  begin_what_can();
  const std::lock_guard lock(mutex_);
  claim_wake_.notify_all();
  --given_;
  idle_.notify_all();
}

// The job's time begins now, and ends no later than the deadline of a waiting client.
bool Worker::begin(HeldJob& job) {
  LiveJob& live = *job.live;
  {
    const std::lock_guard lock(mutex_);
    if (job.lost) return false;
    job.begun = Clock::now();
  }
  auto deadline = *job.begun + live.request.timeout;
  if (job.deadline) deadline = std::min(deadline, *job.begun + (*job.deadline - stores_.jobs.time()));
  live.control.set_deadline(deadline);
  live.control.watch([&live](const Progress& p) { live.progressed(certified(p.lower, p.upper, p.stage)); },
                     kProgressInterval);
  return true;
}

// A job that was cancelled without its owner's request was interrupted by the end of this process: it is handed back
// for another worker.
void Worker::conclude(const HeldJobPtr& job, const Result<api::Comparison>& result) {
  LiveJob& live = *job->live;
  PendingResult delivery{job, std::nullopt, live.progress(), ""};
  // A timeout before both meshes were read has the same error; the control tells the two apart.
  const bool cancelled = stopped_by_cancel(result) && live.control.check() == Interruption::cancelled;
  const bool interrupted = cancelled && !live.cancel_requested();
  JobView last;
  if (interrupted) {
    if (result) delivery.progress = interval_of(result->outcome, delivery.progress);
  } else {
    last = measuring_.last_view(live, result, false);
    delivery.ending = {last.row.state,    std::exchange(last.row.document, {}),
                       last.row.problem,  *last.row.finished,
                       *last.row.expires, last.row.verdict,
                       last.reusable,     work_of(last.row)};
  }
  {
    const std::lock_guard lock(mutex_);
    job->stage = Stage::leaving;
    job->last = std::move(last);
    if (job->lost) return;
  }
  leave(std::move(delivery));
}

void Worker::leave(PendingResult delivery) { results_.add(std::move(delivery)); }

void Worker::delivered(const PendingResult& delivery, PendingResults::Outcome outcome) {
  const HeldJob& job = *delivery.job;
  const std::string& id = job.live->key.id;
  if (outcome == PendingResults::Outcome::refused && delivery.ending) {
    metrics_.worker_lease_lost();
    log_event("store", "the result of job " + id + " was refused: its lease had expired");
  }
  const bool ended = outcome == PendingResults::Outcome::stored && delivery.ending;
  if (ended && job.in_batch) release_blobs(stores_, store_errors_, job.live->key.owner, job.live->a.id, job.live->b.id);
  if (ended && options_.ended) options_.ended(job.last);
  const std::lock_guard lock(mutex_);
  if (draining_ && outcome == PendingResults::Outcome::stored && !delivery.ending) handed_back_.push_back(id);
  std::erase(held_, delivery.job);
  next_claim_ = std::min(next_claim_, Clock::now() + claim_pause_);  // other jobs may begin now
  look_again_ = true;
  claim_wake_.notify_all();
}

}  // namespace meshgauge::server
