// The date as a seed: a test that tries a slice of what there is tries another one each day.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

namespace meshgauge {

// The environment variable MESHGAUGE_SEED: another day's number, which repeats its slice, or `all`, for no slices.
inline std::string_view seed_that_is_set() {
  const char* seed = std::getenv("MESHGAUGE_SEED");
  return seed ? seed : "";
}

// Returns a number such as 20261129: the one that is set, or else today's date.
inline std::uint64_t today() {
  const std::string_view seed = seed_that_is_set();
  if (!seed.empty() && seed != "all") return std::strtoull(seed.data(), nullptr, 10);
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()));
  return static_cast<std::uint64_t>(static_cast<int>(date.year())) * 10000 + static_cast<unsigned>(date.month()) * 100 +
         static_cast<unsigned>(date.day());
}

// Whether the i-th of many is tried today: one of so many parts is, on other days the others.
inline bool is_of_today(std::uint64_t i, std::uint64_t parts) {
  return i % parts == today() % parts || seed_that_is_set() == "all";
}

// Returns those of the numbers below `end` that are tried today.
inline std::vector<std::uint64_t> todays_part(std::uint64_t end, std::uint64_t parts) {
  std::vector<std::uint64_t> part;
  for (std::uint64_t i = 0; i < end; ++i) {
    if (is_of_today(i, parts)) part.push_back(i);
  }
  return part;
}

}  // namespace meshgauge
