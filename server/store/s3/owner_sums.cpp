#include "server/store/s3/owner_sums.h"

#include <algorithm>
#include <exception>
#include <vector>

namespace meshgauge::server::store {

OwnerSums::~OwnerSums() {
  std::vector<std::future<void>> refreshes;
  {
    const std::lock_guard lock(mutex_);
    for (auto& [owner, sum] : sums_) refreshes.push_back(std::move(sum.refresh));
  }
  for (const std::future<void>& refresh : refreshes) {
    if (refresh.valid()) refresh.wait();  // it writes to sums_, which must outlive it
  }
}

Result<std::uint64_t> OwnerSums::of(const std::string& owner) {
  std::unique_lock lock(mutex_);
  Sum& sum = sums_[owner];
  weighed_.wait(lock, [&] { return sum.known || !sum.weighing; });
  const bool due = !sum.weighing && Clock::now() >= sum.good_until;
  if (sum.known && !due) return sum.bytes;
  sum.meanwhile = 0;
  if (sum.known) {
    sum.refresh = std::async(std::launch::async, [this, owner] { static_cast<void>(weigh(owner)); });
    sum.weighing = true;
    return sum.bytes;
  }
  sum.weighing = true;
  lock.unlock();
  return weigh(owner);
}

// Callers that wait for the listing must be woken.
Result<std::uint64_t> OwnerSums::weighed(const std::string& owner) const try {
  return weigh_(owner);
} catch (const std::exception& error) {
  return Error{ErrorCode::internal, error.what(), "", ""};
}

Result<std::uint64_t> OwnerSums::weigh(const std::string& owner) {
  const Clock::time_point begin = Clock::now();
  const Result<std::uint64_t> found = weighed(owner);
  const std::lock_guard lock(mutex_);
  Sum& sum = sums_[owner];
  sum.weighing = false;
  sum.good_until = Clock::now() + std::max<Clock::duration>(age_, kIdle * (Clock::now() - begin));
  if (found) {
    sum.known = true;
    sum.bytes = *found + sum.meanwhile;
  }
  weighed_.notify_all();
  if (!found) return found.error();
  return sum.bytes;
}

void OwnerSums::add(const std::string& owner, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  Sum& sum = sums_[owner];
  sum.bytes += bytes;
  sum.meanwhile += bytes;
}

void OwnerSums::remove(const std::string& owner, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  Sum& sum = sums_[owner];
  sum.bytes -= std::min(bytes, sum.bytes);
}

}  // namespace meshgauge::server::store
