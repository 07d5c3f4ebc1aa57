// Says once when something that others keep fails, and once when it is back. Thread safe.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>

namespace meshgauge::server::store {

// A line for the log, which callers' errors do not tell: it may name hosts and roles. Called by several threads, one at
// a time of each Outage. Empty: nobody wants to know.
using Report = std::function<void(const std::string& line)>;

class Outage {
 public:
  Outage(std::string what, Report report) : what_(std::move(what)), report_(std::move(report)) {}

  void failed(const std::string& why);  // the whole text
  void over();                          // something succeeded

 private:
  const std::string what_;
  const Report report_;
  std::mutex mutex_;
  std::atomic<bool> out_{false};
};

}  // namespace meshgauge::server::store
