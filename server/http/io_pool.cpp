#include "server/http/io_pool.h"

#include <utility>

namespace meshgauge::server {

// A thread that has not begun yet is idle: it takes what is offered now.
IoPool::IoPool(std::size_t threads, std::size_t max_pending)
    : limit_(max_pending), idle_(threads), threads_([this] { tell_end(); }) {
  for (std::size_t i = 0; i < threads; ++i) threads_.start([this] { run(); });
}

void IoPool::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ready_.notify_all();
}

bool IoPool::offer(Task task) {
  const std::lock_guard lock(mutex_);
  const std::size_t waiting = tasks_.size() - std::min(tasks_.size(), idle_);
  if (tasks_.size() >= idle_ + limit_.limit(waiting, QueueLimit::Clock::now())) return false;
  add(std::move(task));
  return true;
}

void IoPool::push(Task task) {
  const std::lock_guard lock(mutex_);
  add(std::move(task));
}

void IoPool::add(Task task) {
  tasks_.push_back(std::move(task));
  ready_.notify_one();
}

void IoPool::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    ready_.wait(lock, [this] { return ending_ || !tasks_.empty(); });
    --idle_;
    if (tasks_.empty()) return;
    {
      const Task task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task();
    }
    lock.lock();
    ++idle_;
  }
}

}  // namespace meshgauge::server
