// The threads of an object.
#pragma once

#include <functional>
#include <thread>
#include <utility>
#include <vector>

namespace meshgauge::server {

// Owns the threads of an object, whose last member it is: they end before what they use is destroyed, also when the
// object's constructor throws because the system grants only some of them. Used by one thread at a time.
class Threads {
 public:
  // `tell_end` makes the work of every thread return soon. It must not throw.
  explicit Threads(std::function<void()> tell_end) : tell_end_(std::move(tell_end)) {}
  ~Threads() { end(); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  // Throws std::system_error or std::bad_alloc: no further thread runs then. `work` must not throw.
  template <class Work>
  void start(Work work) {
    threads_.emplace_back(std::move(work));
  }

  bool empty() const { return threads_.empty(); }  // none was started since the last end()

  // Calls `tell_end` and blocks until all have ended. Does nothing without threads.
  void end() {
    if (threads_.empty()) return;
    tell_end_();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  const std::function<void()> tell_end_;
  std::vector<std::thread> threads_;
};

}  // namespace meshgauge::server
