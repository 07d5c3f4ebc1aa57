#include "server/jobs/store_queue.h"

#include <algorithm>

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::seconds kAnswerTime{5};   // without an answer for longer, the store counts as away
constexpr std::chrono::minutes kLongestWait{1};  // the longest estimate
constexpr double kShareOfTheLastReading = 0.2;

std::uint64_t ended(const store::Counts& of) { return of.done + of.failed + of.cancelled; }

}  // namespace

void EndRate::learn(const store::Counts& before, const store::Counts& now, double seconds) {
  if (before.queued == 0 || now.queued == 0 || ended(now) < ended(before) || seconds <= 0) return;
  ++readings_;
  const double rate = static_cast<double>(ended(now) - ended(before)) / seconds;
  per_second_ += std::max(kShareOfTheLastReading, 1 / static_cast<double>(readings_)) * (rate - per_second_);
}

StoreQueue::StoreQueue(store::JobStore& jobs, StoreErrors& store_errors) : jobs_(jobs), store_errors_(store_errors) {
  poll();
  polling_.emplace([this] { poll(); });
}

void StoreQueue::poll() {
  std::uint64_t before = 0;
  {
    const std::lock_guard lock(mutex_);
    before = added_;
  }
  const auto counts = store_errors_.noted(jobs_.counts());
  const std::lock_guard lock(mutex_);
  if (!counts) {
    error_ = counts.error();
    return;
  }
  error_.reset();
  learn(*counts, Clock::now());
  added_ -= before;  // jobs that were added meanwhile may count twice, until the next read
}

void StoreQueue::learn(const store::Counts& counts, Clock::time_point now) {
  ends_.learn(counts_, counts, std::chrono::duration<double>(now - answered_).count());
  counts_ = counts;
  answered_ = now;
}

Result<Done> StoreQueue::available() const {
  const std::lock_guard lock(mutex_);
  if (error_) return *error_;
  if (Clock::now() - answered_ <= kAnswerTime) return Done{};
  return Error{ErrorCode::storage_unavailable, "the store does not answer; try again later", "", ""};
}

StoreQueue::Clock::duration StoreQueue::silence() const {
  const std::lock_guard lock(mutex_);
  return Clock::now() - answered_;
}

store::Counts StoreQueue::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::uint64_t StoreQueue::unawaited() const {
  const std::lock_guard lock(mutex_);
  return counts_.unawaited + added_;
}

void StoreQueue::added() {
  const std::lock_guard lock(mutex_);
  ++added_;
}

double StoreQueue::oldest_waiting_seconds() const {
  const auto oldest = counts().oldest_queued;
  if (!oldest) return 0;
  return std::max(0.0, std::chrono::duration<double>(jobs_.time() - *oldest).count());
}

milliseconds StoreQueue::expected_wait() const {
  const std::lock_guard lock(mutex_);
  const auto rate = ends_.per_second();
  if (counts_.queued == 0 || !rate) return milliseconds(0);
  const double seconds = static_cast<double>(counts_.queued) / std::max(*rate, 1e-3);
  return std::min(milliseconds(kLongestWait), milliseconds(static_cast<std::int64_t>(seconds * 1000)));
}

}  // namespace meshgauge::server
