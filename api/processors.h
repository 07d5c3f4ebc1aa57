// The processors that a process may use: in a container, under a quota or bound to some, these are fewer than the
// machine has.
#pragma once

#include <string>

namespace meshgauge::api {

// Those it may run on, or as many as its control groups grant the time of, whichever is fewer; at least 1.
unsigned processors();

// What the control groups of this process grant (version 2, or 1 in its usual place), a part of a processor counted as
// one; 0: no limit. `root` is "" but for tests: the folder that has proc/self/cgroup and sys/fs/cgroup.
unsigned processors_granted(const std::string& root = "");

}  // namespace meshgauge::api
