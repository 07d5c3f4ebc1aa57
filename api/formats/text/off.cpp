#include "api/formats/file/readers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <utility>

#include "api/base/text.h"
#include "api/formats/file/source.h"
#include "api/formats/polygons/polygons.h"

namespace meshgauge::api {
namespace {

// Returns the place after a byte order mark, blanks, blank lines and comments.
const char* start_of_content(std::string_view text) {
  const char* const end = text.data() + text.size();
  const char* p = skip_spaces(after_mark(text), end);
  while (p != end && *p == '#') p = skip_spaces(skip_line(p, end), end);
  return p;
}

// Surfaces, curves and lists of them. Prefixes of letters tell what each vertex has; degrees follow BEZ.
constexpr std::string_view kObjects[] = {"LIST", "INST", "QUAD", "POLY",  "MESH",   "BEZ",
                                         "BBP",  "VECT", "SKEL", "GROUP", "SPHERE", "COMMENT"};
constexpr std::string_view kPrefixes = "STCNZ4Uuvn";
constexpr std::string_view kObjectWords[] = {"appearance", "define", "geometry", "transform",
                                             "transforms", "camera", "image"};
constexpr std::size_t kLongestObject = 16;

std::string_view object_at(const char* p, const char* end) {
  const std::string_view word = word_at(p, p + std::min<std::ptrdiff_t>(end - p, kLongestObject));
  if (std::ranges::find(kObjectWords, word) != std::end(kObjectWords)) return word;
  for (const std::string_view object : kObjects) {
    const std::size_t at = word.find(object);
    if (at == std::string_view::npos) continue;
    const bool prefixes_known = word.substr(0, at).find_first_not_of(kPrefixes) == std::string_view::npos;
    const bool degrees_follow = word.find_first_not_of("0123456789", at + object.size()) == std::string_view::npos;
    if (prefixes_known && degrees_follow) return word;
  }
  return {};
}

// How many numbers follow the coordinates of a vertex.
struct OffExtras {
  int normal = 0;
  int colour = 0;
  int texture = 0;
};

static_assert(std::endian::native == std::endian::little);

constexpr std::uint64_t kWord = 4;
constexpr std::uint64_t kCounts = 3;  // vertices, faces, edges

struct Layout {
  bool big_endian;
  bool counts_colours;
  const char* remark;
};
constexpr Layout kLayouts[] = {
    {true, true, nullptr},
    {false, true, "binary OFF in little-endian byte order, unlike Geomview's"},
    {true, false, "binary OFF without the number of colour components that Geomview writes after each face"},
    {false, false, "binary OFF in little-endian byte order, without the number of colour components after each face"}};

// The body as words of four bytes in one of the layouts.
class Words {
 public:
  Words(const Source& source, const char* body, const Layout& layout, const OffExtras& extras)
      : body_(body),
        count_(static_cast<std::uint64_t>(source.end() - body) / kWord),
        layout_(layout),
        stride_(3 + static_cast<std::uint64_t>(extras.normal + extras.colour + extras.texture)) {
    if (count_ < kCounts) return;
    vertices_ = at(0);
    faces_ = at(1);
  }

  std::uint32_t at(std::uint64_t word) const {
    std::uint32_t value = 0;
    std::memcpy(&value, body_ + word * kWord, kWord);
    return layout_.big_endian ? __builtin_bswap32(value) : value;
  }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t faces() const { return faces_; }
  std::uint64_t first_of_vertex(std::uint64_t vertex) const { return kCounts + vertex * stride_; }

  // Returns the word after the face that begins at `word`; nullopt: no face fits there.
  std::optional<std::uint64_t> next_face(std::uint64_t word) const {
    if (word >= count_) return std::nullopt;
    const std::uint64_t corners = at(word);
    std::uint64_t next = word + 1 + corners;
    if (corners == 0 || next > count_) return std::nullopt;
    if (!layout_.counts_colours) return next;
    if (next >= count_) return std::nullopt;
    next += 1 + at(next);
    return next <= count_ ? std::optional(next) : std::nullopt;
  }

  // Returns true when the faces end with the last word and all their indices are in range.
  bool fit() const {
    if (count_ < kCounts || first_of_vertex(vertices_) > count_ || faces_ > count_) return false;
    std::uint64_t word = first_of_vertex(vertices_);
    for (std::uint64_t face = 0; face < faces_; ++face) {
      const auto next = next_face(word);
      if (!next) return false;
      for (std::uint64_t corner = 0; corner < at(word); ++corner) {
        if (at(word + 1 + corner) >= vertices_) return false;
      }
      word = *next;
    }
    return word == count_;
  }

