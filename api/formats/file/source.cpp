#include "api/formats/file/source.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace meshgauge::api {
namespace {

// Counts lines like the readers: lines end with \n, \r\n or \r.
std::size_t line_number(const Source& source, const char* place) {
  std::size_t line = 1;
  for (const char* p = source.begin(); p < place; ++p) {
    line += *p == '\n' || (*p == '\r' && (p + 1 == source.end() || p[1] != '\n'));
  }
  return line;
}

}  // namespace

Error at(const Source& source, std::string where, ErrorCode code, const std::string& what) {
  std::string message = where + " of '" + std::string(source.part) + "': " + what;
  return Error{code, std::move(message), std::string(source.part), std::move(where)};
}

Error at_line(const Source& source, const char* place, ErrorCode code, const std::string& what) {
  return at(source, "line " + std::to_string(line_number(source, place)), code, what);
}

Error at_byte(const Source& source, std::size_t offset, ErrorCode code, const std::string& what) {
  return at(source, "byte " + std::to_string(offset), code, what);
}

Error about(std::string_view part, ErrorCode code, const std::string& what) {
  return Error{code, "'" + std::string(part) + "' " + what, std::string(part), ""};
}

Error out_of_memory(std::string_view part) {
  return about(part, ErrorCode::too_large, "needs more memory than is available");
}

Error too_many(const Source& source, std::string_view things, std::size_t limit) {
  return about(source.part, ErrorCode::too_large,
               "has more " + std::string(things) + " than the limit of " + std::to_string(limit));
}

std::size_t vertex_limit(const Source& source) {
  return std::min<std::size_t>(source.limits.max_vertices, std::numeric_limits<std::uint32_t>::max());
}

std::size_t expansion_limit(std::size_t compressed_bytes, const ReadLimits& limits) {
  constexpr std::uint64_t kFreeOfRatio = std::uint64_t{64} << 20U;
  constexpr std::uint64_t kMostRatio = 200;
  constexpr std::uint64_t kMostOfArray = std::numeric_limits<std::ptrdiff_t>::max();  // less than 4 GiB on 32 bits
  // min() keeps the product within 64 bits.
  const std::uint64_t by_ratio = kMostRatio * std::min<std::uint64_t>(compressed_bytes, kFreeOfRatio * kMostRatio);
  const std::uint64_t allowed = std::min(limits.max_expanded_bytes, std::max(kFreeOfRatio, by_ratio));
  return static_cast<std::size_t>(std::min(allowed, kMostOfArray));
}

Error expands_too_far(std::string_view part, std::size_t limit, std::size_t compressed_bytes, std::string_view kind) {
  return about(part, ErrorCode::too_large,
               "expands to more than " + std::to_string(limit) + " bytes, from " + std::to_string(compressed_bytes) +
                   " bytes of " + std::string(kind));
}

std::size_t length_without_padding(std::string_view bytes) {
  std::size_t length = bytes.size();
  for (std::size_t i = bytes.size(); i > 0; --i) {
    const char c = bytes[i - 1];
    const bool padding = c == '\0' || c == '\x1A';
    if (!padding && !is_space(c)) break;
    if (padding) length = i - 1;
  }
  return bytes.size() - length <= kMostPadding ? length : bytes.size();
}

Result<ReadMesh> read_without_padding(const Source& source,
                                      const std::function<Result<ReadMesh>(const Source&)>& read) {
  const std::size_t length = length_without_padding(source.text());
  auto result = read(Source{source.bytes.first(length), source.part, source.limits});
  if (result && length < source.bytes.size()) {
    result->notes.remarks.emplace_back("NUL or 0x1A bytes after the last line, ignored");
  }
  return result;
}

Result<Done> make_cloud(const Source& source, ReadMesh& read) {
  if (!read.unread.empty()) return Done{};
  const std::size_t points = read.mesh.positions.size();
  if (points > source.limits.max_triangles) return too_many(source, "points", source.limits.max_triangles);
  read.mesh.triangles = points_as_triangles(points);
  read.notes.cloud = points > 0;
  return Done{};
}

void advise_huge_pages(void* block, std::size_t bytes) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20U;
  constexpr std::size_t kPage = 4096;
  if (bytes < 2 * kHugePage || std::align(kPage, kPage, block, bytes) == nullptr) return;
#ifdef __linux__
  static_cast<void>(madvise(block, bytes / kPage * kPage, MADV_HUGEPAGE));
#endif
}

}  // namespace meshgauge::api
