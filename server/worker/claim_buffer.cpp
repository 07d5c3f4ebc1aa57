#include "server/worker/claim_buffer.h"

#include <algorithm>
#include <utility>

#include "server/settings/settings.h"

namespace meshgauge::server {

void ClaimBuffer::add(HeldJobPtr job) {
  waiting_bytes_ += job->live->bytes;
  suspected_ += job->suspected ? 1U : 0U;
  guests_ += job->guest ? 1U : 0U;
  const auto place = job->in_batch || job->suspected ? waiting_.end()
                                                     : std::find_if(waiting_.begin(), waiting_.end(),
                                                                    [](const auto& other) { return other->in_batch; });
  waiting_.insert(place, std::move(job));
}

HeldJobPtr ClaimBuffer::take(LiveJob::Clock::time_point now) {
  if (alone_) return nullptr;
  for (const HeldJobPtr& job : waiting_) {
    const bool full = !job->guest && running_ >= threads_;
    if (full || (job->suspected && running() > 0)) continue;
    if (job->stage != HeldJob::Stage::ready) {
      if (is_small(*job) && job->failures == 0 && now - job->claimed < kSoon) return nullptr;
      continue;
    }
    HeldJobPtr next = job;
    std::erase(waiting_, next);
    waiting_bytes_ -= next->live->bytes;
    ++(next->guest ? guests_running_ : running_);
    large_running_ += next->guest || is_small(*next) ? 0U : 1U;
    alone_ = next->suspected;
    next->stage = HeldJob::Stage::running;
    return next;
  }
  return nullptr;
}

void ClaimBuffer::ended(const HeldJob& job) {
  --(job.guest ? guests_running_ : running_);
  large_running_ -= job.guest || is_small(job) ? 0U : 1U;
  guests_ -= job.guest ? 1U : 0U;
  if (!job.suspected) return;
  alone_ = false;
  --suspected_;
}

void ClaimBuffer::remove(const HeldJob& job) {
  const auto found =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& held) { return held.get() == &job; });
  if (found == waiting_.end()) return;
  waiting_bytes_ -= job.live->bytes;
  suspected_ -= job.suspected ? 1U : 0U;
  guests_ -= job.guest ? 1U : 0U;
  waiting_.erase(found);
}

std::vector<HeldJobPtr> ClaimBuffer::take_all() {
  std::vector<HeldJobPtr> all(waiting_.begin(), waiting_.end());
  for (const HeldJobPtr& job : all) remove(*job);
  return all;
}

std::size_t ClaimBuffer::wanted() const {
  if (suspected_ > 0) return 0;
  const std::size_t waiting = waiting_.size() - (guests_ - guests_running_);
  if (running_ + waiting < threads_) return kMost;
  // What comes may be large, or of no batch: some thread must be about to be free for it.
  const bool turning_over = large_running_ < threads_;
  const bool stocked = std::any_of(waiting_.begin(), waiting_.end(), [](const auto& job) { return !is_small(*job); });
  if (!turning_over || stocked || waiting_.size() >= kRefillBelow || waiting_bytes_ >= kMostBytes) return 0;
  return kMost - waiting_.size();
}

bool ClaimBuffer::wants_guest() const { return suspected_ == 0 && guests_ < kGuests && wanted() == 0; }

HeldJobPtr ClaimBuffer::to_open(LiveJob::Clock::time_point now) const {
  const auto found = std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& job) {
    return job->stage == HeldJob::Stage::claimed && job->not_before <= now;
  });
  return found == waiting_.end() ? nullptr : *found;
}

std::optional<LiveJob::Clock::time_point> ClaimBuffer::next_opening() const {
  std::optional<LiveJob::Clock::time_point> next;
  for (const HeldJobPtr& job : waiting_) {
    if (job->stage == HeldJob::Stage::claimed && (!next || job->not_before < *next)) next = job->not_before;
  }
  return next;
}

}  // namespace meshgauge::server
