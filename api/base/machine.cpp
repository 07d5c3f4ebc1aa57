#include "api/base/machine.h"

#include <unistd.h>

#ifdef __linux__
#include <sched.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

namespace meshgauge::api {
namespace {

using Limit = std::optional<double>;  // nullopt: no limit

// Returns the smaller limit.
Limit least_of(Limit one, Limit other) { return one && other ? std::min(one, other) : one ? one : other; }

bool names(std::string_view controllers, std::string_view wanted) {
  while (!controllers.empty()) {
    const auto end = std::min(controllers.find(','), controllers.size());
    if (controllers.substr(0, end) == wanted) return true;
    controllers.remove_prefix(std::min(end + 1, controllers.size()));
  }
  return false;
}

// Returns the limit of the group in `folder`.
using GroupLimit = Limit (*)(const std::string& folder);

// Returns the smallest limit of a group and its ancestors, since a process is in all of them. In a container the path
// may be the host's, of which only the root is visible.
Limit least_above(const std::string& mount, std::string path, GroupLimit limit_of) {
  Limit least = limit_of(mount);
  for (; !path.empty() && path != "/"; path.resize(std::min(path.rfind('/'), path.size() - 1))) {
    least = least_of(least, limit_of(mount + path));
  }
  return least;
}

// Returns the smallest limit of the process's groups and their ancestors. `controller`: its name in version 1 ("cpu",
// "memory"). `root`: as in processors_granted().
Limit least_group_limit(const std::string& root, std::string_view controller, GroupLimit of_version_2,
                        GroupLimit of_version_1) {
  Limit least;
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // "0::/path", "1:cpu,cpuacct:/path"
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1), path = line.substr(second + 1);
    const std::string mounts = root + "/sys/fs/cgroup";
    if (controllers.empty()) {
      least = least_of(least, least_above(mounts, path, of_version_2));
    } else if (names(controllers, controller)) {
      least = least_of(least, least_above(mounts + "/" + std::string(controller), path, of_version_1));
    }
  }
  return least;
}

// Returns quota / period; nullopt: no quota ("max", "-1", no file).
Limit time_of(std::istream& quota, std::istream& period) {
  double granted = 0, each = 0;
  if (!(quota >> granted) || !(period >> each) || !(granted > 0) || !(each > 0)) return std::nullopt;
  return granted / each;
}

Limit time_of_version_2(const std::string& group) {
  std::ifstream both(group + "/cpu.max");
  return time_of(both, both);
}

Limit time_of_version_1(const std::string& group) {
  std::ifstream quota(group + "/cpu.cfs_quota_us"), period(group + "/cpu.cfs_period_us");
  return time_of(quota, period);
}

unsigned processors_usable() {
#ifdef __linux__
  constexpr std::size_t kMostSets = 64;  // sets of 1024 processors
  for (std::size_t sets = 1; sets <= kMostSets; sets *= 2) {
    std::vector<cpu_set_t> usable(sets);
    const std::size_t bytes = sets * sizeof(cpu_set_t);
    if (::sched_getaffinity(0, bytes, usable.data()) == 0) {
      return static_cast<unsigned>(std::max(1, CPU_COUNT_S(bytes, usable.data())));
    }
    if (errno != EINVAL) break;  // EINVAL: the kernel has more processors than fit
  }
#endif
  return static_cast<unsigned>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
}

constexpr double kNoLimit = 1e18;  // version 1 has a number near 2^63 where there is no limit

Limit bytes_in(const std::string& file) {
  std::ifstream in(file);
  double bytes = 0;
  return in >> bytes && bytes < kNoLimit ? std::optional(bytes) : std::nullopt;  // "max" is no number
}

// Above memory.high a process is not killed, but hardly runs any more.
Limit memory_of_version_2(const std::string& group) {
  return least_of(bytes_in(group + "/memory.max"), bytes_in(group + "/memory.high"));
}

Limit memory_of_version_1(const std::string& group) { return bytes_in(group + "/memory.limit_in_bytes"); }

}  // namespace

unsigned processors() {
  const unsigned usable = processors_usable(), granted = processors_granted();
  return granted == 0 ? usable : std::min(usable, granted);
}

unsigned processors_granted(const std::string& root) {
  const auto least = least_group_limit(root, "cpu", time_of_version_2, time_of_version_1);
  return least ? static_cast<unsigned>(std::ceil(std::min(*least, 1e6))) : 0;
}

std::uint64_t memory_bytes() {
  const auto pages = static_cast<std::uint64_t>(std::max(1L, ::sysconf(_SC_PHYS_PAGES)));
  const std::uint64_t there = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)), granted = memory_granted();
  return granted == 0 ? there : std::min(there, granted);
}

std::uint64_t memory_granted(const std::string& root) {
  const auto least = least_group_limit(root, "memory", memory_of_version_2, memory_of_version_1);
  return least ? static_cast<std::uint64_t>(*least) : 0;
}

}  // namespace meshgauge::api
