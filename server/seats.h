// Connections that may be held for long without work of their client's, a file that is taken slowly for instance.
// There are only so many, and one key of several has half of them at most. Thread safe.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace meshgauge::server {

class Seats {
 public:
  explicit Seats(std::uint64_t most) : most_(most) {}  // must outlive what it gives

  // Given back when the last copy goes; null: there is none for this owner now. May throw: out of memory.
  std::shared_ptr<const void> take(const std::string& owner);  // empty: no key, who may have all

  std::uint64_t taken() const;

 private:
  bool add(const std::string& owner);
  void give_back(const std::string& owner);

  const std::uint64_t most_;
  mutable std::mutex mutex_;  // guards what follows
  std::uint64_t taken_ = 0;
  std::map<std::string, std::uint64_t> taken_by_;  // never 0
};

}  // namespace meshgauge::server
