#include "engine/thread_pool.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace meshgauge {

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(mutex_);
    leave_ = true;
  }
  begin_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void ThreadPool::run(std::size_t tasks, const std::function<void(std::size_t, std::size_t)>& work) {
  if (size_ == 1 || tasks <= 1) {
    for (std::size_t task = 0; task < tasks; ++task) work(0, task);
    return;
  }
  start_helpers(std::min(size_, tasks) - 1);
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    tasks_ = tasks;
    next_ = 0;
    busy_ = helpers_.size();
    ++round_;
  }
  begin_.notify_all();
  take_tasks(0);
  std::unique_lock lock(mutex_);
  end_.wait(lock, [this] { return busy_ == 0; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

// If the system refuses a thread, the existing ones do the work.
void ThreadPool::start_helpers(std::size_t count) try {
  while (helpers_.size() < count) {
    helpers_.emplace_back([this, worker = helpers_.size() + 1, seen = round_] { help(worker, seen); });
  }
} catch (const std::system_error&) {
}

// `seen`: the last round before this helper was started.
void ThreadPool::help(std::size_t worker, std::size_t seen) {
  std::unique_lock lock(mutex_);
  for (;;) {
    begin_.wait(lock, [&] { return leave_ || round_ != seen; });
    if (leave_) return;
    seen = round_;
    lock.unlock();
    take_tasks(worker);
    lock.lock();
    if (--busy_ == 0) end_.notify_one();
  }
}

void ThreadPool::take_tasks(std::size_t worker) {
  try {
    for (std::size_t task = next_++; task < tasks_; task = next_++) (*work_)(worker, task);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::current_exception();
    next_ = tasks_;
  }
}

}  // namespace meshgauge
