// Worker: claims jobs and opens their blobs.
#include <algorithm>
#include <utility>

#include "server/base/heap.h"
#include "server/measure/revived.h"
#include "server/worker/worker.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Stage = HeldJob::Stage;

constexpr milliseconds kFirstPause{100};
constexpr milliseconds kLongestPause{5'000};
constexpr seconds kOpeningPause{1};
constexpr unsigned kOpenings = 3;

}  // namespace

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
    const auto now = stores_.jobs.time();
    const auto back = stores_.jobs.recover(unsure_.back(), "", {now, now + seconds(settings_.result_ttl_s)});
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
  const auto opened = open_blobs(job, stores_.blobs);
  store_errors_.note(opened);
  return opened ? std::nullopt : std::optional(opened.error());
}

}  // namespace meshgauge::server
