// Counts and logs errors of the store. Repetitions of one message are logged once in a while. Thread safe.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "engine/result.h"
#include "server/observe/metrics.h"

namespace meshgauge::server {

class StoreErrors {
 public:
  explicit StoreErrors(Metrics& metrics) : metrics_(metrics) {}  // borrows it

  // Notes the error of any Result, if it has one.
  void note(const auto& result) {
    if (!result) failed(result.error());
  }

 private:
  void failed(const Error& error);

  Metrics& metrics_;
  std::mutex mutex_;
  std::string last_;
  std::chrono::steady_clock::time_point logged_;
};

}  // namespace meshgauge::server
