// Worker: heartbeats.
#include <algorithm>
#include <limits>
#include <utility>

#include "server/base/heap.h"
#include "server/worker/worker.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Stage = HeldJob::Stage;

constexpr seconds kBeatAgain{1};  // after a heartbeat that failed
constexpr seconds kWorthTelling{
    3};  // before a job of a batch reports its progress: most end sooner, and no client follows one
constexpr milliseconds kBegun{
    200};  // before a job of a batch reports that it has begun: it may be what ends its worker

// Returns the progress to report; nullopt: none. Precondition: the job has begun, and its worker's mutex is held.
std::optional<store::Progress> worth_telling(const HeldJob& job) {
  const auto running_for = HeldJob::Clock::now() - *job.begun;
  if (!job.in_batch || running_for >= kWorthTelling) return job.live->progress();
  if (job.told || running_for < kBegun) return job.told;
  return job.live->progress().value_or(certified(0, std::numeric_limits<double>::infinity(), ""));
}

}  // namespace

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
