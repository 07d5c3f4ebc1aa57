#include "api/formats/file/readers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "api/base/text.h"
#include "api/formats/file/source.h"

namespace meshgauge::api {
namespace {

// Returns the point at p. An Error names the line.
Result<Vec3> point_at(const Source& source, const char* p) {
  Vec3 point;
  for (int k = 0; k < 3; ++k) {
    p = skip_blanks(p, source.end());
    const std::string_view word = word_at(p, source.end());
    if (word.empty() || word.front() == '#') {
      return at_line(source, p, ErrorCode::unreadable_mesh, "a point needs three coordinates");
    }
    p = parse_number(p, source.end(), point[k]);
    if (p != word.data() + word.size()) {
      return at_line(source, word.data(), ErrorCode::unreadable_mesh, in_quotes(word) + " is not a number");
    }
    if (std::isfinite(point[k])) continue;
    return at_line(source, word.data(), ErrorCode::non_finite_vertex,
                   "the coordinate " + in_quotes(word) + " is not finite");
  }
  return point;
}

// A line before the points that names their columns.
enum class XyzHeading {
  none,           // no heading: a point, a comment, a mistake
  x_y_z,          // "//X Y Z Rf Gf Bf", as CloudCompare writes it, "X Y Z" or "# X Y Z": as the points are read
  other_columns,  // "//R G B X Y Z", "# Z Y X", "// anything else": the points may be others than the first columns
};

// What programs call the columns beside x, y and z.
constexpr std::string_view kColumns[] = {
    "x",  "y",  "z",  "r",  "g",  "b",   "a",     "red",  "green", "blue", "alpha",     "rgb",    "rf",    "gf",   "bf",
    "af", "nx", "ny", "nz", "i",  "int", "index", "id",   "n",     "u",    "v",         "w",      "t",     "time", "dx",
    "dy", "dz", "vx", "vy", "vz", "s",   "value", "gray", "grey",  "nr",   "intensity", "scalar", "label", "class"};

bool is_column(std::string_view word) {
  return std::ranges::any_of(kColumns, [word](std::string_view column) { return same_word(word, column); });
}

// Returns true when the line names x, y and z among the columns that it begins with.
bool names_x_y_z(const char* p, const char* end) {
  bool seen[3] = {};
  for (p = skip_blanks(p, end); p != end; p = skip_blanks(p, end)) {
    const std::string_view word = word_at(p, end);
    if (word.empty() || !is_column(word)) return false;
    if (word.size() == 1 && same_word(word, "x")) seen[0] = true;
    if (word.size() == 1 && same_word(word, "y")) seen[1] = true;
    if (word.size() == 1 && same_word(word, "z")) seen[2] = true;
    if (seen[0] && seen[1] && seen[2]) return true;
    p += word.size();
  }
  return false;
}

bool begins_with_x_y_z(const char* p, const char* end) {
  for (const std::string_view column : {"x", "y", "z"}) {
    p = skip_blanks(p, end);
    const std::string_view word = word_at(p, end);
    if (!same_word(word, column)) return false;
    p += word.size();
  }
  return true;
}

// Takes one line without its end. Linear time.
XyzHeading xyz_heading(std::string_view line) {
  const char* const end = line.data() + line.size();
  const bool slashes = line.starts_with("//");
  const std::size_t marks = line.find_first_not_of(slashes ? '/' : '#');
  const char* const columns = marks == std::string_view::npos ? end : line.data() + marks;
  if (begins_with_x_y_z(columns, end)) return XyzHeading::x_y_z;
  return slashes || names_x_y_z(columns, end) ? XyzHeading::other_columns : XyzHeading::none;
}

class XyzReader {
 public:
  explicit XyzReader(const Source& source) : source_(source), limit_(vertex_limit(source)) {
    out_.format = Format::xyz;
  }

  Result<ReadMesh> read();

 private:
  bool is_preamble(std::string_view line);
  bool is_heading(std::string_view line);
  bool is_count(std::string_view line);
  std::optional<Error> wrong_count() const;
  void fail(const char* place, const std::string& what) {
    error_ = at_line(source_, place, ErrorCode::unreadable_mesh, what);
  }

