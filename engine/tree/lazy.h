// Single flight: a value that one thread makes on first use while the others wait, and that never changes afterwards.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include "engine/control.h"

namespace meshgauge {

template <class T>
class Lazy {
 public:
  // Returns the value. If there is none yet, calls make(), which returns a std::unique_ptr<const T>; on null nothing is
  // kept, and a waiting call makes the value instead. Returns nullptr if make() returned null, or if `interrupted`,
  // polled every 10 ms while another thread makes the value, returned true. Throws what make() throws. Thread safe.
  template <class Make>
  const T* get(const Interrupted& interrupted, Make&& make) {
    if (const T* known = peek()) return known;
    if (!begin(interrupted)) return peek();
    Turn turn(*this);
    turn.made = make();
    return turn.made.get();
  }

  const T* peek() const { return value_.load(std::memory_order_acquire); }  // nullptr: not made yet

 private:
  static constexpr std::chrono::milliseconds kTick{10};

  // Ends the making in its destructor: stores what was made, or nothing if make() threw.
  struct Turn {
    explicit Turn(Lazy& of) : made_for(of) {}
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() { made_for.end(std::move(made)); }

    Lazy& made_for;
    std::unique_ptr<const T> made;
  };

  // True: the caller must make the value. False: the value is there, or the caller was interrupted while waiting.
  bool begin(const Interrupted& interrupted) {
    std::unique_lock lock(mutex_);
    while (making_) {
      if (interrupted()) return false;
      changed_.wait_for(lock, kTick);
    }
    if (owned_) return false;
    return making_ = true;
  }

  void end(std::unique_ptr<const T> made) {
    const std::lock_guard lock(mutex_);
    making_ = false;
    owned_ = std::move(made);
    value_.store(owned_.get(), std::memory_order_release);
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool making_ = false;
  std::unique_ptr<const T> owned_;
  std::atomic<const T*> value_{nullptr};
};

}  // namespace meshgauge
