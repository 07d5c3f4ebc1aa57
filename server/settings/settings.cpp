#include "server/settings/settings.h"

#include <algorithm>
#include <cstdlib>

namespace meshgauge::server {

std::string default_temp_dir() {
  const char* given = std::getenv("TMPDIR");
  return given && *given ? given : "/tmp";
}

api::RequestLimits request_limits(const Settings& s) {
  using std::chrono::milliseconds;
  return {milliseconds(s.default_timeout_ms), milliseconds(s.max_timeout_ms)};
}

std::uint64_t max_files_sent(const Settings& s) { return std::max<std::uint64_t>(1, s.io_threads / 2); }

api::ReadLimits read_limits(const Settings& s) { return {s.max_vertices, s.max_triangles, s.max_expanded_bytes}; }

}  // namespace meshgauge::server
