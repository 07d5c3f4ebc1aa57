#include "server/store/policy.h"

#include <algorithm>
#include <tuple>

namespace meshgauge::server::store {

std::int64_t rank_of(const NewJob& job) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 50;  // far from an overflow
  constexpr std::int64_t kBytesOfOneMillisecond = JobStore::kBytesOfOneSecond / 1000;
  return job.created.time_since_epoch().count() * kBytesOfOneMillisecond +
         static_cast<std::int64_t>(std::min(job.cost, kMost));
}

const Group* next_group(std::span<const Group> groups, JobStore::Clients clients) {
  const auto first = std::min_element(groups.begin(), groups.end(), [](const Group& x, const Group& y) {
    return std::tie(x.running, x.rank) < std::tie(y.running, y.rank);
  });
  const bool wrong = first == groups.end() || (clients == JobStore::Clients::with_none_running && first->running > 0);
  return wrong ? nullptr : &*first;
}

std::size_t fit_in_claim(std::span<const Candidate> first) {
  std::uint64_t cost = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    cost += first[i].cost;
    if (i > 0 && (first[i].suspected || cost > JobStore::kBytesOfOneSecond)) return i;
    if (first[i].suspected) return i + 1;
  }
  return first.size();
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

std::vector<Kept> beyond_share(const std::vector<Kept>& kept, std::uint64_t max_kept, std::uint64_t most) {
  const std::uint64_t share = share_of(kept, max_kept);
  std::vector<Kept> beyond;
  for (const auto& [owner, jobs] : kept) {
    if (jobs <= share || most == 0) continue;
    beyond.push_back({owner, std::min(jobs - share, most)});
    most -= beyond.back().jobs;
  }
  return beyond;
}

}  // namespace meshgauge::server::store
