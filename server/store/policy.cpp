#include "server/store/policy.h"

#include <algorithm>

namespace meshgauge::server::store {

std::int64_t rank_of(const NewJob& job) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 50;  // far from an overflow
  constexpr std::int64_t kBytesOfOneMillisecond = JobStore::kBytesOfOneSecond / 1000;
  return job.created.time_since_epoch().count() * kBytesOfOneMillisecond +
         static_cast<std::int64_t>(std::min(job.cost, kMost));
}

AfterLoss after_hand_back(const Loss& loss, bool excused) {
  const unsigned excuses = loss.excused + (excused ? 1U : 0U);
  if (loss.cancel_requested) return {JobState::cancelled, excuses};
  return {loss.tries >= excuses + kMaxTries ? JobState::failed : JobState::queued, excuses};
}

AfterLoss after_loss(const Loss& loss) {
  const bool suspected = loss.tries > loss.excused + 1;
  return after_hand_back(loss, loss.in_batch && !loss.told_progress && !suspected && loss.excused < kMaxUnbegun);
}

std::uint64_t share_of(std::vector<Kept> kept, std::uint64_t max_kept) {
  std::sort(kept.begin(), kept.end(), [](const Kept& x, const Kept& y) { return x.jobs < y.jobs; });
  std::uint64_t left = max_kept;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const std::uint64_t share = left / (kept.size() - i);
    if (kept[i].jobs > share) return share;
    left -= kept[i].jobs;
  }
  return max_kept;
}

std::uint64_t remove_over_share(
    const std::vector<Kept>& kept, std::uint64_t max_kept, std::uint64_t most,
    const std::function<std::uint64_t(const std::string& owner, std::uint64_t wanted)>& remove_oldest) {
  const std::uint64_t share = share_of(kept, max_kept);
  std::uint64_t left = most;
  for (const auto& [owner, jobs] : kept) {
    if (jobs > share && left > 0) left -= remove_oldest(owner, std::min(jobs - share, left));
  }
  return most - left;
}

}  // namespace meshgauge::server::store
