// To wait for what changes by itself.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace meshgauge {

// Whether the condition holds within a minute: longer than anything takes that the tests wait for.
inline bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace meshgauge
