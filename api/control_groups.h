// The limits that this process's control groups set, of version 2, or 1 at its usual paths.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace meshgauge::api {

// Returns the smaller limit; nullopt: no limit.
inline std::optional<double> least_of(std::optional<double> one, std::optional<double> other) {
  return one && other ? std::min(one, other) : one ? one : other;
}

// Returns the limit of the group in `folder`; nullopt: none.
using GroupLimit = std::optional<double> (*)(const std::string& folder);

// Returns the smallest limit of the process's groups and their ancestors; nullopt: no limit. `controller`: its name in
// version 1 ("cpu", "memory"). `root`: folder that contains proc/self/cgroup and sys/fs/cgroup; "" except in tests.
std::optional<double> least_group_limit(const std::string& root, std::string_view controller, GroupLimit of_version_2,
                                        GroupLimit of_version_1);

}  // namespace meshgauge::api
