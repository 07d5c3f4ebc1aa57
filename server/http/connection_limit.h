// How many connections may be held at the same time, of each key or address and of all together. Thread safe.
//
// A slow client costs a thread for as long as its bytes are waited for, and a file that is taken slowly a connection.
// Deadlines bound that for one connection; this bounds it for one client, so that no single one can hold every thread.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace meshgauge::server {

class ConnectionLimit {
 public:
  // Must outlive what it gives.
  explicit ConnectionLimit(std::uint64_t max_per_key,
                           std::uint64_t max_total = std::numeric_limits<std::uint64_t>::max())
      : max_per_key_(max_per_key), max_total_(max_total) {}

  // `max_total` together, and one key of several has half of them at most.
  static ConnectionLimit shared(std::uint64_t max_total) { return ConnectionLimit((max_total + 1) / 2, max_total); }

  // Given back when the last copy goes; null: there is none for this key now. The empty key, which is no key, may have
  // all. May throw: out of memory.
  std::shared_ptr<const void> take(const std::string& key);

  std::uint64_t taken() const;

 private:
  bool add(const std::string& key);
  void give_back(const std::string& key);

  const std::uint64_t max_per_key_, max_total_;
  mutable std::mutex mutex_;  // guards what follows
  std::uint64_t taken_ = 0;
  std::map<std::string, std::uint64_t> taken_by_;  // never 0: else every address that ever called would stay
};

}  // namespace meshgauge::server
