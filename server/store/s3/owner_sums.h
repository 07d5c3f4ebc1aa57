// The bytes of each owner's blobs, where only a listing tells them. An owner is listed once; then this process adds
// what it puts and subtracts what it removes, and lists again in the background for the changes of other processes.
//
// Error bound: a sum lacks at most what other processes have put since its listing, which is at most kAge old, or kIdle
// times as long as a listing takes. It may be too large for as long: blobs put or removed during a listing count as
// present.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <unordered_map>

#include "engine/result.h"

namespace meshgauge::server::store {

// Thread safe. The destructor waits for a listing in the background.
class OwnerSums {
 public:
  using Weigh = std::function<Result<std::uint64_t>(const std::string& owner)>;
  static constexpr std::chrono::seconds kAge{60};
  static constexpr int kIdle = 20;

  explicit OwnerSums(Weigh weigh, std::chrono::milliseconds age = kAge) : weigh_(std::move(weigh)), age_(age) {}

  ~OwnerSums();
  OwnerSums(const OwnerSums&) = delete;
  OwnerSums& operator=(const OwnerSums&) = delete;

  // Blocks for a listing at the first call for an owner.
  Result<std::uint64_t> of(const std::string& owner);
  void add(const std::string& owner, std::uint64_t bytes);     // call it after the put
  void remove(const std::string& owner, std::uint64_t bytes);  // call it before the removal; add() if that fails

 private:
  using Clock = std::chrono::steady_clock;
  struct Sum {
    bool known = false;
    bool weighing = false;
    std::uint64_t bytes = 0;
    std::uint64_t meanwhile = 0;  // bytes added since the listing began
    Clock::time_point good_until{};
    std::future<void> refresh;
  };

  Result<std::uint64_t> weigh(const std::string& owner);
  Result<std::uint64_t> weighed(const std::string& owner) const;

  const Weigh weigh_;
  const std::chrono::milliseconds age_;
  std::mutex mutex_;
  std::condition_variable weighed_;
  std::unordered_map<std::string, Sum> sums_;  // a node container: elements keep their addresses
};

}  // namespace meshgauge::server::store
