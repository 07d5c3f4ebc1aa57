#include "server/store/unwritten.h"

#include <algorithm>
#include <utility>

namespace meshgauge::server::store {
namespace {

void merge(Unwritten::Touches& touches, const BlobKey& mesh, Touch touch) {
  const auto [found, added] = touches.try_emplace(mesh, touch);
  if (added) return;
  found->second.last_used = std::max(found->second.last_used, touch.last_used);
  found->second.expires = std::max(found->second.expires, touch.expires);
}

}  // namespace

void Unwritten::add(Job job) {
  auto added = std::make_shared<const Job>(std::move(job));
  {
    const std::lock_guard lock(mutex_);
    by_key_[added->key] = added;
    waiting_.push_back(std::move(added));
    drop_beyond_maximum();
  }
  changed_.notify_all();
}

void Unwritten::add(const BlobKey& mesh, Touch touch) {
  {
    const std::lock_guard lock(mutex_);
    // They are worth little: when nothing can be written they must not fill the memory.
    if (touches_.size() >= max_jobs_ && !touches_.contains(mesh)) return;
    merge(touches_, mesh, touch);
  }
  changed_.notify_all();
}

std::shared_ptr<const Job> Unwritten::find(const JobKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  return found == by_key_.end() ? nullptr : found->second;
}

bool Unwritten::wait(std::chrono::milliseconds linger) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || !waiting_.empty() || !touches_.empty(); });
  return !changed_.wait_for(lock, linger, [this] { return stopped_; });
}

void Unwritten::pause(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, time, [this] { return stopped_; });
}

void Unwritten::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
}

const Unwritten::Batch& Unwritten::take() {
  const std::lock_guard lock(mutex_);
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(waiting_.size(), kBatch));
  batch_.jobs.assign(waiting_.begin(), end);
  waiting_.erase(waiting_.begin(), end);
  batch_.touches = std::exchange(touches_, {});
  return batch_;
}

void Unwritten::settle() {
  const std::lock_guard lock(mutex_);
  forget_batch();
}

void Unwritten::put_back() {
  const std::lock_guard lock(mutex_);
  waiting_.insert(waiting_.begin(), batch_.jobs.begin(), batch_.jobs.end());
  for (const auto& [mesh, touch] : batch_.touches) merge(touches_, mesh, touch);
  batch_ = {};
  drop_beyond_maximum();
}

void Unwritten::end(const Result<Done>& written) {
  if (written) return settle();
  written.error().code == ErrorCode::internal ? give_up() : put_back();
}

void Unwritten::give_up() {
  const std::lock_guard lock(mutex_);
  dropped_ += batch_.jobs.size();
  forget_batch();
}

void Unwritten::forget_batch() {
  for (const auto& job : batch_.jobs) by_key_.erase(job->key);
  batch_ = {};
}

void Unwritten::drop_beyond_maximum() {
  while (waiting_.size() > max_jobs_) {
    by_key_.erase(waiting_.front()->key);
    waiting_.pop_front();
    ++dropped_;
  }
}

std::uint64_t Unwritten::jobs() const {
  const std::lock_guard lock(mutex_);
  return waiting_.size() + batch_.jobs.size();
}

std::uint64_t Unwritten::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace meshgauge::server::store
