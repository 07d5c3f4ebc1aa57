// Bytes that several threads may hold together.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace meshgauge::api {

// Thread safe.
class ByteBudget {
 public:
  using Lease = std::shared_ptr<const void>;  // gives the bytes back when the last copy goes

  explicit ByteBudget(std::uint64_t bytes) : left_(bytes) {}

  // Returns null when so many are not left. The lease keeps the budget.
  static Lease take(const std::shared_ptr<ByteBudget>& budget, std::uint64_t bytes) {
    std::uint64_t left = budget->left_;
    do {
      if (bytes > left) return nullptr;
    } while (!budget->left_.compare_exchange_weak(left, left - bytes));
    return {budget.get(), [budget, bytes](const void*) { budget->left_ += bytes; }};
  }

 private:
  std::atomic<std::uint64_t> left_;
};

}  // namespace meshgauge::api
