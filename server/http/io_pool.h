// Threads that handle requests, behind a bounded queue (server/http/queue_limit.h). Thread safe.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "server/http/queue_limit.h"

namespace meshgauge::server {

class IoPool {
 public:
  using Task = std::function<void()>;  // must not throw

  IoPool(std::size_t threads, std::size_t max_pending);
  ~IoPool();  // blocks until every task has run
  IoPool(const IoPool&) = delete;
  IoPool& operator=(const IoPool&) = delete;

  bool offer(Task task);  // false: too many tasks wait; this one is not taken
  void push(Task task);   // takes it in any case

 private:
  void add(Task task);  // precondition: mutex_ is held
  void run();

  std::mutex mutex_;  // guards what follows
  std::condition_variable ready_;
  QueueLimit limit_;
  std::deque<Task> tasks_;
  std::size_t idle_;  // threads that wait for a task, or have not begun
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace meshgauge::server