 private:
  const char* body_;
  std::uint64_t count_;
  const Layout& layout_;
  std::uint64_t stride_;
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
};

std::optional<Error> read_vertices(const Source& source, const char* body, const Words& words, ReadMesh& out) {
  reserve_room(out.mesh.positions, words.vertices());
  for (std::uint64_t i = 0; i < words.vertices(); ++i) {
    Vec3 position;
    for (std::uint64_t k = 0; k < 3; ++k) {
      const std::uint64_t word = words.first_of_vertex(i) + k;
      const auto value = std::bit_cast<float>(words.at(word));
      if (!std::isfinite(value)) {
        return at_byte(source, static_cast<std::size_t>(body - source.begin()) + word * kWord,
                       ErrorCode::non_finite_vertex, "a coordinate of vertex " + std::to_string(i) + " is not finite");
      }
      position[static_cast<int>(k)] = static_cast<double>(value);
    }
    out.mesh.positions.push_back(position);
  }
  return std::nullopt;
}

// Precondition: words.fit().
std::optional<Error> read_faces(const Source& source, const Words& words, ReadMesh& out) {
  reserve_room(out.mesh.triangles, words.faces());
  Faces faces(out.mesh.triangles);
  std::uint64_t word = words.first_of_vertex(words.vertices());
  for (std::uint64_t face = 0; face < words.faces(); ++face) {
    faces.begin();
    for (std::uint64_t corner = 0; corner < words.at(word); ++corner) {
      faces.add(words.at(word + 1 + corner));
      if (out.mesh.triangles.size() > source.limits.max_triangles) {
        return too_many(source, "triangles", source.limits.max_triangles);
      }
    }
    out.notes.skipped_primitives += faces.corners() < 3;
    faces.end();
    word = *words.next_face(word);
  }
  if (auto split = split_polygons(source, faces.runs(), out); !split) return std::move(split).error();
  return std::nullopt;
}

// Reads binary OFF from `body`, the first byte after the keyword's line. Geomview writes big-endian integers and floats
// of four bytes, and the number of colour components after each face. Other programs write little-endian, or omit that
// number. Uses the first of these variants for which counts, faces and the file's size agree to the byte, with a remark
// unless it is Geomview's. Refuses a file that none of them fits. Linear time.
Result<ReadMesh> read_binary_off(const Source& source, const char* body, const OffExtras& extras) {
  const bool whole_words = static_cast<std::uint64_t>(source.end() - body) % kWord == 0;
  for (const Layout& layout : kLayouts) {
    const Words words(source, body, layout, extras);
    if (!whole_words || !words.fit()) continue;
    if (words.vertices() > vertex_limit(source)) return too_many(source, "vertices", vertex_limit(source));
    ReadMesh out;
    out.format = Format::off;
    if (auto error = read_vertices(source, body, words, out)) return std::move(*error);
    if (auto error = read_faces(source, words, out)) return std::move(*error);
    if (layout.remark != nullptr) out.notes.remarks.emplace_back(layout.remark);
    return out;
  }
  return at_byte(
      source, static_cast<std::size_t>(body - source.begin()), ErrorCode::unreadable_mesh,
      "truncated or damaged: the counts and faces of this binary OFF do not end where the file ends, in either "
      "byte order");
}

// Text files have colours of three or four numbers.
constexpr int kLeastColour = 3;
constexpr int kBinaryColour = 4;

// Returns the numbers that the prefixes add. nullopt: a prefix is unknown or repeated.
std::optional<OffExtras> extras_of(std::string_view keyword) {
  OffExtras extras;
  std::string_view prefixes = keyword.substr(0, keyword.size() - 3);
  const auto take = [&](std::string_view prefix, int numbers, int& extra) {
    if (!prefixes.starts_with(prefix) || extra != 0) return false;
    prefixes.remove_prefix(prefix.size());
    extra = numbers;
    return true;
  };
  while (!prefixes.empty()) {
    if (!take("N", 3, extras.normal) && !take("C", kLeastColour, extras.colour) && !take("ST", 2, extras.texture)) {
      return std::nullopt;
    }
  }
  return extras;
}

// Reads line by line; ignores the rest of a line after the numbers needed (edge counts, colours).
class OffReader {
 public:
  OffReader(const Source& source, const char* body, const OffExtras& extras)
      : source_(source),
        p_(body),
        end_(source.end()),
        extras_(extras.normal + extras.colour + extras.texture),
        faces_(out_.mesh.triangles) {
    out_.format = Format::off;
  }

  Result<ReadMesh> read();

