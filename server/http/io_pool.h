// The threads that serve connections, as the HTTP library's task queue. Bounded: a connection that finds no
// room (server/http/queue_limit.h) is refused at once by a thread of its own, instead of waiting unseen.
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
  enum class Role { serve, refuse, drop };  // what the task that runs on this thread is to do with its connection

  // `at_end` is called when no task comes any more, before those that are here have run.
  IoPool(std::size_t threads, std::size_t max_pending, std::function<void()> at_end);
  ~IoPool() override;

  // void in older versions of the library, bool in newer ones. Takes every task: its role says how far it comes.
  decltype(std::declval<httplib::TaskQueue&>().enqueue(Task())) enqueue(Task task) override;

  void shutdown() override;  // ends when every task has run

  bool has_pending() const;  // a connection waits for a thread

  static Role role();

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
  std::size_t idle_ = 0;  // serving threads that wait
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace meshgauge::server
