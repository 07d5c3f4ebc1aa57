#include "api/formats/file/readers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "api/base/text.h"
#include "api/formats/file/source.h"
#include "api/formats/weld.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as the machine's own floats");

// Binary STL: 80 bytes of any text, a count, and 50 bytes for each facet, in little-endian order.
constexpr std::size_t kCountAt = 80;
constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kFacetBytes = 50;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kAttributeAt = 48;  // in a facet: the count of its attribute bytes

std::size_t facet_count(std::span<const std::byte> bytes, std::endian order) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t shift = 8 * (order == std::endian::little ? i : 3 - i);
    count |= std::to_integer<std::size_t>(bytes[kCountAt + i]) << shift;
  }
  return count;
}

// Whether a file of `size` bytes holds `count` facets and, after them, less than another one.
bool fits(std::size_t size, std::size_t count) {
  const std::size_t expected = kHeaderBytes + kFacetBytes * count;
  return size == expected || (count > 0 && size > expected && size - expected < kFacetBytes);
}

// The attribute bytes of the facets, if the count of each one says how many follow it.
struct AttributeData {
  std::size_t bytes = 0;
  std::size_t first = 0;  // the first facet that has some
};

// Returns what fits the file's size. nullopt: there is none, or the counts are colours.
std::optional<AttributeData> attribute_data(std::span<const std::byte> bytes, std::size_t count) {
  AttributeData data;
  std::size_t end = kHeaderBytes;
  for (std::size_t facet = 0; facet < count; ++facet) {
    if (end > bytes.size() || bytes.size() - end < kFacetBytes) return std::nullopt;
    std::uint16_t more = 0;
    std::memcpy(&more, bytes.data() + end + kAttributeAt, sizeof more);
    if (data.bytes == 0) data.first = facet;
    data.bytes += more;
    end += kFacetBytes + more;
  }
  if (data.bytes == 0 || end > bytes.size()) return std::nullopt;
  // Less than a facet may follow the data, but not if the file then holds whole facets without them.
  const std::size_t left = bytes.size() - end;
  const bool whole_facets = (bytes.size() - kHeaderBytes) % kFacetBytes == 0;
  return left == 0 || (left < kFacetBytes && !whole_facets) ? std::optional(data) : std::nullopt;
}

Error wrong_count(const Source& source, std::size_t count) {
  const std::size_t size = source.bytes.size(), expected = kHeaderBytes + kFacetBytes * count;
  const std::size_t whole = (size - kHeaderBytes) / kFacetBytes;
  const bool holds_facets = whole > 0 && (size - kHeaderBytes) % kFacetBytes == 0;
  const std::string should = "the count of " + std::to_string(count) + " facets needs " + std::to_string(expected) +
                             " bytes, the file has " + std::to_string(size);
  if (size < expected) {
    return at_byte(source, size, ErrorCode::unreadable_mesh,
                   "truncated: " + should + (holds_facets ? " and holds " + std::to_string(whole) + " facets" : ""));
  }
  if (!holds_facets) return at_byte(source, expected, ErrorCode::unreadable_mesh, "left-over bytes: " + should);
  const std::string remedy = count == 0 ? "written to a pipe? Write it to a file, so that its header gets the count"
                                        : "write it again, so that both agree";
  return at_byte(source, kCountAt, ErrorCode::unreadable_mesh,
                 "the header counts " + std::to_string(count) + " facets, the file holds " + std::to_string(whole) +
                     ": " + remedy);
}

Result<Done> check_size(const Source& source) {
  const std::size_t size = source.bytes.size();
  if (size < kHeaderBytes) {
    return at_byte(source, size, ErrorCode::unreadable_mesh,
                   "truncated: a binary STL needs 84 bytes of header and a count");
  }
  const std::size_t count = facet_count(source.bytes, std::endian::little);
  if (size == kHeaderBytes + kFacetBytes * count) return Done{};
  if (const auto data = attribute_data(source.bytes, count)) {
    return at_byte(source, kHeaderBytes + kFacetBytes * (data->first + 1), ErrorCode::unsupported_format,
                   "attribute data after facets, which is not supported: " + std::to_string(data->bytes) +
                       " bytes, the first after facet " + std::to_string(data->first) + "; export without attributes");
  }
  if (fits(size, count)) return Done{};
  if (const std::size_t swapped = facet_count(source.bytes, std::endian::big); fits(size, swapped)) {
    return at_byte(source, kCountAt, ErrorCode::unsupported_format,
                   "big-endian numbers, which are not supported: the count of " + std::to_string(swapped) +
                       " facets fits the file in that order alone; export it as little-endian, as STL asks");
  }
  return wrong_count(source, count);
}

// Converts the corners of facets that lie one after another. Returns false when a coordinate is not finite.
bool corners_of(const std::byte* facet, std::size_t facets, Vec3* corners) {
  constexpr std::uint32_t kMagnitude = 0x7FFFFFFF, kLargest = 0x7F7FFFFF;
  bool finite = true;
  double* to = corners->data();
  for (std::size_t i = 0; i < facets; ++i, facet += kFacetBytes, to += 9) {
    std::array<float, 9> coordinates;
    std::memcpy(coordinates.data(), facet + kNormalBytes, sizeof coordinates);
    for (std::size_t k = 0; k < 9; ++k) {
      to[k] = static_cast<double>(coordinates[k]);
      finite &= (std::bit_cast<std::uint32_t>(coordinates[k]) & kMagnitude) <= kLargest;
    }
  }
  return finite;
}

