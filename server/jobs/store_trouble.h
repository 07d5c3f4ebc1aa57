// Failures of the store: each is counted, whatever becomes of it, and told to the log; the same one not again and
// again. Thread safe.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "engine/result.h"
#include "server/observe/metrics.h"

namespace meshgauge::server {

class StoreTrouble {
 public:
  explicit StoreTrouble(Metrics& metrics) : metrics_(metrics) {}

  void tell(const Error& error);

 private:
  Metrics& metrics_;
  std::mutex mutex_;
  std::string last_;
  std::chrono::steady_clock::time_point told_{};
};

}  // namespace meshgauge::server
