// The input of a reader, its limits, errors that name the place of a defect, and room for large arrays.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/text.h"
#include "api/formats/format.h"

namespace meshgauge::api {

// One file, already expanded. Borrows; must outlive the reader.
struct Source {
  std::span<const std::byte> bytes;
  std::string_view part;
  const ReadLimits& limits;
  Corners corners = Corners::apart;

  const char* begin() const { return reinterpret_cast<const char*>(bytes.data()); }
  const char* end() const { return begin() + bytes.size(); }
  std::string_view text() const { return as_text(bytes); }
};

// Return errors about a part: "line 12 of 'a': ...", "byte 84 of 'a': ...", "accessors[3] of 'a': ...", "'a' is ...".
Error at(const Source& source, std::string where, ErrorCode code, const std::string& what);
Error at_line(const Source& source, const char* place, ErrorCode code, const std::string& what);
Error at_byte(const Source& source, std::size_t offset, ErrorCode code, const std::string& what);
Error about(std::string_view part, ErrorCode code, const std::string& what);
Error out_of_memory(std::string_view part);

// Returns the too_large error for more `things` ("vertices") than `limit`. vertex_limit() is max_vertices, or less if
// 32-bit indices require it.
Error too_many(const Source& source, std::string_view things, std::size_t limit);
std::size_t vertex_limit(const Source& source);

// Returns to how many bytes a compressed file may expand: min(limits.max_expanded_bytes, max(64 MiB, 200 *
// compressed_bytes)). The ratio bounds time and memory by the size sent; meshes compress far less.
std::size_t expansion_limit(std::size_t compressed_bytes, const ReadLimits& limits);

// Returns the too_large error for more than `limit` bytes. `kind`: the compression, such as "gzip".
Error expands_too_far(std::string_view part, std::size_t limit, std::size_t compressed_bytes, std::string_view kind);

// The longest block that programs fill up. More of it is a file whose end was never written.
inline constexpr std::size_t kMostPadding = 4096;

// Returns the length of text without the NUL and 0x1A bytes at its end, with which old programs fill it up; spaces and
// line ends among them count as theirs. Without such bytes, or with more than kMostPadding, it is the whole length.
std::size_t length_without_padding(std::string_view bytes);

// Calls a reader of text on the bytes without padding, and adds a remark if there is any.
Result<ReadMesh> read_without_padding(const Source& source, const std::function<Result<ReadMesh>(const Source&)>& read);

// Makes a point cloud of all vertices; without vertices, or with surface that is not read, it changes nothing. Error:
// too_large for more points than max_triangles.
Result<Done> make_cloud(const Source& source, ReadMesh& read);

// Asks the system for huge pages for a block just allocated and not yet written. A hint, without effect where there are
// none. Page faults would otherwise take half of the time of reading a large binary STL.
void advise_huge_pages(void* block, std::size_t bytes);

template <class Vector>
void reserve_room(Vector& array, std::size_t count) {
  array.reserve(count);
  advise_huge_pages(array.data(), array.capacity() * sizeof(typename Vector::value_type));
}

// Reserves room for `more` elements at the end. Growing at least doubles the capacity, so that many small additions
// take linear time in total.
template <class T>
void reserve_more(std::vector<T>& array, std::size_t more) {
  if (more > array.capacity() - array.size()) reserve_room(array, std::max(array.size() + more, 2 * array.capacity()));
}

// Appends triangles to an array many at a time, in less time than push_back() takes for each. Call flush() at the end.
class TriangleBlock {
 public:
  explicit TriangleBlock(std::vector<Triangle>& to) : to_(to) {}

  void add(const Triangle& triangle) {
    block_.data()[size_++] = triangle;
    if (size_ == block_.size()) flush();
  }
  void flush() {
    to_.insert(to_.end(), block_.data(), block_.data() + size_);
    size_ = 0;
  }

 private:
  std::vector<Triangle>& to_;
  std::array<Triangle, 256> block_;
  std::size_t size_ = 0;
};

}  // namespace meshgauge::api
