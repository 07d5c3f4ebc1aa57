// Resource usage of this process, as the kernel reports it.
#pragma once

#include <cstdint>

namespace meshgauge::server {

// A field is 0 if /proc does not have it.
struct ProcessFacts {
  std::uint64_t resident_bytes = 0;
  std::uint64_t virtual_bytes = 0;
  std::uint64_t open_descriptors = 0;
  std::uint64_t most_descriptors = 0;  // the limit RLIMIT_NOFILE
  std::uint64_t threads = 0;
  double cpu_seconds = 0;  // of all threads, user and system
  double started = 0;      // seconds since 1970
};

ProcessFacts process_facts();

}  // namespace meshgauge::server
