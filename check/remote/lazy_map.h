// Computes a value once for each name: the first thread that needs it computes, the others wait.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "check/remote/client.h"
#include "engine/control.h"
#include "engine/result.h"
#include "engine/tree/lazy.h"

namespace meshgauge::check::service {

// Thread safe. After an Error the next caller tries again. A waiting thread gives up when it is cancelled.
template <class T>
class LazyMap {
 public:
  Result<T> get(const std::string& name, Control& control, const std::function<Result<T>()>& make) {
    std::optional<Error> failed;
    const auto slot = slot_of(name);
    const T* value = slot->get([&] { return control.check() == Interruption::cancelled; },
                               [&]() -> std::unique_ptr<const T> {
                                 Result<T> made = make();
                                 if (made) return std::make_unique<const T>(*std::move(made));
                                 failed = made.error();
                                 return nullptr;
                               });
    if (value) return *value;
    return failed ? *failed : cancelled();
  }

  void forget_all() {
    const std::lock_guard lock(mutex_);
    slots_.clear();
  }

  void forget(const std::string& name) {
    const std::lock_guard lock(mutex_);
    slots_.erase(name);
  }

 private:
  std::shared_ptr<Lazy<T>> slot_of(const std::string& name) {
    const std::lock_guard lock(mutex_);
    auto& slot = slots_[name];
    if (!slot) slot = std::make_shared<Lazy<T>>();
    return slot;
  }

  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Lazy<T>>> slots_;
};

}  // namespace meshgauge::check::service
