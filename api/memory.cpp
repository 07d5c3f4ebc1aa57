#include "api/memory.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <optional>

#include "api/control_groups.h"

namespace meshgauge::api {
namespace {

constexpr double kNoLimit = 1e18;  // version 1 has a number near 2^63 where there is no limit

std::optional<double> bytes_in(const std::string& file) {
  std::ifstream in(file);
  double bytes = 0;
  return in >> bytes && bytes < kNoLimit ? std::optional(bytes) : std::nullopt;  // "max" is no number
}

// Above memory.high a process is not killed, but hardly runs any more.
std::optional<double> limit_of_version_2(const std::string& group) {
  return least_of(bytes_in(group + "/memory.max"), bytes_in(group + "/memory.high"));
}

std::optional<double> limit_of_version_1(const std::string& group) {
  return bytes_in(group + "/memory.limit_in_bytes");
}

}  // namespace

std::uint64_t memory_bytes() {
  const auto pages = static_cast<std::uint64_t>(std::max(1L, ::sysconf(_SC_PHYS_PAGES)));
  const std::uint64_t there = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)), granted = memory_granted();
  return granted == 0 ? there : std::min(there, granted);
}

std::uint64_t memory_granted(const std::string& root) {
  const auto least = least_group_limit(root, "memory", limit_of_version_2, limit_of_version_1);
  return least ? static_cast<std::uint64_t>(*least) : 0;
}

}  // namespace meshgauge::api
