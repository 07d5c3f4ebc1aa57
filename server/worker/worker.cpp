#include "server/worker/worker.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "api/compare/load.h"
#include "server/base/heap.h"
#include "server/measure/kept_blobs.h"
#include "server/measure/live_job.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Stage = HeldJob::Stage;

constexpr std::size_t kMostCancelled = 1000;
constexpr std::size_t kMostNamed = 50;  // ids in one line of the log
constexpr milliseconds kFirstPause{100};
constexpr milliseconds kLongestPause{5'000};
constexpr seconds kOpeningPause{1};
constexpr unsigned kOpenings = 3;
constexpr seconds kBeatAgain{1};  // after a heartbeat that failed
// Before a job of a batch reports its progress: most end sooner, and clients ask for it about once a second.
constexpr seconds kWorthTelling{1};
// Before a job of a batch reports that it has begun: it may be what ends its worker.
constexpr milliseconds kBegun{200};

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

// Returns the progress to report; nullopt: none. Precondition: the job has begun, and its worker's mutex is held.
std::optional<store::Progress> worth_telling(const HeldJob& job) {
  const auto running_for = HeldJob::Clock::now() - *job.begun;
  if (!job.in_batch || running_for >= kWorthTelling) return job.live->progress();
  if (job.told || running_for < kBegun) return job.told;
  return job.live->progress().value_or(certified(0, std::numeric_limits<double>::infinity(), ""));
}

// `which`: Settings::log_requests. Precondition: the job has ended.
void log_end(const JobView& job, const std::string& which) {
  const bool has_failed = job.row.state == store::JobState::failed;
  if (which == "all" || (which == "problems" && has_failed)) log_job(job.row, job.triangles, job.stages);
}

}  // namespace

Worker::Worker(const Settings& settings, const Stores& stores, const Measuring& measuring, Scheduler& scheduler,
               StoreErrors& store_errors, Metrics& metrics, WorkerOptions options)
    : settings_(settings),
      stores_(stores),
      measuring_(measuring),
      scheduler_(scheduler),
      metrics_(metrics),
      options_(std::move(options)),
      store_errors_(store_errors),
      buffer_(settings.workers),
      results_(stores.jobs, {seconds(settings.result_ttl_s)}, *this),
      threads_([this] { tell_end(); }) {
  metrics_.watch(Level::deliveries_waiting, [this] { return static_cast<double>(results_.waiting()); });
}

Worker::~Worker() { stop(); }

void Worker::start() {
  threads_.start([this] { claim_in_background(); });
  threads_.start([this] { keep_in_background(); });
  for (std::size_t i = 0; i < options_.openers; ++i) threads_.start([this] { open_in_background(); });
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
  threads_.end();
  const std::lock_guard lock(mutex_);
  if (!handed_back_.empty()) log_event("handed_back", list_of(handed_back_));
}

void Worker::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  for (auto* waiting : {&claim_wake_, &open_wake_, &keep_wake_}) waiting->notify_all();
}

void Worker::claim_in_background() {
  const NeverFails never_fails;
  std::unique_lock lock(mutex_);
  while (!ending_) {
    const bool any = !draining_ && !results_.full() && (buffer_.wanted() > 0 || buffer_.wants_guest());
    if (!any && !(draining_ && claiming_)) {
      claim_wake_.wait(lock);
    } else if (Clock::now() < next_claim_) {
      claim_wake_.wait_until(lock, next_claim_);
    } else {
      look_again_ = false;
      claiming_ = true;
      const Claim next = any ? next_claim() : Claim();
      lock.unlock();
      claim(next);
      lock.lock();
      claiming_ = !unsure_.empty();
      idle_.notify_all();
    }
  }
}

// Precondition: mutex_ is held.
Worker::Claim Worker::next_claim() {
  const std::size_t most = buffer_.wanted();
  if (most > 0) return {most, suspects_now(), store::JobStore::Clients::all};
  return {1, store::JobStore::Suspects::passed_over, store::JobStore::Clients::with_none_running};
}

// A suspected job must wait until all others here have ended, which keeps threads idle. So an idle worker should take
// it; a worker that is never idle asks for one now and then, or none might ever run. Precondition: mutex_ is held.
store::JobStore::Suspects Worker::suspects_now() {
  const bool idle = buffer_.running() + buffer_.waiting() == 0;
  const auto now = Clock::now();
  if (!idle && now - asked_for_suspects_ < options_.pass_over) return store::JobStore::Suspects::passed_over;
  asked_for_suspects_ = now;
  return store::JobStore::Suspects::too;
}

