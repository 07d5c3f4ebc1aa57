// The date as a seed: a test that tries a slice of what there is tries another one each day.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdlib>

namespace meshgauge {

// Returns a number such as 20261129: the environment variable MESHGAUGE_SEED, which repeats another day's slice, or
// else today's date.
inline std::uint64_t today() {
  if (const char* seed = std::getenv("MESHGAUGE_SEED")) return std::strtoull(seed, nullptr, 10);
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()));
  return static_cast<std::uint64_t>(static_cast<int>(date.year())) * 10000 + static_cast<unsigned>(date.month()) * 100 +
         static_cast<unsigned>(date.day());
}

}  // namespace meshgauge
