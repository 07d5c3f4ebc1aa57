// Single flight: a value that is made when it is first asked for, by one thread while the others wait, and never
// changes afterwards.
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
  // The value. If there is none yet, make() makes it: a std::unique_ptr<const T>, null when it was interrupted. Then
  // nothing is kept, and one of those who waited makes it. Null: make() gave none, or `interrupted`, asked every 10 ms
  // while another thread makes it, said so. What make() throws is thrown here. Thread safe.
  template <class Make>
  const T* get(const Interrupted& interrupted, Make&& make) {
    if (const T* known = peek()) return known;
    if (!begin(interrupted)) return peek();
    Turn turn(*this);
    turn.made = make();
    return turn.made.get();
  }

  const T* peek() const { return value_.load(std::memory_order_acquire); }  // null: not made yet

 private:
  static constexpr std::chrono::milliseconds kTick{10};

  // Hands in what was made, be it nothing because make() threw.
  struct Turn {
    explicit Turn(Lazy& of) : made_for(of) {}
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() { made_for.end(std::move(made)); }

    Lazy& made_for;
    std::unique_ptr<const T> made;
  };

  // True: it is the caller's to make. False: it is there, or the caller was interrupted while another was making it.
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
