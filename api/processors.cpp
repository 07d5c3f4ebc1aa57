#include "api/processors.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <optional>
#include <vector>

#include "api/control_groups.h"

namespace meshgauge::api {
namespace {

// Returns quota / period; nullopt: no quota ("max", "-1", no file).
std::optional<double> time_of(std::istream& quota, std::istream& period) {
  double granted = 0, each = 0;
  if (!(quota >> granted) || !(period >> each) || !(granted > 0) || !(each > 0)) return std::nullopt;
  return granted / each;
}

std::optional<double> time_of_version_2(const std::string& group) {
  std::ifstream both(group + "/cpu.max");
  return time_of(both, both);
}

std::optional<double> time_of_version_1(const std::string& group) {
  std::ifstream quota(group + "/cpu.cfs_quota_us"), period(group + "/cpu.cfs_period_us");
  return time_of(quota, period);
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
  const auto least = least_group_limit(root, "cpu", time_of_version_2, time_of_version_1);
  return least ? static_cast<unsigned>(std::ceil(std::min(*least, 1e6))) : 0;
}

}  // namespace meshgauge::api
