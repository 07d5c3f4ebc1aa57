// What each owner's blobs take, where finding out means to list them: found out once, kept up by what this process puts
// and removes, and found out again in the background for what others do.
//
// A sum is too small at most by what other processes have put since the listing that it goes by: kAge, or kIdle times
// as long as that took, before the newest question. It may be too large for as long: what is put or removed during a
// listing counts as if it were there.
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

// Thread safe. Its end waits for a listing in the background.
class OwnerSums {
 public:
  using Weigh = std::function<Result<std::uint64_t>(const std::string& owner)>;
  static constexpr std::chrono::seconds kAge{60};
  static constexpr int kIdle = 20;

  explicit OwnerSums(Weigh weigh, std::chrono::milliseconds age = kAge) : weigh_(std::move(weigh)), age_(age) {}

  ~OwnerSums();
  OwnerSums(const OwnerSums&) = delete;
  OwnerSums& operator=(const OwnerSums&) = delete;

  // Waits for a listing only when there was none of this owner yet.
  Result<std::uint64_t> of(const std::string& owner);
  void add(const std::string& owner, std::uint64_t bytes);     // after they were put
  void remove(const std::string& owner, std::uint64_t bytes);  // before they are removed; add() when that fails

 private:
  using Clock = std::chrono::steady_clock;
  struct Sum {
    bool known = false;
    bool weighing = false;
    std::uint64_t bytes = 0;
    std::uint64_t meanwhile = 0;  // added since the listing began
    Clock::time_point good_until{};
    std::future<void> refresh;
  };

  Result<std::uint64_t> weigh(const std::string& owner);
  Result<std::uint64_t> weighed(const std::string& owner) const;

  const Weigh weigh_;
  const std::chrono::milliseconds age_;
  std::mutex mutex_;
  std::condition_variable weighed_;
  std::unordered_map<std::string, Sum> sums_;  // whose elements stay where they are
};

}  // namespace meshgauge::server::store
