#include "api/processors.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

namespace meshgauge::api {
namespace {

using Time = std::optional<double>;  // number of processors; nullopt: no limit

// Returns quota / period; nullopt: no quota ("max", "-1", no file).
Time time_of(std::istream& quota, std::istream& period) {
  double granted = 0, each = 0;
  if (!(quota >> granted) || !(period >> each) || !(granted > 0) || !(each > 0)) return std::nullopt;
  return granted / each;
}

Time time_of_version_2(const std::string& group) {
  std::ifstream both(group + "/cpu.max");
  return time_of(both, both);
}

Time time_of_version_1(const std::string& group) {
  std::ifstream quota(group + "/cpu.cfs_quota_us"), period(group + "/cpu.cfs_period_us");
  return time_of(quota, period);
}

bool names_cpu(std::string_view controllers) {
  while (!controllers.empty()) {
    const auto end = std::min(controllers.find(','), controllers.size());
    if (controllers.substr(0, end) == "cpu") return true;
    controllers.remove_prefix(std::min(end + 1, controllers.size()));
  }
  return false;
}

Time least_of(Time one, Time other) { return one && other ? std::min(one, other) : one ? one : other; }

// Returns the smallest limit of a group and its ancestors, since a process is in all of them. In a container the path
// may be the host's, of which only the root is visible.
Time least_above(const std::string& mount, std::string path, Time (*time_of_group)(const std::string& group)) {
  Time least = time_of_group(mount);
  for (; !path.empty() && path != "/"; path.resize(std::min(path.rfind('/'), path.size() - 1))) {
    least = least_of(least, time_of_group(mount + path));
  }
  return least;
}

unsigned processors_usable() {
  constexpr std::size_t kMostSets = 64;  // sets of 1024 processors
  for (std::size_t sets = 1; sets <= kMostSets; sets *= 2) {
    std::vector<cpu_set_t> usable(sets);
    const std::size_t bytes = sets * sizeof(cpu_set_t);
    if (::sched_getaffinity(0, bytes, usable.data()) == 0) {
      return static_cast<unsigned>(std::max(1, CPU_COUNT_S(bytes, usable.data())));
    }
    if (errno != EINVAL) break;  // EINVAL: the kernel has more processors than fit
  }
  return static_cast<unsigned>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
}

}  // namespace

unsigned processors() {
  const unsigned usable = processors_usable(), granted = processors_granted();
  return granted == 0 ? usable : std::min(usable, granted);
}

unsigned processors_granted(const std::string& root) {
  Time least;
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // "0::/path", "1:cpu,cpuacct:/path"
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1), path = line.substr(second + 1);
    if (controllers.empty()) {
      least = least_of(least, least_above(root + "/sys/fs/cgroup", path, time_of_version_2));
    } else if (names_cpu(controllers)) {
      least = least_of(least, least_above(root + "/sys/fs/cgroup/cpu", path, time_of_version_1));
    }
  }
  return least ? static_cast<unsigned>(std::ceil(std::min(*least, 1e6))) : 0;
}

}  // namespace meshgauge::api
