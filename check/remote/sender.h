// Uploads the mesh files of a run: hashes each file once and sends it at most once.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "check/gate.h"
#include "check/remote/client.h"
#include "engine/control.h"
#include "engine/result.h"
#include "engine/tree/lazy.h"

namespace meshgauge::check::service {

// Computes a value once for each name: the first thread that needs it computes, the others wait. Thread safe. After an
// Error the next caller tries again. A waiting thread gives up when it is cancelled.
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

// Thread safe. Errors name the file, or are about the service.
class Sender {
 public:
  explicit Sender(Client& client) : client_(client) {}

  enum class Part { candidate, baseline };

  // Stores the gate's mesh at the service and returns its id. Blocks.
  Result<std::string> stored(const Gate& gate, Part part, Control& control);

  // Forgets which meshes were delivered; the service is asked again for each.
  void doubt() { delivered_.forget_all(); }

 private:
  Result<std::string> hash(const Gate& gate, const std::filesystem::path& file, Control& control);
  Result<Done> deliver(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control);
  Result<Done> put(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control);

  Client& client_;
  LazyMap<std::string> ids_;  // by path
  LazyMap<Done> delivered_;   // by id
};

}  // namespace meshgauge::check::service
