#include "server/http/io_pool.h"

#include <algorithm>

namespace meshgauge::server {
namespace {

constexpr std::size_t kMaxRefusals = 256;  // queued refusals; further connections are closed without a response

thread_local IoPool::Role current_role = IoPool::Role::serve;

}  // namespace

IoPool::IoPool(std::size_t threads, std::size_t max_pending, std::function<void()> at_end)
    : at_end_(std::move(at_end)), limit_(max_pending) {
  for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(serving_, Role::serve); });
  threads_.emplace_back([this] { run(refusing_, Role::refuse); });
}

IoPool::~IoPool() { shutdown(); }

IoPool::Role IoPool::place(Task& task) {
  const std::lock_guard lock(mutex_);
  const std::size_t waiting = serving_.tasks.size() - std::min(serving_.tasks.size(), idle_);
  if (serving_.tasks.size() < idle_ + limit_.limit(waiting, QueueLimit::Clock::now())) {
    serving_.tasks.push_back(std::move(task));
    serving_.ready.notify_one();
    return Role::serve;
  }
  if (refusing_.tasks.size() >= kMaxRefusals) return Role::drop;
  refusing_.tasks.push_back(std::move(task));
  refusing_.ready.notify_one();
  return Role::refuse;
}

decltype(std::declval<httplib::TaskQueue&>().enqueue(IoPool::Task())) IoPool::enqueue(Task task) {
  using Answer = decltype(std::declval<httplib::TaskQueue&>().enqueue(Task()));
  if (place(task) == Role::drop) {
    current_role = Role::drop;
    task();
    current_role = Role::serve;
  }
  return Answer(true);
}

void IoPool::run(Lane& lane, Role role) {
  current_role = role;

  for (;;) {
    Task task;
    {
      std::unique_lock lock(mutex_);
      idle_ += role == Role::serve;
      lane.ready.wait(lock, [&] { return ending_ || !lane.tasks.empty(); });
      idle_ -= role == Role::serve;
      if (lane.tasks.empty()) return;
      task = std::move(lane.tasks.front());
      lane.tasks.pop_front();
    }
    task();
  }
}

void IoPool::shutdown() {
  at_end_();
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  serving_.ready.notify_all();
  refusing_.ready.notify_all();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

bool IoPool::has_pending() const {
  const std::lock_guard lock(mutex_);
  return serving_.tasks.size() > idle_;
}

IoPool::Role IoPool::role() { return current_role; }

}  // namespace meshgauge::server
