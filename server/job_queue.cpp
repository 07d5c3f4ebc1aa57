#include "server/job_queue.h"

namespace meshgauge::server {

JobQueue::Slot::~Slot() {
  if (queue_) queue_->release();
}

JobQueue::JobQueue(std::size_t workers, std::size_t queue) : capacity_(workers + queue) {
  for (std::size_t i = 0; i < workers; ++i) workers_.emplace_back([this] { work(); });
}

JobQueue::~JobQueue() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ready_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

std::optional<JobQueue::Slot> JobQueue::admit() {
  const std::lock_guard lock(mutex_);
  if (slots_ == capacity_) return std::nullopt;
  ++slots_;
  return Slot(this);
}

void JobQueue::release() {
  const std::lock_guard lock(mutex_);
  --slots_;
}

void JobQueue::submit(Slot slot, Job job) {
  {
    const std::lock_guard lock(mutex_);
    if (cancelled_) job.control->cancel();
    waiting_.push_back({std::move(slot), std::move(job)});
  }
  ready_.notify_one();
}

JobQueue::Load JobQueue::load() const {
  const std::lock_guard lock(mutex_);
  return {waiting_.size(), running_.size()};
}

void JobQueue::cancel_all() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  for (const Entry& entry : waiting_) entry.job.control->cancel();
  for (const auto& control : running_) control->cancel();
}

void JobQueue::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    ready_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    {
      Entry entry = std::move(waiting_.front());
      waiting_.pop_front();
      running_.push_back(entry.job.control.get());
      lock.unlock();
      entry.job.work(std::move(entry.slot));
      lock.lock();
      std::erase(running_, entry.job.control.get());
      lock.unlock();  // what the job owns, files among it, goes without holding up the others
    }
    lock.lock();
  }
}

}  // namespace meshgauge::server
