// What is made once for each name, by the first who needs it; the others wait.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "check/remote/client.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// Thread safe. An Error is for its maker alone: the next one tries again. Who waits gives up when it is cancelled.
template <class T>
class Once {
 public:
  Result<T> get(const std::string& name, Control& control, const std::function<Result<T>()>& make) {
    std::unique_lock lock(mutex_);
    for (Slot* slot = &slots_[name];; changed_.wait_for(lock, kTick)) {
      if (slot->value) return *slot->value;
      if (!slot->busy) break;
      if (control.check() == Interruption::cancelled) return cancelled();
    }
    Making making(*this, lock, name);
    Result<T> made = make();
    if (made) making.value = *made;
    return made;
  }

  void forget_all() {
    const std::lock_guard lock(mutex_);
    for (auto& [name, slot] : slots_) slot.value.reset();
  }

  void forget(const std::string& name) {
    const std::lock_guard lock(mutex_);
    slots_[name].value.reset();
  }

 private:
  static constexpr std::chrono::milliseconds kTick{10};

  struct Slot {
    bool busy = false;
    std::optional<T> value;
  };

  // The mutex is not held while it lives; an exception of `make` leaves the slot for the next one.
  struct Making {
    Making(Once& its_owner, std::unique_lock<std::mutex>& its_lock, const std::string& name)
        : owner(its_owner), lock(its_lock), slot(its_owner.slots_[name]) {
      slot.busy = true;
      lock.unlock();
    }
    ~Making() {
      lock.lock();
      slot.busy = false;
      slot.value = std::move(value);
      owner.changed_.notify_all();
    }
    Making(const Making&) = delete;
    Making& operator=(const Making&) = delete;

    Once& owner;
    std::unique_lock<std::mutex>& lock;
    Slot& slot;
    std::optional<T> value;
  };

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::map<std::string, Slot> slots_;  // their places do not change
};

}  // namespace meshgauge::check::service
