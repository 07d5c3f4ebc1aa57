// The date as a seed: a test that tries a slice of what there is tries another one each day.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace meshgauge {

// Returns a number such as 20261129: the environment variable MESHGAUGE_SEED, which repeats another day's slice, or
// else today's date.
inline std::uint64_t today() {
  if (const char* seed = std::getenv("MESHGAUGE_SEED")) return std::strtoull(seed, nullptr, 10);
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()));
  return static_cast<std::uint64_t>(static_cast<int>(date.year())) * 10000 + static_cast<unsigned>(date.month()) * 100 +
         static_cast<unsigned>(date.day());
}

// Returns every `parts`-th of the numbers below `end`: on other days the others.
inline std::vector<std::uint64_t> todays_part(std::uint64_t end, std::uint64_t parts) {
  std::vector<std::uint64_t> part;
  for (std::uint64_t i = today() % parts; i < end; i += parts) part.push_back(i);
  return part;
}

}  // namespace meshgauge
