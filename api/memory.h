// The memory that a process may use: less than the machine has under a limit of its control groups.
#pragma once

#include <cstdint>
#include <string>

namespace meshgauge::api {

// Returns the smaller of the machine's memory and memory_granted().
std::uint64_t memory_bytes();

// Returns the bytes that this process's control groups grant (memory.max, memory.high; memory.limit_in_bytes in version
// 1); 0: no limit. `root`: folder that contains proc/self/cgroup and sys/fs/cgroup; "" except in tests.
std::uint64_t memory_granted(const std::string& root = "");

}  // namespace meshgauge::api