  const Source& source_;
  std::size_t limit_;
  ReadMesh out_;
  bool heading_seen_ = false;
  std::int64_t count_ = 0;             // of points, in the line at count_place_
  const char* count_place_ = nullptr;  // nullptr: no count
  std::optional<Error> error_;
};

// Takes a line before the first point. Returns false when the line is a point; error_ is set when it is refused.
bool XyzReader::is_preamble(std::string_view line) { return is_heading(line) || is_count(line); }

bool XyzReader::is_heading(std::string_view line) {
  const XyzHeading heading = xyz_heading(line);
  if (heading == XyzHeading::other_columns) {
    fail(line.data(),
         "the heading " + in_quotes(line) +
             " does not begin with the columns X Y Z, separated by blanks; write the columns in this order");
    return true;
  }
  if (line.starts_with('#')) return true;
  if (heading == XyzHeading::none || heading_seen_) return false;
  heading_seen_ = true;
  out_.notes.remarks.push_back("skipped before the points: the heading " + in_quotes(line));
  return true;
}

bool XyzReader::is_count(std::string_view line) {
  const char* const end = line.data() + line.size();
  const std::string_view word = word_at(line.data(), end);
  const bool alone = skip_blanks(word.data() + word.size(), end) == end;
  if (count_place_ != nullptr || !alone || !std::ranges::all_of(word, is_digit)) return false;
  parse_integer(word.data(), end, count_);
  count_place_ = line.data();
  out_.notes.remarks.push_back("skipped before the points: the count " + printable(word, 32));
  // Files of molecules have the count, a line of text that may be empty, then atoms whose first column may be a number.
  const char* const after = skip_blanks(next_line(end, source_.end()), source_.end());
  if (after != source_.end() && (is_newline(*after) || *after == '#')) {
    fail(after,
         "an empty line or a comment after the count of points, as in files of molecules, which are not supported; of "
         "points, remove this line");
  }
  return true;
}

std::optional<Error> XyzReader::wrong_count() const {
  const std::size_t points = out_.mesh.positions.size();
  if (count_place_ == nullptr || static_cast<std::uint64_t>(count_) == points) return std::nullopt;
  return at_line(source_, count_place_, ErrorCode::unreadable_mesh,
                 "wrong count: the line says " + in_quotes(word_at(count_place_, source_.end())) +
                     " points, the file has " + std::to_string(points) + "; write the file again, or remove this line");
}

Result<ReadMesh> XyzReader::read() {
  constexpr std::size_t kUsualLine = 24;  // bytes of a point
  reserve_room(out_.mesh.positions, std::min(source_.bytes.size() / kUsualLine, limit_));
  const char* const end = source_.end();
  const char* p = after_mark(source_.text());
  for (p = skip_spaces(p, end); p != end; p = skip_spaces(p, end)) {
    const char* const line = p;
    p = skip_line(p, end);
    if (const char* const nul = std::find(line, p, '\0'); nul != p) {
      return at_line(source_, nul, ErrorCode::unreadable_mesh, "binary data in a text file");
    }
    if (out_.mesh.positions.empty() && is_preamble({line, p})) {
      if (error_) return std::move(*error_);
      continue;
    }
    if (*line == '#') continue;
    if (out_.mesh.positions.size() == limit_) return too_many(source_, "points", limit_);
    const auto point = point_at(source_, line);
    if (!point) return point.error();
    out_.mesh.positions.push_back(*point);
  }
  if (auto error = wrong_count()) return std::move(*error);
  if (out_.mesh.positions.empty()) return about(source_.part, ErrorCode::empty_mesh, "has no points");
  if (auto ok = make_cloud(source_, out_); !ok) return std::move(ok).error();
  return std::move(out_);
}

}  // namespace

Result<ReadMesh> read_xyz(const Source& source) {
  return read_without_padding(source, [](const Source& text) { return XyzReader(text).read(); });
}

}  // namespace meshgauge::api
