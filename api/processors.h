// The number of processors that a process may use: fewer than the machine has under a quota or a CPU affinity.
#pragma once

#include <string>

namespace meshgauge::api {

// Returns the smaller of the process's CPU affinity and its control groups' quota; at least 1.
unsigned processors();

// Returns the processors that this process's control groups grant (version 2, or 1 at its usual path), rounded up; 0:
// no limit. `root`: folder that contains proc/self/cgroup and sys/fs/cgroup; "" except in tests.
unsigned processors_granted(const std::string& root = "");

}  // namespace meshgauge::api
