// Threads that handle requests, behind a bounded queue.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>

#include "server/base/threads.h"

namespace meshgauge::server {

// The length limit of a queue. A short burst may fill the whole queue. When the queue has not been empty for 100 ms,
// the load exceeds the capacity, and a long queue only adds delay; the limit is then an eighth. (After Nichols and
// Jacobson, "Controlling Queue Delay", ACM Queue 2012.) One thread at a time.
class QueueLimit {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kBurst{100};
  static constexpr std::size_t kPart = 8;  // under overload the limit is max / kPart + 1

  explicit QueueLimit(std::size_t most) : most_(most) {}

  // Returns how many may wait at `now`. Call for each new element; `waiting`: how many wait before it.
  std::size_t limit(std::size_t waiting, Clock::time_point now) {
    if (waiting == 0) empty_ = now;
    return now - empty_ <= kBurst ? most_ : std::min(most_, most_ / kPart + 1);
  }

 private:
  const std::size_t most_;
  Clock::time_point empty_{};  // when the queue was last empty
};

// Thread safe.
class IoPool {
 public:
  using Task = std::function<void()>;  // must not throw

  IoPool(std::size_t threads, std::size_t max_pending);
  ~IoPool() = default;  // blocks until every task has run
  IoPool(const IoPool&) = delete;
  IoPool& operator=(const IoPool&) = delete;

  bool offer(Task task);  // false: too many tasks wait; this one is not taken
  void push(Task task);   // takes it in any case

 private:
  void add(Task task);  // precondition: mutex_ is held
  void run();
  void tell_end();

  std::mutex mutex_;  // guards what follows
  std::condition_variable ready_;
  QueueLimit limit_;
  std::deque<Task> tasks_;
  std::size_t idle_;  // threads that wait for a task, or have not begun
  bool ending_ = false;
  Threads threads_;
};

}  // namespace meshgauge::server
