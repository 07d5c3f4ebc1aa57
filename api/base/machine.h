// The processors and the memory that a process may use: less than the machine has where the process's control groups
// (version 2, or version 1 at its usual paths) set a limit.
#pragma once

#include <cstdint>
#include <string>

namespace meshgauge::api {

// Returns the smaller of the process's CPU affinity and its control groups' quota; at least 1.
unsigned processors();

// Returns the processors that this process's control groups grant, rounded up; 0: no limit. `root`: folder that
// contains proc/self/cgroup and sys/fs/cgroup; "" except in tests.
unsigned processors_granted(const std::string& root = "");

// Returns the smaller of the machine's memory and memory_granted().
std::uint64_t memory_bytes();

// Returns the bytes that this process's control groups grant (memory.max, memory.high; memory.limit_in_bytes in version
// 1); 0: no limit. `root` as above.
std::uint64_t memory_granted(const std::string& root = "");

}  // namespace meshgauge::api
