#include "api/formats/stl.h"

#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "api/formats/room.h"
#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as the machine's own floats");

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kFacetBytes = 50;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kMostTrailingBytes = 80;

std::size_t facet_count(std::span<const std::byte> bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

// Returns true when the file starts with "solid" and its beginning is text. The header of a binary file may also say
// "solid", but its count and its normals contain bytes that no text has.
bool is_ascii(std::string_view text) {
  const char* p = skip_spaces(text.data(), text.data() + text.size());
  const std::string_view beginning(p, std::min<std::size_t>(1024, static_cast<std::size_t>(text.end() - p)));
  if (beginning.size() < 5 || !same_word(beginning.substr(0, 5), "solid")) return false;
  for (const char c : beginning) {
    if (static_cast<unsigned char>(c) < ' ' && !is_space(c)) return false;
  }
  return true;
}

Error non_finite(const Source& source, std::size_t facet, const float* coordinates) {
  std::size_t k = 0;
  while (std::isfinite(coordinates[k])) ++k;
  return at_byte(source, kHeaderBytes + facet * kFacetBytes + kNormalBytes + k * sizeof(float),
                 ErrorCode::non_finite_vertex, "a coordinate of facet " + std::to_string(facet) + " is not finite");
}

Result<Done> check_binary_size(const Source& source) {
  const std::size_t size = source.bytes.size();
  if (size < kHeaderBytes) {
    return at_byte(source, size, ErrorCode::unreadable_mesh,
                   "truncated: a binary STL needs 84 bytes of header and a count");
  }
  const std::size_t count = facet_count(source.bytes);
  const std::size_t expected = kHeaderBytes + kFacetBytes * count;
  if (size == expected || is_binary_stl(source.bytes)) return Done{};
  const std::string should = "the count of " + std::to_string(count) + " facets needs " + std::to_string(expected) +
                             " bytes, the file has " + std::to_string(size);
  if (size < expected) return at_byte(source, size, ErrorCode::unreadable_mesh, "truncated: " + should);
  return at_byte(source, expected, ErrorCode::unreadable_mesh, "left-over bytes: " + should);
}

Result<ReadMesh> read_binary(const Source& source) {
  if (auto ok = check_binary_size(source); !ok) return std::move(ok).error();
  const std::size_t count = facet_count(source.bytes);
  if (count > source.limits.max_triangles) return too_many(source, "triangles", source.limits.max_triangles);
  if (count > vertex_limit(source) / 3) return too_many(source, "vertices", vertex_limit(source));

  ReadMesh out;
  out.format = Format::stl;
  if (count == 0) return out;
  if (const std::size_t left = source.bytes.size() - kHeaderBytes - kFacetBytes * count; left != 0) {
    out.notes.remarks.push_back("bytes after the last of the " + std::to_string(count) +
                                " facets that the header announces, ignored: " + std::to_string(left));
  }
  reserve_room(out.mesh.positions, 3 * count);
  reserve_room(out.mesh.triangles, count);
  out.mesh.positions.resize(3 * count);  // Vec3 is not initialised, so this writes nothing
  const std::byte* facet = source.bytes.data() + kHeaderBytes + kNormalBytes;
  double* position = out.mesh.positions.data()->data();
  for (std::size_t i = 0; i < count; ++i, facet += kFacetBytes, position += 9) {
    std::array<float, 9> coordinates;
    std::memcpy(coordinates.data(), facet, sizeof coordinates);
    float nothing = 0;  // stays zero, unless a coordinate is NaN or infinite
    for (std::size_t k = 0; k < 9; ++k) {
      position[k] = static_cast<double>(coordinates[k]);
      nothing += coordinates[k] * 0.0F;
    }
    if (!(nothing == 0)) return non_finite(source, i, coordinates.data());
    const auto first = static_cast<std::uint32_t>(3 * i);
    out.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return out;
}

class AsciiReader {
 public:
  explicit AsciiReader(const Source& source) : source_(source), p_(source.begin()), end_(source.end()) {
    out_.format = Format::stl;
  }

  Result<ReadMesh> read();

 private:
  Result<Done> solid();
  Result<Done> facet();
  Result<Done> vertex();
  Result<double> coordinate();

  bool next_is(std::string_view word) {
    p_ = skip_spaces(p_, end_);
    return same_word(word_at(p_, end_), word);
  }
  bool take(std::string_view word) {
    const bool here = next_is(word);
    if (here) p_ += word.size();
    return here;
  }
  void to_word(std::string_view word);
  const char* facet_on_line();
  bool at_end() { return (p_ = skip_spaces(p_, end_)) == end_; }
  void to_line_end() { p_ = skip_line(p_, end_); }
  Error expected(std::string_view what);

  const Source& source_;
  const char* p_;
  const char* end_;
  // The last result of facet_on_line(), and the place from which it is valid.
  const char* searched_from_ = nullptr;
  const char* found_ = nullptr;
  ReadMesh out_;
};

// Skips to the next `word` on this line, or to the end of the line.
void AsciiReader::to_word(std::string_view word) {
  for (p_ = skip_blanks(p_, end_); p_ != end_ && !is_newline(*p_); p_ = skip_blanks(p_, end_)) {
    const std::string_view next = word_at(p_, end_);
    if (same_word(next, word)) return;
    p_ += std::max<std::size_t>(next.size(), 1);  // size 0: a space that is not a blank
  }
}

// Returns the next "facet normal" on this line, or the end of the line. Finds out whether lines are joined; a name may
// contain "facet".
const char* AsciiReader::facet_on_line() {
  if (searched_from_ != nullptr && searched_from_ <= p_ && p_ <= found_) return found_;
  const char* const start = searched_from_ = p_;
  for (to_word("facet"); p_ != end_ && !is_newline(*p_); to_word("facet")) {
    const char* const facet = p_;
    p_ = skip_blanks(p_ + 5, end_);
    if (!same_word(word_at(p_, end_), "normal")) continue;
    p_ = facet;
    break;
  }
  found_ = p_;
  p_ = start;
  return found_;
}

Error AsciiReader::expected(std::string_view what) {
  if (at_end()) {
    return at_line(source_, p_, ErrorCode::unreadable_mesh, "truncated: the file ends before " + in_quotes(what));
  }
  return at_line(source_, p_, ErrorCode::unreadable_mesh,
                 "expected " + in_quotes(what) + ", found " + in_quotes(word_at(p_, end_)));
}

Result<double> AsciiReader::coordinate() {
  p_ = skip_spaces(p_, end_);
  const std::string_view word = word_at(p_, end_);
  if (word.empty()) return expected("a coordinate");
  double value = 0;
  if (parse_number(p_, end_, value) != p_ + word.size()) {
    return at_line(source_, p_, ErrorCode::unreadable_mesh, in_quotes(word) + " is not a number");
  }
  if (!std::isfinite(value)) {
    return at_line(source_, p_, ErrorCode::non_finite_vertex, "the coordinate " + in_quotes(word) + " is not finite");
  }
  p_ += word.size();
  return value;
}

Result<Done> AsciiReader::vertex() {
  if (!take("vertex")) return expected("vertex");
  Vec3 position;
  for (int k = 0; k < 3; ++k) {
    const auto value = coordinate();
    if (!value) return value.error();
    position[k] = *value;
  }
  out_.mesh.positions.push_back(position);
  return Done{};
}

Result<Done> AsciiReader::facet() {
  if (!take("facet")) return expected("facet' or 'endsolid");
  to_word("outer");  // skips the normal, which is often wrong and not used
  for (const std::string_view word : {"outer", "loop"}) {
    if (!take(word)) return expected(word);
  }
  const auto first = static_cast<std::uint32_t>(out_.mesh.positions.size());
  for (int corner = 0; corner < 3; ++corner) {
    if (auto ok = vertex(); !ok) return ok;
  }
  for (const std::string_view word : {"endloop", "endfacet"}) {
    if (!take(word)) return expected(word);
  }
  if (out_.mesh.triangles.size() == source_.limits.max_triangles) {
    return too_many(source_, "triangles", source_.limits.max_triangles);
  }
  if (out_.mesh.positions.size() > vertex_limit(source_)) {
    return too_many(source_, "vertices", vertex_limit(source_));
  }
  out_.mesh.triangles.push_back({first, first + 1, first + 2});
  return Done{};
}

Result<Done> AsciiReader::solid() {
  if (!take("solid")) return expected("solid");
  p_ = facet_on_line();  // skips the name
  const std::size_t before = out_.mesh.triangles.size();
  while (!take("endsolid")) {
    if (at_end() && out_.mesh.triangles.size() > before) {
      out_.notes.remarks.emplace_back("the file ends after a facet, without endsolid: it may be truncated");
      return Done{};
    }
    if (auto ok = facet(); !ok) return ok;
  }
  if (const char* const facet = facet_on_line(); facet != end_ && !is_newline(*facet)) {
    to_word("solid");
    p_ = std::min(p_, facet);
  } else {
    to_line_end();
  }
  return Done{};
}

Result<ReadMesh> AsciiReader::read() {
  while (!at_end()) {
    if (auto ok = solid(); !ok) return std::move(ok).error();
  }
  return std::move(out_);
}

}  // namespace

bool is_binary_stl(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderBytes) return false;
  const std::size_t count = facet_count(bytes);
  const std::size_t expected = kHeaderBytes + kFacetBytes * count;
  return bytes.size() >= expected && bytes.size() - expected <= (count == 0 ? 0 : kMostTrailingBytes);
}

Result<ReadMesh> read_stl(const Source& source) {
  if (!is_binary_stl(source.bytes) && is_ascii(source.text())) return AsciiReader(source).read();
  return read_binary(source);
}

}  // namespace meshgauge::api
