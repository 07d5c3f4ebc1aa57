// Work that is done again and again.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <utility>

#include "server/base/heap.h"
#include "server/base/threads.h"

namespace meshgauge::server {

// Calls a function once a second on a thread of its own, because it may block for the stores. The first time after a
// second.
class EachSecond {
 public:
  explicit EachSecond(std::function<void()> work) : threads_([this] { tell_end(); }) {
    threads_.start([this, work = std::move(work)] { run(work); });
  }
  ~EachSecond() = default;  // waits for a call that is under way
  EachSecond(const EachSecond&) = delete;
  EachSecond& operator=(const EachSecond&) = delete;

 private:
  void tell_end() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_all();
  }

  void run(const std::function<void()>& work) {
    const NeverFails never_fails;
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, std::chrono::seconds(1), [this] { return ending_; })) {
      lock.unlock();
      work();
      lock.lock();
    }
  }

  std::mutex mutex_;  // guards ending_
  std::condition_variable wake_;
  bool ending_ = false;
  Threads threads_;
};

}  // namespace meshgauge::server
