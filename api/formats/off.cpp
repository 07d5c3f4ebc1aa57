#include "api/formats/off.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "api/formats/geomview.h"
#include "api/formats/off_binary.h"
#include "api/formats/polygons.h"
#include "api/formats/room.h"
#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

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

std::size_t as_size(std::ptrdiff_t bytes) { return static_cast<std::size_t>(bytes); }

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

const char* start_of_content(std::string_view text) {
  const char* const end = text.data() + text.size();
  const char* p = skip_spaces(after_mark(text), end);
  while (p != end && *p == '#') p = skip_spaces(skip_line(p, end), end);
  return p;
}

std::string_view off_keyword(std::string_view text) {
  constexpr std::size_t kLongest = 9;
  const char* const start = start_of_content(text);
  const std::string_view word = word_at(start, start + std::min<std::size_t>(32, as_size(text.end() - start)));
  const std::size_t name = word.find("OFF");
  if (name == std::string_view::npos || name + 3 > kLongest) return {};
  const bool counts_follow = word.find_first_not_of("0123456789", name + 3) == std::string_view::npos;
  const bool known = word.substr(0, name).find_first_not_of("STCN4n") == std::string_view::npos;
  return counts_follow && known ? word.substr(0, name + 3) : std::string_view();
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