 private:
  bool next_line();
  bool next_corner();
  bool integer(std::int64_t& value);
  bool coordinate(double& value);
  bool counts();
  bool vertex();
  bool face();
  bool end_of_file();
  bool fail(ErrorCode code, const std::string& what) {
    error_ = at_line(source_, p_, code, what);
    return false;
  }
  bool bad(std::string_view word, const std::string& kind) {
    return fail(ErrorCode::unreadable_mesh,
                word.empty() ? "the line ends where " + kind + " is expected" : in_quotes(word) + " is not " + kind);
  }
  void skip_comments() {
    for (p_ = skip_spaces(p_, end_); p_ != end_ && *p_ == '#'; p_ = skip_spaces(p_, end_)) p_ = skip_line(p_, end_);
  }
  std::string_view word() {
    p_ = skip_blanks(p_, end_);
    return word_at(p_, end_);
  }

  const Source& source_;
  const char* p_;
  const char* end_;
  int extras_;
  std::int64_t vertex_count_ = 0;
  std::int64_t face_count_ = 0;
  std::int64_t faces_read_ = 0;
  ReadMesh out_;
  Faces faces_;
  std::optional<Error> error_;
};

// Skips to the next line that has more than a comment.
bool OffReader::next_line() {
  skip_comments();
  if (p_ != end_) return true;
  return fail(ErrorCode::unreadable_mesh,
              "truncated: the counts announce " + std::to_string(vertex_count_) + " vertices and " +
                  std::to_string(face_count_) + " faces, the file ends after " +
                  std::to_string(out_.mesh.positions.size()) + " and " + std::to_string(faces_read_));
}

// Skips to the next corner, also on the next line. A face cut short takes the line of the next face; the last one then
// finds no line.
bool OffReader::next_corner() {
  p_ = skip_blanks(p_, end_);
  return (p_ != end_ && !is_newline(*p_) && *p_ != '#') || next_line();
}

bool OffReader::integer(std::int64_t& value) {
  const std::string_view text = word();
  if (parse_integer(p_, end_, value) != p_ + text.size()) return bad(text, "an integer");
  p_ += text.size();
  return true;
}

bool OffReader::coordinate(double& value) {
  const std::string_view text = word();
  if (parse_number(p_, end_, value) != p_ + text.size()) return bad(text, "a number");
  if (!std::isfinite(value)) {
    return fail(ErrorCode::non_finite_vertex, "the coordinate " + in_quotes(text) + " is not finite");
  }
  p_ += text.size();
  return true;
}

bool OffReader::counts() {
  skip_comments();
  if (p_ == end_) return fail(ErrorCode::unreadable_mesh, "truncated: the file ends before the counts");
  if (!integer(vertex_count_) || !integer(face_count_)) return false;
  // A vertex takes at least "0 0 0\n", a face "0\n".
  const std::int64_t remaining = end_ - p_ + 1;
  if (vertex_count_ < 0 || vertex_count_ > remaining / 6 || face_count_ < 0 || face_count_ > remaining / 2) {
    return fail(ErrorCode::unreadable_mesh, std::to_string(vertex_count_) + " vertices and " +
                                                std::to_string(face_count_) + " faces do not fit into the file");
  }
  p_ = skip_line(p_, end_);
  return true;
}

bool OffReader::vertex() {
  if (!next_line()) return false;
  Vec3 position;
  for (int k = 0; k < 3; ++k) {
    if (!coordinate(position[k])) return false;
  }
  // Not used, but required here: on the next line they would be read as a vertex.
  for (int i = 0; i < extras_; ++i) {
    const std::string_view extra = word();
    if (extra.empty() || extra.starts_with('#')) return bad({}, "a normal, colour or texture coordinate");
    p_ += extra.size();
  }
  out_.mesh.positions.push_back(position);
  p_ = skip_line(p_, end_);
  return true;
}

bool OffReader::face() {
  std::int64_t corners = 0;
  if (!next_line() || !integer(corners)) return false;
  if (corners < 1) return fail(ErrorCode::unreadable_mesh, std::to_string(corners) + " is not a number of corners");
  faces_.begin();
  for (std::int64_t i = 0; i < corners; ++i) {
    std::int64_t index = 0;
    if (!next_corner() || !integer(index)) return false;
    if (index < 0 || index >= vertex_count_) {
      return fail(ErrorCode::index_out_of_range,
                  "index " + std::to_string(index) + ", but there are " + std::to_string(vertex_count_) + " vertices");
    }
    faces_.add(static_cast<std::uint32_t>(index));
    if (out_.mesh.triangles.size() > source_.limits.max_triangles) {
      error_ = too_many(source_, "triangles", source_.limits.max_triangles);
      return false;
    }
  }
  out_.notes.skipped_primitives += corners < 3;
  faces_.end();
  ++faces_read_;
  p_ = skip_line(p_, end_);
  return true;
}

bool OffReader::end_of_file() {
  skip_comments();
  if (p_ == end_) return true;
  const char* const first = p_;
  std::size_t lines = 0;
  for (; p_ != end_; skip_comments()) {
    ++lines;
    p_ = skip_line(p_, end_);
  }
  p_ = first;
  return fail(ErrorCode::unreadable_mesh, "left-over lines after the " + std::to_string(face_count_) +
                                              " faces that the counts announce: " + std::to_string(lines));
}

Result<ReadMesh> OffReader::read() {
  if (!counts()) return std::move(*error_);
  if (static_cast<std::uint64_t>(vertex_count_) > vertex_limit(source_)) {
    return too_many(source_, "vertices", vertex_limit(source_));
  }
  reserve_room(out_.mesh.positions, static_cast<std::size_t>(vertex_count_));
  reserve_room(out_.mesh.triangles, static_cast<std::size_t>(face_count_));
  for (std::int64_t i = 0; i < vertex_count_; ++i) {
    if (!vertex()) return std::move(*error_);
  }
  for (std::int64_t i = 0; i < face_count_; ++i) {
    if (!face()) return std::move(*error_);
  }
  if (!end_of_file()) return std::move(*error_);
  if (auto split = split_polygons(source_, faces_.runs(), out_); !split) return std::move(split).error();
  return std::move(out_);
}

// Reads a file without the keyword, as Geomview does. Used only when a name or a media type says OFF, since any file
// may begin with three numbers.
Result<ReadMesh> read_without_keyword(const Source& source) {
  const char* const counts = start_of_content(source.text());
  if (const auto object = geomview_object({counts, source.end()}); !object.empty()) {
    return about(source.part, ErrorCode::unsupported_format,
                 "begins with " + in_quotes(object) +
                     ", another object of Geomview than OFF, which is not supported; save its faces as one OFF");
  }
  int integers = 0;
  const char* p = counts;
  for (std::int64_t ignored = 0; p != source.end() && is_digit(*p); ++integers) {
    p = skip_blanks(parse_integer(p, source.end(), ignored), source.end());
  }
  const bool line_ends = p == source.end() || is_newline(*p) || *p == '#';
  if (!line_ends || (integers != 2 && integers != 3)) {
    return at_line(source, counts, ErrorCode::unreadable_mesh, "an OFF file must begin with 'OFF'");
  }
  auto read = OffReader(source, counts, {}).read();
  if (read) read->notes.remarks.emplace_back("the keyword OFF is missing; the name of the file says that it is one");
  return read;
}

}  // namespace

std::string_view off_keyword(std::string_view text) {
  constexpr std::size_t kLongest = 9;
  const char* const start = start_of_content(text);
  const char* const end = text.data() + text.size();
  const std::string_view word = word_at(start, start + std::min<std::ptrdiff_t>(end - start, 32));
  const std::size_t name = word.find("OFF");
  if (name == std::string_view::npos || name + 3 > kLongest) return {};
  const bool counts_follow = word.find_first_not_of("0123456789", name + 3) == std::string_view::npos;
  const bool known = word.substr(0, name).find_first_not_of("STCN4n") == std::string_view::npos;
  return counts_follow && known ? word.substr(0, name + 3) : std::string_view();
}

std::string_view geomview_object(std::string_view text) {
  const char* const end = text.data() + text.size();
  if (!text.starts_with('{')) return object_at(text.data(), end);
  const std::string_view inner(start_of_content(text.substr(1)), end);
  const bool known = inner.starts_with('{') || inner.starts_with('=') || inner.starts_with('<') ||
                     !off_keyword(inner).empty() || !object_at(inner.data(), end).empty();
  return known ? text.substr(0, 1) : std::string_view();
}

Result<ReadMesh> read_off(const Source& source) {
  const std::string_view keyword = off_keyword(source.text());
  if (keyword.empty()) return read_without_padding(source, read_without_keyword);
  const char* const body = keyword.data() + keyword.size();
  auto extras = extras_of(keyword);
  if (!extras) {
    return about(source.part, ErrorCode::unsupported_format,
                 "is of the kind " + in_quotes(keyword) +
                     ", which is not supported; supported is OFF with any of the prefixes ST, C and N");
  }
  const char* const next = skip_blanks(body, source.end());
  if (!same_word(word_at(next, source.end()), "binary")) {
    return read_without_padding(source, [&](const Source& text) { return OffReader(text, body, *extras).read(); });
  }
  if (extras->colour != 0) extras->colour = kBinaryColour;
  const char* end = skip_line(next, source.end());
  end += end != source.end() && *end == '\r' && end + 1 != source.end() && end[1] == '\n';
  return read_binary_off(source, end == source.end() ? end : end + 1, *extras);
}

}  // namespace meshgauge::api
