// A counting semaphore with a limit per key (an API key or a client address) and one for all keys together. Thread
// safe.
//
// A slow client occupies a thread while its bytes are awaited. Deadlines bound that for one connection; this limit
// bounds it for one client, so that no single client can occupy every thread.
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
  // Must outlive the places that take() returns.
  explicit ConnectionLimit(std::uint64_t max_per_key,
                           std::uint64_t max_total = std::numeric_limits<std::uint64_t>::max())
      : max_per_key_(max_per_key), max_total_(max_total) {}

  // A limit of `max_total`, of which one key may take half (rounded up).
  static ConnectionLimit shared(std::uint64_t max_total) { return ConnectionLimit((max_total + 1) / 2, max_total); }

  // Takes a place for `key`; it is given back when the last copy of the pointer is destroyed. Returns null when a limit
  // is reached. The empty key has no limit of its own. Does not block. May throw: out of memory.
  std::shared_ptr<const void> take(const std::string& key);

  std::uint64_t taken() const;

 private:
  bool add(const std::string& key);
  void give_back(const std::string& key);

  const std::uint64_t max_per_key_, max_total_;
  mutable std::mutex mutex_;  // guards what follows
  std::uint64_t taken_ = 0;
  std::map<std::string, std::uint64_t> taken_by_;  // entries of 0 are erased, so that the map cannot grow for ever
};

}  // namespace meshgauge::server