// Each claim has a name of its own. When a claim fails it is unknown whether it was stored: before the next one, all
// jobs that run under its name are handed back. A claim of none does that alone.
void Worker::claim(const Claim& what) {
  bool through = take_back_unsure();
  std::vector<HeldJobPtr> claimed;
  if (through && what.most > 0) {
    const std::string name = options_.name + "/" + std::to_string(++claims_) + "/";
    const auto now = stores_.jobs.time();
    auto some = stores_.jobs.claim_some(name, now, now + options_.lease, what.most, what.suspects, what.clients);
    through = some.ok();
    if (some) {
      for (const store::Claimed& one : *some) {
        claimed.push_back(held_of(one));
        claimed.back()->guest = what.clients == store::JobStore::Clients::with_none_running;
      }
    } else {
      unsure_.push_back(name);
      store_errors_.note(some);
    }
  }
  {
    const std::lock_guard lock(mutex_);
    if (through) {
      claim_pause_ = milliseconds(0);
      if (claimed.empty() && !look_again_) next_claim_ = Clock::now() + options_.poll;
      if (!claimed.empty()) adopt(claimed);
    } else if (!look_again_ || claim_pause_ > milliseconds(0)) {
      claim_pause_ = std::clamp(2 * claim_pause_, kFirstPause, kLongestPause);
      next_claim_ = Clock::now() + claim_pause_;
    }
  }
  for (const HeldJobPtr& job : claimed) {
    if (job->live->cancel_requested()) cancel(job);
  }
}

bool Worker::take_back_unsure() {
  while (!unsure_.empty()) {
    const auto back = stores_.jobs.recover(unsure_.back(), "", stores_.jobs.moment(seconds(settings_.result_ttl_s)));
    store_errors_.note(back);
    if (!back) return false;
    unsure_.pop_back();
  }
  return true;
}

// Precondition: mutex_ is held.
void Worker::adopt(const std::vector<HeldJobPtr>& claimed) {
  metrics_.worker_claimed(claimed.size());
  for (const HeldJobPtr& job : claimed) {
    if (std::find(cancelled_.begin(), cancelled_.end(), job->live->key) != cancelled_.end()) job->live->cancel();
    held_.push_back(job);
    if (draining_) {
      job->stage = Stage::leaving;
      leave({job, std::nullopt, std::nullopt, ""});
    } else {
      buffer_.add(job);
    }
  }
  open_wake_.notify_all();
}

HeldJobPtr Worker::held_of(const store::Claimed& claimed) const {
  const auto now = stores_.jobs.time();
  auto job = std::make_shared<HeldJob>();
  job->live = live_job_of(claimed.job, settings_, std::max(milliseconds(0), now - claimed.job.created));
  job->token = claimed.token;
  job->claimed = Clock::now();
  job->live->started(claimed.token.tries, claimed.job.started.value_or(now));
  if (claimed.job.cancel_requested) job->live->cancel();
  job->deadline = claimed.job.deadline;
  job->in_batch = !claimed.job.batch.empty();
  job->suspected = claimed.job.suspected && claimed.token.tries > options_.trusted_tries;
  return job;
}

void Worker::open_in_background() {
  const NeverFails never_fails;
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (const HeldJobPtr job = buffer_.to_open(Clock::now())) {
      job->stage = Stage::opening;
      lock.unlock();
      open(job);
      lock.lock();
    } else if (const auto next = buffer_.next_opening()) {
      open_wake_.wait_until(lock, *next);
    } else {
      open_wake_.wait(lock);
    }
  }
}

