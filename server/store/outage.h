// Reports once when another service fails, and once when it is back. Thread safe.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>

namespace meshgauge::server::store {

// Takes a line for the log, which may name hosts and roles: callers' errors do not. Called by several threads; each
// Outage calls it on one thread at a time. Empty: lines are dropped.
using Report = std::function<void(const std::string& line)>;

class Outage {
 public:
  Outage(std::string what, Report report) : what_(std::move(what)), report_(std::move(report)) {}

  void failed(const std::string& why);
  void over();  // a call succeeded

 private:
  const std::string what_;
  const Report report_;
  std::mutex mutex_;
  std::atomic<bool> out_{false};
};

}  // namespace meshgauge::server::store
