// Signals within one process, on the sender's thread.
#pragma once

#include <mutex>
#include <utility>

#include "server/store/signals.h"

namespace meshgauge::server::store {

class MemorySignals final : public Signals {
 public:
  void listen(Hear hear) override {
    const std::lock_guard lock(mutex_);
    hear_ = std::move(hear);
  }
  void stop_listening() override { listen(nullptr); }

  void tell(Signal::Kind kind, const JobKey& job = {}) {
    const std::lock_guard lock(mutex_);
    if (hear_) hear_({kind, job});
  }

 private:
  std::mutex mutex_;  // held while `hear_` runs
  Hear hear_;
};

}  // namespace meshgauge::server::store