// Precondition: not all of these corners, which begin with `facet`, are finite.
Error non_finite(const Source& source, std::size_t facet, const Vec3* corners) {
  const double* const coordinates = corners->data();
  std::size_t k = 0;
  while (std::isfinite(coordinates[k])) ++k;
  facet += k / 9;
  return at_byte(source, kHeaderBytes + facet * kFacetBytes + kNormalBytes + k % 9 * sizeof(float),
                 ErrorCode::non_finite_vertex, "a coordinate of facet " + std::to_string(facet) + " is not finite");
}

Result<Done> read_facets(const Source& source, std::size_t count, ReadMesh& out) {
  constexpr std::size_t kAtOnce = 64;
  reserve_room(out.mesh.positions, 3 * count);
  reserve_room(out.mesh.triangles, count);
  out.mesh.positions.resize(3 * count);  // Vec3 is not initialised, so this writes nothing
  Vec3* const positions = out.mesh.positions.data();
  std::optional<Welder> welder;
  // A closed surface has half as many vertices as triangles.
  if (source.corners == Corners::merged) welder.emplace(positions, count / 8 * 5);
  std::array<Vec3, 3 * kAtOnce> block;
  std::array<Triangle, kAtOnce> triangles;
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    const std::size_t facets = std::min(kAtOnce, count - first), vertices = 3 * facets;
    Vec3* const corners = welder ? block.data() : positions + 3 * first;
    if (!corners_of(source.bytes.data() + kHeaderBytes + first * kFacetBytes, facets, corners)) {
      return non_finite(source, first, corners);
    }
    std::uint32_t* const indices = triangles.data()->data();
    if (welder) {
      welder->add({corners, vertices}, indices);
    } else {
      std::iota(indices, indices + vertices, static_cast<std::uint32_t>(3 * first));
    }
    out.mesh.triangles.insert(out.mesh.triangles.end(), triangles.data(), triangles.data() + facets);
  }
  if (!welder) return Done{};
  out.merged = true;
  out.notes.welded_vertices = 3 * count - welder->count();
  out.mesh.positions.resize(welder->count());
  return Done{};
}

// Reads binary STL. Less than a facet's 50 bytes after the last one get a remark. Refuses a count that fits the size in
// no other way, facets that attribute data follow, and big-endian numbers.
Result<ReadMesh> read_binary_stl(const Source& source) {
  if (auto ok = check_size(source); !ok) return std::move(ok).error();
  const std::size_t count = facet_count(source.bytes, std::endian::little);
  if (count > source.limits.max_triangles) return too_many(source, "triangles", source.limits.max_triangles);
  if (count > vertex_limit(source) / 3) return too_many(source, "vertices", vertex_limit(source));

  ReadMesh out;
  out.format = Format::stl;
  if (count == 0) return out;
  out.notes.add_remark(
      "bytes after the last of the " + std::to_string(count) + " facets that the header announces, ignored",
      source.bytes.size() - kHeaderBytes - kFacetBytes * count);
  if (auto ok = read_facets(source, count, out); !ok) return std::move(ok).error();
  return out;
}