// A missing mesh fails the job, in Measuring. A mesh that cannot be read now is tried again; then the job is handed
// back for other workers, without blame.
void Worker::open(const HeldJobPtr& job) {
  const auto error = look_up(*job->live);
  bool again = false;
  {
    const std::lock_guard lock(mutex_);
    if (job->stage != Stage::opening) return;  // lost, or handed back
    again = error && ++job->failures < kOpenings;
    if (!error) {
      job->stage = Stage::ready;
    } else if (again) {
      job->stage = Stage::claimed;
      job->not_before = Clock::now() + kOpeningPause;
    } else {
      job->stage = Stage::leaving;
      buffer_.remove(*job);
    }
  }
  if (!error && job->live->cancel_requested()) return cancel(job);
  if (!error) return begin_what_can();
  open_wake_.notify_all();
  if (again) return;  // another thread may be opening it by now
  const bool damaged = error->code == ErrorCode::internal;
  leave({job, std::nullopt, std::nullopt, damaged ? error->message : ""});
  begin_what_can();
}

// Whether its meshes are worth caching is optional: that error is only noted.
std::optional<Error> Worker::look_up(LiveJob& job) {
  store_errors_.note(recognise_meshes(job, stores_.meshes));
  const auto opened = store_errors_.noted(open_blobs(job, stores_.blobs));
  return opened ? std::nullopt : std::optional(opened.error());
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
  live.set_up_control(deadline);
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
  if (ended && options_.log_jobs) log_end(job.last, settings_.log_requests);
  const std::lock_guard lock(mutex_);
  if (draining_ && outcome == PendingResults::Outcome::stored && !delivery.ending) handed_back_.push_back(id);
  std::erase(held_, delivery.job);
  next_claim_ = std::min(next_claim_, Clock::now() + claim_pause_);  // other jobs may begin now
  look_again_ = true;
  claim_wake_.notify_all();
}

void Worker::failed(const Error& error) { store_errors_.note(Result<Done>(error)); }

void Worker::keep_in_background() {
  const NeverFails never_fails;
  auto next_beat = Clock::now() + options_.heartbeat;
  bool failing = false;
  std::unique_lock lock(mutex_);
  while (!keep_wake_.wait_for(lock, std::min(options_.progress, options_.heartbeat), [&] { return ending_; })) {
    lock.unlock();
    begin_what_can();  // a job that was waited for too long may be passed over
    const auto now = Clock::now();
    const bool everything = now >= next_beat;
    const bool told = tell(due(everything));
    if (everything)
      next_beat = now + (told ? options_.heartbeat : std::min<milliseconds>(options_.heartbeat, kBeatAgain));
    if (std::exchange(failing, !told) && told) wake();
    lock.lock();
  }
}

// Returns the due heartbeats by the name of their claim, since a call takes those of one worker. `everything`: all held
// jobs; else those with new progress.
std::map<std::string, Worker::Telling> Worker::due(bool everything) {
  std::map<std::string, Telling> all;
  const std::lock_guard lock(mutex_);
  for (const HeldJobPtr& job : held_) {
    if (job->lost) continue;
    std::optional<store::Progress> progress;
    if (job->stage == Stage::running && job->begun) progress = worth_telling(*job);
    if (progress == job->told) progress.reset();
    if (!everything && !progress) continue;
    Telling& telling = all[job->token.worker];
    telling.jobs.push_back(job);
    telling.beats.push_back({job->token, progress});
  }
  return all;
}

bool Worker::tell(const std::map<std::string, Telling>& due) {
  for (const auto& [name, telling] : due) {
    const auto heard = stores_.jobs.heartbeats(telling.beats, stores_.jobs.time() + options_.lease);
    store_errors_.note(heard);
    if (!heard) return false;
    for (std::size_t i = 0; i < telling.jobs.size(); ++i) hear(telling.jobs[i], telling.beats[i], (*heard)[i]);
  }
  return true;
}

// A job whose end is being stored may be `lost` because it has ended: finish_all() reports that.
void Worker::hear(const HeldJobPtr& job, const store::Beat& beat, store::Heartbeat heard) {
  if (heard == store::Heartbeat::cancel) return cancel(job);
  bool freed = false;
  {
    const std::lock_guard lock(mutex_);
    if (beat.progress) job->told = beat.progress;
    if (heard != store::Heartbeat::lost || job->stage == Stage::leaving) return;
    job->lost = true;
    metrics_.worker_lease_lost();
    job->live->control.cancel();
    if (job->stage != Stage::running) {
      buffer_.remove(*job);
      job->stage = Stage::leaving;
      std::erase(held_, job);
      freed = true;
    }
  }
  if (freed) begin_what_can();
  claim_wake_.notify_all();
}

}  // namespace meshgauge::server
