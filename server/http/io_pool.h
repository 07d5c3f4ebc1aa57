// The threads that serve connections, as a task queue of the HTTP library. The queue is bounded
// (server/http/queue_limit.h): one extra thread refuses connections beyond its limit at once.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "server/http/http_library.h"
#include "server/http/queue_limit.h"

namespace meshgauge::server {

class IoPool final : public httplib::TaskQueue {
 public:
  using Task = std::function<void()>;
  enum class Role { serve, refuse, drop };  // what a task does with its connection; drop: close it without a response

  // `at_end` is called by shutdown() before it waits for the queued tasks.
  IoPool(std::size_t threads, std::size_t max_pending, std::function<void()> at_end);
  ~IoPool() override;

  // Accepts every task and picks its role. A task to drop runs at once on the calling thread. Returns true; void in
  // older versions of the library.
  decltype(std::declval<httplib::TaskQueue&>().enqueue(Task())) enqueue(Task task) override;

  void shutdown() override;  // blocks until every task has run

  bool has_pending() const;  // true: a connection waits for a thread

  static Role role();  // of the task that runs on the calling thread

 private:
  struct Lane {
    std::deque<Task> tasks;
    std::condition_variable ready;
  };

  Role place(Task& task);
  void run(Lane& lane, Role role);

  const std::function<void()> at_end_;
  mutable std::mutex mutex_;  // guards what follows
  QueueLimit limit_;
  Lane serving_;
  Lane refusing_;
  std::size_t idle_ = 0;  // serving threads that wait for a task
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace meshgauge::server
