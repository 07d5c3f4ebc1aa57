#include "api/control_groups.h"

#include <algorithm>
#include <fstream>

namespace meshgauge::api {
namespace {

using Limit = std::optional<double>;

bool names(std::string_view controllers, std::string_view wanted) {
  while (!controllers.empty()) {
    const auto end = std::min(controllers.find(','), controllers.size());
    if (controllers.substr(0, end) == wanted) return true;
    controllers.remove_prefix(std::min(end + 1, controllers.size()));
  }
  return false;
}

// Returns the smallest limit of a group and its ancestors, since a process is in all of them. In a container the path
// may be the host's, of which only the root is visible.
Limit least_above(const std::string& mount, std::string path, GroupLimit limit_of) {
  Limit least = limit_of(mount);
  for (; !path.empty() && path != "/"; path.resize(std::min(path.rfind('/'), path.size() - 1))) {
    least = least_of(least, limit_of(mount + path));
  }
  return least;
}

}  // namespace

std::optional<double> least_group_limit(const std::string& root, std::string_view controller, GroupLimit of_version_2,
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

}  // namespace meshgauge::api
