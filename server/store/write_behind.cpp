#include "server/store/write_behind.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "server/base/heap.h"

namespace meshgauge::server::store {
namespace {

using namespace std::chrono_literals;

// How long records are gathered before they are written: at most ten syncs a second.
constexpr auto kLinger = 100ms;
constexpr auto kPauseAfterFailure = 1s;
constexpr std::size_t kBatch = 1000;

void merge(WriteBehind::Touches& touches, const BlobKey& mesh, Touch touch) {
  const auto [found, added] = touches.try_emplace(mesh, touch);
  if (added) return;
  found->second.last_used = std::max(found->second.last_used, touch.last_used);
  found->second.expires = std::max(found->second.expires, touch.expires);
}

}  // namespace

WriteBehind::WriteBehind(std::size_t max_jobs, Write write)
    : max_jobs_(max_jobs), write_(std::move(write)), threads_([this] { tell_end(); }) {
  threads_.start([this] { write_in_background(); });
}

WriteBehind::~WriteBehind() {
  threads_.end();
  static_cast<void>(flush());  // no caller is left for the error
}

void WriteBehind::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
}

void WriteBehind::record(Job ended) {
  assert(has_ended(ended.state) && ended.finished && ended.expires);
  auto added = std::make_shared<const Job>(std::move(ended));
  {
    const std::lock_guard lock(mutex_);
    by_key_[added->key] = added;
    waiting_.push_back(std::move(added));
    drop_beyond_maximum();
  }
  changed_.notify_all();
}

void WriteBehind::touch(const BlobKey& mesh, Touch touch) {
  {
    const std::lock_guard lock(mutex_);
    // While nothing can be written they must not fill the memory.
    if (touches_.size() >= max_jobs_ && !touches_.contains(mesh)) return;
    merge(touches_, mesh, touch);
  }
  changed_.notify_all();
}

std::shared_ptr<const Job> WriteBehind::find(const JobKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  return found == by_key_.end() ? nullptr : found->second;
}

bool WriteBehind::drop(const JobKey& key) {
  if (!find(key)) return false;
  const std::lock_guard writing(writing_);
  const std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return false;
  std::erase(waiting_, found->second);
  by_key_.erase(found);
  return true;
}

WriteBehind::Touches WriteBehind::touches() const {
  const std::lock_guard lock(mutex_);
  return touches_;
}

void WriteBehind::add_to(Counts& counts) const {
  const std::lock_guard lock(mutex_);
  counts.unrecorded = by_key_.size();
  counts.dropped_records = dropped_;
}

Result<Done> WriteBehind::flush() {
  const std::lock_guard writing(writing_);
  std::size_t rounds = 1;  // for what is held now, not for what comes
  {
    const std::lock_guard lock(mutex_);
    rounds += waiting_.size() / kBatch;
  }
  for (std::size_t round = 0; round < rounds; ++round) {
    if (auto written = write_some(); !written) return written;
  }
  return Done{};
}

void WriteBehind::write_in_background() {
  const NeverFails never_fails;
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    changed_.wait(lock, [this] { return stopped_ || !waiting_.empty() || !touches_.empty(); });
    if (changed_.wait_for(lock, kLinger, [this] { return stopped_; })) return;
    lock.unlock();
    const bool written = [this] {
      const std::lock_guard writing(writing_);
      return write_some().ok();
    }();
    lock.lock();
    if (!written) changed_.wait_for(lock, kPauseAfterFailure, [this] { return stopped_; });
  }
}

// Precondition: writing_ is held.
Result<Done> WriteBehind::write_some() {
  take();
  if (batch_.jobs.empty() && batch_.touches.empty()) return Done{};
  auto written = write_(batch_);
  end(written);
  return written;
}

void WriteBehind::take() {
  const std::lock_guard lock(mutex_);
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(waiting_.size(), kBatch));
  batch_.jobs.assign(waiting_.begin(), end);
  waiting_.erase(waiting_.begin(), end);
  batch_.touches = std::exchange(touches_, {});
}

// Drops the batch on an error that does not pass; else it is tried again.
void WriteBehind::end(const Result<Done>& written) {
  const std::lock_guard lock(mutex_);
  if (!written && written.error().code != ErrorCode::internal) {
    waiting_.insert(waiting_.begin(), batch_.jobs.begin(), batch_.jobs.end());
    for (const auto& [mesh, touch] : batch_.touches) merge(touches_, mesh, touch);
    drop_beyond_maximum();
  } else {
    if (!written) dropped_ += batch_.jobs.size();
    for (const auto& job : batch_.jobs) by_key_.erase(job->key);
  }
  batch_ = {};
}

void WriteBehind::drop_beyond_maximum() {
  while (waiting_.size() > max_jobs_) {
    by_key_.erase(waiting_.front()->key);
    waiting_.pop_front();
    ++dropped_;
  }
}

}  // namespace meshgauge::server::store
