#include "tests/api/formats/admesh_peer.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include <admesh/stl.h>

namespace meshgauge::api::test {
namespace {

// libadmesh opens files by their names.
class NamedBytes {
 public:
  explicit NamedBytes(std::string_view bytes) : fd_(::memfd_create("stl", MFD_CLOEXEC)) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
      if (written <= 0) throw std::runtime_error("memfd");
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  ~NamedBytes() { ::close(fd_); }
  NamedBytes(const NamedBytes&) = delete;
  NamedBytes& operator=(const NamedBytes&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

// The range that libadmesh searches for a byte that no text has, to tell binary from ASCII.
constexpr std::size_t kLookFrom = HEADER_SIZE;
constexpr std::size_t kLookBytes = 128;

std::string_view excuse_of_ascii(std::string_view file, std::size_t facets) {
  if (file.find('\n') == std::string_view::npos) return "lines that end by a carriage return";
  std::size_t lines = 0;  // lines of more than four characters, line end included
  for (std::size_t start = 0, end = 0; (end = file.find('\n', start)) != std::string_view::npos; start = end + 1) {
    lines += end - start + 1 > 4;
  }
  if ((lines + 1) / ASCII_LINES_PER_FACET != facets) return "a facet that is not seven lines";
  std::size_t ends = 0;
  for (const std::string_view word : {"endsolid", "ENDSOLID"}) {
    for (std::size_t at = 0; (at = file.find(word, at)) != std::string_view::npos; ++at) ++ends;
  }
  return ends == 1 ? "" : "several solids";
}

Facet corners_of(const stl_facet& facet) {
  Facet out;
  float* next = out.data();
  for (const stl_vertex& corner : facet.vertex) {
    *next++ = corner.x;
    *next++ = corner.y;
    *next++ = corner.z;
  }
  return out;
}

}  // namespace

std::optional<std::vector<Facet>> by_admesh(std::string_view file) {
  const NamedBytes bytes(file);
  std::string path = bytes.path();
  stl_file stl{};
  stl_open(&stl, path.data());
  if (stl_get_error(&stl) != 0) return std::nullopt;
  std::vector<Facet> facets;
  for (int i = 0; i < stl.stats.number_of_facets; ++i) facets.push_back(corners_of(stl.facet_start[i]));
  stl_close(&stl);
  return facets;
}

std::string_view admesh_excuse(std::string_view file, std::size_t facets) {
  if (file.size() < kLookFrom + kLookBytes) return "a file of fewer than 212 bytes";
  const std::string_view looked_at = file.substr(kLookFrom, kLookBytes);
  const bool taken_for_binary = std::ranges::any_of(looked_at, [](char c) { return static_cast<signed char>(c) < 0; });
  const bool is_binary = file.size() == HEADER_SIZE + SIZEOF_STL_FACET * facets;
  if (is_binary != taken_for_binary) return "binary and ASCII told apart by 128 bytes";
  if (!is_binary) return excuse_of_ascii(file, facets);
  return file.size() < STL_MIN_FILE_SIZE ? "a binary file of fewer than four facets" : "";
}

}  // namespace meshgauge::api::test