class AsciiReader {
 public:
  explicit AsciiReader(const Source& source) : source_(source), p_(after_mark(source.text())), end_(source.end()) {
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
  bool take_endsolid();
  void to_word(std::string_view word, std::size_t most = std::string_view::npos);
  const char* facet_on_line();
  Result<Done> skip_name(const char* to);
  bool at_end() { return (p_ = skip_spaces(p_, end_)) == end_; }
  Error expected(std::string_view what);

  const Source& source_;
  const char* p_;
  const char* end_;
  // The last result of facet_on_line(), and the place from which it is valid.
  const char* searched_from_ = nullptr;
  const char* found_ = nullptr;
  std::size_t joined_ends_ = 0;  // endsolid that is joined to a name
  std::string first_joined_;
  ReadMesh out_;
};

// Takes "endsolid", even if it is joined to the name of the solid.
bool AsciiReader::take_endsolid() {
  constexpr std::size_t kLength = 8;
  p_ = skip_spaces(p_, end_);
  const std::string_view word = word_at(p_, end_);
  if (!same_word(word.substr(0, kLength), "endsolid")) return false;
  if (word.size() > kLength && ++joined_ends_ == 1) first_joined_ = in_quotes(word);
  p_ += kLength;
  return true;
}

// Skips to the next `word` on this line, or to the end of the line, or `most` words.
void AsciiReader::to_word(std::string_view word, std::size_t most) {
  for (p_ = skip_blanks(p_, end_); p_ != end_ && !is_newline(*p_); p_ = skip_blanks(p_, end_)) {
    const std::string_view next = word_at(p_, end_);
    if (same_word(next, word) || most-- == 0) return;
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

// Skips the name of a solid. Where lines are joined, a facet whose first words are misspelt would look like a part of
// it.
Result<Done> AsciiReader::skip_name(const char* to) {
  int vertices = 0;
  for (p_ = skip_spaces(p_, to); p_ != to; p_ = skip_spaces(p_, to)) {
    const std::string_view word = word_at(p_, to);
    vertices += same_word(word, "vertex");
    if (vertices == 3 || same_word(word.substr(0, 7), "endloop") || same_word(word.substr(0, 8), "endfacet")) {
      return at_line(source_, p_, ErrorCode::unreadable_mesh,
                     in_quotes(word) + " in the name of a solid: a facet begins with 'facet normal'");
    }
    p_ += word.size();
  }
  return Done{};
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
  to_word("outer", 4);  // skips the normal, which is often wrong and not used: 'normal' and three numbers
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
  if (auto ok = skip_name(facet_on_line()); !ok) return ok;
  const std::size_t before = out_.mesh.triangles.size();
  while (!take_endsolid()) {
    if (at_end() && out_.mesh.triangles.size() > before) {
      out_.notes.remarks.emplace_back("the file ends after a facet, without endsolid: it may be truncated");
      return Done{};
    }
    if (auto ok = facet(); !ok) return ok;
  }
  const char* to = facet_on_line();
  if (to != end_ && !is_newline(*to)) {
    const char* const name = p_;
    to_word("solid");
    to = std::min(p_, to);
    p_ = name;
  }
  return skip_name(to);
}

Result<ReadMesh> AsciiReader::read() {
  while (!at_end()) {
    if (auto ok = solid(); !ok) return std::move(ok).error();
  }
  if (joined_ends_ != 0) {
    out_.notes.remarks.push_back("endsolid joined to a name, read as the end of a solid: " +
                                 std::to_string(joined_ends_) + ", the first is " + first_joined_);
  }
  return std::move(out_);
}

// Reads ASCII STL: one solid or more. Lines may be joined, and a byte order mark may precede them. An `endsolid` that
// is joined to a name, and a file that ends after a facet without it, get a remark. Precondition: the text begins with
// "solid".
Result<ReadMesh> read_ascii_stl(const Source& source) { return AsciiReader(source).read(); }

bool starts_with_word(std::string_view text, std::string_view lower_case) {
  return same_word(text.substr(0, lower_case.size()), lower_case);
}

// Returns the place of the first byte at the beginning that no text has; npos: there is none. The header of a binary
// file may be text, too, but its count and its normals contain such bytes.
std::size_t first_control(std::string_view text) {
  const std::string_view start = text.substr(0, 1024);
  const auto found =
      std::ranges::find_if(start, [](char c) { return static_cast<unsigned char>(c) < ' ' && !is_space(c); });
  return found == start.end() ? std::string_view::npos : static_cast<std::size_t>(found - start.begin());
}

// Returns true when a line begins with `word`.
bool has_line(std::string_view text, std::string_view word) {
  const char* const end = text.data() + text.size();
  for (const char* p = text.data(); p != end; p = next_line(p, end)) {
    p = skip_blanks(p, end);
    if (same_word(word_at(p, end), word)) return true;
  }
  return false;
}

// Refuses text that does not begin with "solid".
Error not_solid(const Source& source, std::string_view text) {
  const char* const end = text.data() + text.size();
  const char* const first = skip_spaces(after_mark(text), end);
  const std::string_view line(first, static_cast<std::size_t>(skip_line(first, end) - first));
  std::string remedy = "; it has no line that begins with 'facet': export it as STL";
  if (has_line(text, "facet")) {
    remedy = has_line(text, "solid") ? "; delete the lines before 'solid'" : "; begin the file with a line 'solid'";
  }
  return at_line(source, first, ErrorCode::unreadable_mesh,
                 "text, but line 1 is not 'solid': the file begins with " + in_quotes(line) + remedy);
}

}  // namespace

bool is_binary_stl(std::span<const std::byte> bytes) {
  return bytes.size() >= kHeaderBytes && fits(bytes.size(), facet_count(bytes, std::endian::little));
}

Result<ReadMesh> read_stl(const Source& source) {
  const std::string_view whole = source.text();
  const std::string_view text = whole.substr(0, length_without_padding(whole));
  if (text.empty() || is_binary_stl(source.bytes)) return read_binary_stl(source);
  if (const std::size_t control = first_control(text); control != std::string_view::npos) {
    if (!starts_with_word(text, "solid") || !has_line(text, "facet")) return read_binary_stl(source);
    return at_line(source, text.data() + control, ErrorCode::unreadable_mesh, "binary data in a text file");
  }
  const char* const end = text.data() + text.size();
  const char* const first = skip_spaces(after_mark(text), end);
  if (starts_with_word({first, end}, "solid")) return read_without_padding(source, read_ascii_stl);
  // Otherwise it may be the header of a binary file, cut before its count.
  const bool is_header = text.size() < whole.size() && std::ranges::none_of(text, is_newline);
  if (first == end || is_header) return read_binary_stl(source);
  return not_solid(source, text);
}

}  // namespace meshgauge::api
