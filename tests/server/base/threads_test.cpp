#include "server/base/threads.h"

#include <condition_variable>
#include <mutex>
#include <stdexcept>

#include <doctest/doctest.h>

using meshgauge::server::Threads;

namespace {

// Starts two threads in its constructor, which wait to be ended, and throws as where the system grants no third.
class Refused {
 public:
  explicit Refused(int& ended) : ended_(ended), threads_([this] { tell_end(); }) {
    for (int i = 0; i < 2; ++i) threads_.start([this] { wait(); });
    throw std::runtime_error("no further thread");
  }

 private:
  void tell_end() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [this] { return ending_; });
    ++ended_;
  }

  int& ended_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  Threads threads_;
};

}  // namespace

TEST_CASE("threads: those of a constructor that throws are ended") {
  int ended = 0;
  CHECK_THROWS_AS(Refused{ended}, std::runtime_error);
  CHECK(ended == 2);
}

TEST_CASE("threads: without any nothing is told to end") {
  int told = 0;
  {
    Threads threads([&] { ++told; });
    CHECK(threads.empty());
    threads.end();
  }
  CHECK(told == 0);
  Threads threads([&] { ++told; });
  threads.start([] {});
  CHECK_FALSE(threads.empty());
  threads.end();
  CHECK(threads.empty());
  threads.end();
  CHECK(told == 1);
}
