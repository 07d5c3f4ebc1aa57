// What the kernel says of this process.
#pragma once

#include <cstdint>

namespace meshgauge::server {

// 0 where /proc does not say.
struct ProcessFacts {
  std::uint64_t resident_bytes = 0;
  std::uint64_t virtual_bytes = 0;
  std::uint64_t open_descriptors = 0;
  std::uint64_t most_descriptors = 0;
  std::uint64_t threads = 0;
  double cpu_seconds = 0;  // of all threads, user and system
  double started = 0;      // seconds since 1970
};

ProcessFacts process_facts();

}  // namespace meshgauge::server
