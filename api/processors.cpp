#include "api/processors.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <vector>

namespace meshgauge::api {

unsigned usable_processors() {
  constexpr std::size_t kMostSets = 64;  // of 1024 processors each
  for (std::size_t sets = 1; sets <= kMostSets; sets *= 2) {
    std::vector<cpu_set_t> usable(sets);
    const std::size_t bytes = sets * sizeof(cpu_set_t);
    if (::sched_getaffinity(0, bytes, usable.data()) == 0) {
      return static_cast<unsigned>(std::max(1, CPU_COUNT_S(bytes, usable.data())));
    }
    if (errno != EINVAL) break;  // else the kernel has more than fit
  }
  return static_cast<unsigned>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
}

}  // namespace meshgauge::api
