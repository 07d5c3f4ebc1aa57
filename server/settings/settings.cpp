#include "server/settings/settings.h"

#include <sys/vfs.h>

#include <linux/magic.h>

#include <algorithm>
#include <cstdlib>

#include "api/base/machine.h"
#include "engine/mesh.h"

namespace meshgauge::server {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kLeastPlanned = 128 * kMiB;
constexpr std::uint64_t kLeastOfParser = 32 * kMiB;
constexpr std::uint64_t kBesideJobs = 64 * kMiB;                // the service itself, and readers that wait
constexpr std::uint64_t kMarginShare = 16;                      // of the machine: what no estimate sees
constexpr std::uint64_t kCacheShare = 8;                        // of the machine, at most
constexpr std::uint64_t kUploadShare = 4;                       // of the machine, at most, on a tmpfs
constexpr std::uint64_t kHeapShare = 4;                         // of max_memory_bytes, for the searches of all threads
constexpr std::uint64_t kBesideArrays = 256 * kMiB;             // of a reader: the program, and its own tables
constexpr std::uint64_t kMostIndices = std::uint64_t{1} << 32;  // an index has 32 bits
constexpr std::uint64_t kMostOfParser = std::uint64_t{1} << 46;

// What a reader may need for a file that reaches all limits: the expanded file, and each array twice while it grows or
// vertices are welded. An uncompressed file is mapped and does not count.
std::uint64_t memory_of_a_parser(const Settings& s) {
  const std::uint64_t arrays = std::min(s.max_vertices, kMostIndices) * sizeof(Vec3) +
                               std::min(s.max_triangles, kMostIndices) * sizeof(Triangle);
  return std::min(std::min(s.max_expanded_bytes, kMostOfParser) + 2 * arrays + kBesideArrays, kMostOfParser);
}

std::string megabytes(std::uint64_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; }

}  // namespace

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

MachineMemory machine_memory(const std::string& temp_dir) {
  struct statfs disk {};
  const bool is_tmpfs = ::statfs(temp_dir.c_str(), &disk) == 0 && disk.f_type == TMPFS_MAGIC;
  return {api::memory_bytes(), is_tmpfs};
}

void plan_memory(const MachineMemory& machine, Settings& s) {
  s.max_cache_bytes = std::min(s.max_cache_bytes, machine.bytes / kCacheShare);
  if (machine.uploads_take_memory) s.max_upload_bytes = std::min(s.max_upload_bytes, machine.bytes / kUploadShare);
  if (s.max_memory_bytes == 0) {
    const std::uint64_t others = kBesideJobs + machine.bytes / kMarginShare + s.max_cache_bytes +
                                 (machine.uploads_take_memory ? s.max_upload_bytes : 0);
    s.max_memory_bytes = std::max(kLeastPlanned, machine.bytes - std::min(machine.bytes, others));
  }
  s.max_heap_bytes = std::min(s.max_heap_bytes, s.max_memory_bytes / (kHeapShare * (s.workers + kGuests)));
  if (s.parser_memory_bytes == 0)
    s.parser_memory_bytes = std::max(kLeastOfParser, std::min(memory_of_a_parser(s), s.max_memory_bytes / 2));
}

std::uint64_t memory_for_meshes(const Settings& s) {
  return s.max_memory_bytes - s.max_heap_bytes * (s.workers + kGuests);
}

std::string memory_text(const Settings& s) {
  const MachineMemory machine = machine_memory(s.temp_dir);
  return "of " + megabytes(machine.bytes) + ": comparisons and readers " + megabytes(s.max_memory_bytes) +
         ", of that each search " + megabytes(s.max_heap_bytes) + ", each reader " + megabytes(s.parser_memory_bytes) +
         "; beside them cached meshes " + megabytes(s.max_cache_bytes) +
         (machine.uploads_take_memory ? " and uploads " + megabytes(s.max_upload_bytes) : "");
}

}  // namespace meshgauge::server
