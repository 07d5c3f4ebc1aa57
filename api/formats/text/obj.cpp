#include "api/formats/file/readers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/base/text.h"
#include "api/formats/file/source.h"
#include "api/formats/polygons/polygons.h"

namespace meshgauge::api {
namespace {

// What a statement other than those of vertices, faces, groups and objects is of the surface.
enum class ObjRole {
  beside_points,  // says nothing of how vertices are joined: normals, materials
  attribute,      // no surface by itself: the body of a free-form surface, a quality of display
  line,           // points, lines and curves
  surface,        // a surface that is not read
  unknown,        // no word of the specification, which may be a surface; or one that statement() reads itself
};

struct Statement {
  std::string_view word;
  ObjRole role;
  std::string_view kind = {};  // of a surface, for Unread
};

// Those that place or join vertices: written otherwise, they are a mistake that changes the surface or its groups.
constexpr Statement kShapes[] = {
    {"vt", ObjRole::beside_points},
    {"vn", ObjRole::beside_points},
    {"l", ObjRole::line},
    {"p", ObjRole::line},
    {"v", ObjRole::unknown},
    {"f", ObjRole::unknown},
    {"fo", ObjRole::unknown},
    {"g", ObjRole::unknown},
    {"o", ObjRole::unknown},
    {"vp", ObjRole::attribute},
    {"curv2", ObjRole::line},  // before "curv", with which it begins
    {"curv", ObjRole::line},
    {"cdc", ObjRole::line},
    {"surf", ObjRole::surface, "free-form surfaces (surf)"},
    {"bzp", ObjRole::surface, "Bezier patches (bzp)"},
    {"bsp", ObjRole::surface, "B-spline patches (bsp)"},
    {"cdp", ObjRole::surface, "Cardinal patches (cdp)"},
    {"call", ObjRole::surface, "included files (call)"},
    {"csh", ObjRole::surface, "commands (csh)"},
};
constexpr Statement kOthers[] = {{"s", ObjRole::beside_points},
                                 {"usemtl", ObjRole::beside_points},
                                 {"mtllib", ObjRole::beside_points},
                                 {"usemap", ObjRole::attribute},
                                 {"maplib", ObjRole::attribute},
                                 {"mg", ObjRole::attribute},
                                 {"lod", ObjRole::attribute},
                                 {"bevel", ObjRole::attribute},
                                 {"c_interp", ObjRole::attribute},
                                 {"d_interp", ObjRole::attribute},
                                 {"ctech", ObjRole::attribute},
                                 {"stech", ObjRole::attribute},
                                 {"shadow_obj", ObjRole::attribute},
                                 {"trace_obj", ObjRole::attribute},
                                 {"cstype", ObjRole::attribute},
                                 {"deg", ObjRole::attribute},
                                 {"bmat", ObjRole::attribute},
                                 {"step", ObjRole::attribute},
                                 {"parm", ObjRole::attribute},
                                 {"trim", ObjRole::attribute},
                                 {"hole", ObjRole::attribute},
                                 {"scrv", ObjRole::attribute},
                                 {"sp", ObjRole::attribute},
                                 {"end", ObjRole::attribute},
                                 {"con", ObjRole::attribute},
                                 {"res", ObjRole::attribute},
                                 {"vc", ObjRole::attribute},  // colours
                                 {"vw", ObjRole::attribute},  // weights of joints
                                 // Materials, which belong into a file of their own.
                                 {"newmtl", ObjRole::attribute},
                                 {"ka", ObjRole::attribute},
                                 {"kd", ObjRole::attribute},
                                 {"ks", ObjRole::attribute},
                                 {"ke", ObjRole::attribute},
                                 {"ns", ObjRole::attribute},
                                 {"ni", ObjRole::attribute},
                                 {"tr", ObjRole::attribute},
                                 {"tf", ObjRole::attribute},
                                 {"d", ObjRole::attribute},
                                 {"illum", ObjRole::attribute},
                                 {"sharpness", ObjRole::attribute},
                                 {"bump", ObjRole::attribute},
                                 {"disp", ObjRole::attribute},
                                 {"decal", ObjRole::attribute},
                                 {"refl", ObjRole::attribute}};

const Statement* shape(std::string_view word) {
  const auto found = std::ranges::find(kShapes, word, &Statement::word);
  return found == std::end(kShapes) ? nullptr : found;
}

// What joins a number to the letters; "f_name" and "p:" may be other words.
bool is_joined(char next) {
  return is_digit(next) || std::string_view("+-.,;(/\\").find(next) != std::string_view::npos;
}

// Returns true for a word that begins a statement of vertices, faces, groups, lines or surfaces.
bool is_shape(std::string_view word) { return shape(word) != nullptr; }

// Returns the role of a statement by its first word. Constant time.
ObjRole role_of_obj(std::string_view word) {
  if (const Statement* known = shape(word)) return known->role;
  if (same_word(word.substr(0, 4), "map_")) return ObjRole::attribute;
  for (const Statement& other : kOthers) {
    if (same_word(word, other.word)) return other.role;  // "USEMTL red" is no surface either
  }
  return ObjRole::unknown;
}

// Returns the statement for which an unknown word was probably meant: "f" for "F", "F1" and "f1,2,3". Readers that pass
// over such a word lose a face or shift the indices of all others. Empty: none.
std::string_view meant_statement(std::string_view word) {
  for (const Statement& known : kShapes) {
    const std::size_t length = known.word.size();
    if (!same_word(word.substr(0, length), known.word)) continue;
    const bool names_group = known.word == "g" || known.word == "o";
    if (word.size() == length || (is_joined(word[length]) && !names_group)) return known.word;
  }
  return {};
}

// Counts statements that are not read, by their first words. Borrows the words.
class UnreadStatements {
 public:
  // Constant time, without allocation beyond the first words.
  void add(std::string_view word);

  void move_to(Unread& unread);

 private:
  std::vector<std::pair<std::string_view, std::size_t>> words_;  // at most Unread::kMostKinds
  std::size_t others_ = 0;
};

void UnreadStatements::add(std::string_view word) {
  const auto known = std::ranges::find(words_, word, [](const auto& one) { return one.first; });
  if (known != words_.end()) {
    ++known->second;
  } else if (words_.size() < Unread::kMostKinds) {
    words_.emplace_back(word, 1);
  } else {
    ++others_;
  }
}

void UnreadStatements::move_to(Unread& unread) {
  constexpr std::size_t kLongestWord = 32;
  for (const auto& [word, count] : words_) {
    const Statement* known = shape(word);
    const std::string unknown = "unknown statements (" + printable(word, kLongestWord) + ")";
    unread.add(known != nullptr ? known->kind : unknown, count);
  }
  if (others_ > 0) unread.add("other unknown statements", others_);
  words_.clear();
  others_ = 0;
}

struct ObjEstimate {
  std::size_t vertices = 0;
  std::size_t faces = 0;
};

// Estimates the counts from small windows spread over the file; zeros for a small file. A hint for allocation: one of
// about the right size replaces twenty that double, each with its copy and its page faults.
ObjEstimate estimate_obj(std::string_view text) {
  constexpr std::size_t kWindows = 64;
  constexpr std::size_t kWindowBytes = 4096;
  if (text.size() < kWindows * kWindowBytes) return {};
  ObjEstimate found;
  for (std::size_t i = 0; i < kWindows; ++i) {
    const char* p = text.data() + (text.size() - kWindowBytes) / kWindows * i;
    for (const char* const end = p + kWindowBytes - 2; p < end; ++p) {
      found.vertices += is_newline(*p) && p[1] == 'v' && is_blank(p[2]);
      found.faces += is_newline(*p) && p[1] == 'f' && is_blank(p[2]);
    }
  }
  const double scale = 1.04 * static_cast<double>(text.size()) / static_cast<double>(kWindows * kWindowBytes);
  return {static_cast<std::size_t>(static_cast<double>(found.vertices) * scale),
          static_cast<std::size_t>(static_cast<double>(found.faces) * scale)};
}

// Each reading function takes a place in the text and returns the place after what it read; nullptr: error_ has the
// defect.
class ObjReader {
 public:
  explicit ObjReader(const Source& source)
      : source_(source), end_(source.end()), vertex_limit_(vertex_limit(source)), faces_(out_.mesh.triangles) {
    out_.format = Format::obj;
  }

  Result<ReadMesh> read();

 private:
  const char* statement(const char* p);
  const char* vertex(const char* p);
  const char* vertex_extras(const char* p);
  const char* face(const char* p);
  const char* plain_triangle(const char* p);
  const char* corner(const char* p);
  const char* texture_and_normal(const char* p, const char* token);
  const char* group(const char* p);
  const char* object(const char* p);
  void end_groups();
  void end_object();
  const char* other(const char* p);
  const char* unknown(const char* p, std::string_view word);
  const char* pass_over(const char* p, bool continues);
  const char* resolve(std::int64_t index, const char* place);

  const char* end_of_continuation(const char* p) const;
  const char* blanks(const char* p) const;
  bool at_line_end(const char* p) const { return p == end_ || is_newline(*p); }
  bool at_token_end(const char* p) const {
    return at_line_end(p) || is_blank(*p) || (*p == '\\' && end_of_continuation(p) != nullptr);
  }
  const char* fail(const char* place, ErrorCode code, const std::string& what);
  const char* bad_number(const char* p);
  const char* binary_data(const char* p) { return fail(p, ErrorCode::unreadable_mesh, "binary data in a text file"); }

  const Source& source_;
  const char* end_;
  std::size_t vertex_limit_;
  ReadMesh out_;
  Faces faces_;
  UnreadStatements unread_;
  GroupCollector groups_;
  std::vector<std::string_view> names_;  // of the groups that faces are in now
  std::string_view object_;              // that faces are in now; empty: none
  std::size_t first_of_groups_ = 0;      // the first triangle of each
  std::size_t first_of_object_ = 0;
  // The highest index so far of a vertex not yet read, and its place.
  std::size_t highest_forward_ = 0;
  const char* highest_forward_place_ = nullptr;
  bool only_points_ = true;  // no statement that may be of a surface or a curve: the vertices may be a cloud
  std::optional<Error> error_;
};

const char* ObjReader::fail(const char* place, ErrorCode code, const std::string& what) {
  error_ = at_line(source_, place, code, what);
  return nullptr;
}

const char* ObjReader::bad_number(const char* p) {
  if (at_line_end(p)) return fail(p, ErrorCode::unreadable_mesh, "a vertex needs three coordinates");
  return fail(p, ErrorCode::unreadable_mesh, in_quotes(word_at(p, end_)) + " is not a number");
}

// Returns the start of the next line when p is a backslash that ends its line, else nullptr.
const char* ObjReader::end_of_continuation(const char* p) const {
  if (++p == end_ || !is_newline(*p)) return nullptr;
  return p + (*p == '\r' && p + 1 != end_ && p[1] == '\n' ? 2 : 1);
}

const char* ObjReader::blanks(const char* p) const {
  for (;;) {
    p = skip_blanks(p, end_);
    if (p == end_ || *p != '\\') [[likely]]
      return p;
    const char* next = end_of_continuation(p);
    if (next == nullptr) return p;
    p = next;
  }
}

const char* ObjReader::vertex(const char* p) {
  Vec3 position;
  for (int k = 0; k < 3; ++k) {
    p = blanks(p);
    const char* next = parse_number(p, end_, position[k]);
    if (next == nullptr || !at_token_end(next)) return bad_number(p);
    if (!std::isfinite(position[k])) {
      return fail(p, ErrorCode::non_finite_vertex, "the coordinate " + in_quotes(word_at(p, end_)) + " is not finite");
    }
    p = next;
  }
  if (out_.mesh.positions.size() == vertex_limit_) {
    error_ = too_many(source_, "vertices", vertex_limit_);
    return nullptr;
  }
  out_.mesh.positions.push_back(position);
  return at_line_end(p) ? p : vertex_extras(p);
}

// Checks a weight, a colour or both. They do not affect the surface, but anything else means a broken line.
const char* ObjReader::vertex_extras(const char* p) {
  constexpr int kMost = 4;
  for (int count = 0;; ++count) {
    p = blanks(p);
    if (at_line_end(p) || *p == '#') return pass_over(p, false);
    if (count == kMost) return fail(p, ErrorCode::unreadable_mesh, "a vertex has more than seven numbers");
    double ignored = 0;
    const char* next = parse_number(p, end_, ignored);
    if (next == nullptr || !at_token_end(next)) return bad_number(p);
    p = next;
  }
}

// Reads the most frequent form at twice the speed of face(): three times a space and an index of a vertex already read,
// then the line's end. nullptr: the line has anything else; nothing is changed.
const char* ObjReader::plain_triangle(const char* p) {
  constexpr std::ptrdiff_t kMostDigits = 9;
  constexpr std::ptrdiff_t kLongest = 3 * (1 + kMostDigits) + 1;
  if (end_ - p < kLongest) return nullptr;
  const std::size_t known = out_.mesh.positions.size();
  Triangle triangle;
  for (std::uint32_t& corner : triangle) {
    if (*p++ != ' ') return nullptr;
    std::uint32_t index = 0;
    const char* const first = p;
    for (; is_digit(*p) && p - first < kMostDigits; ++p) index = index * 10 + static_cast<std::uint32_t>(*p - '0');
    corner = index - 1;  // 0 wraps around to an index beyond any vertex
    if (corner >= known) return nullptr;
  }
  if (!is_newline(*p)) return nullptr;
  out_.mesh.triangles.push_back(triangle);
  return p;
}

const char* ObjReader::face(const char* p) {
  if (out_.mesh.triangles.size() < source_.limits.max_triangles) {
    if (const char* next = plain_triangle(p)) return next;
  }
  const char* const line = p;
  faces_.begin();
  for (p = blanks(p); !at_line_end(p) && *p != '#'; p = blanks(p)) {
    p = corner(p);
    if (p == nullptr) return nullptr;
    if (out_.mesh.triangles.size() > source_.limits.max_triangles) {
      error_ = too_many(source_, "triangles", source_.limits.max_triangles);
      return nullptr;
    }
  }
  if (faces_.corners() == 0) return fail(line, ErrorCode::unreadable_mesh, "a face without corners");
  out_.notes.skipped_primitives += faces_.corners() < 3;
  faces_.end();
  return pass_over(p, false);
}

const char* ObjReader::corner(const char* p) {
  std::int64_t index = 0;
  const char* next = parse_integer(p, end_, index);
  if (next == nullptr) return fail(p, ErrorCode::unreadable_mesh, in_quotes(word_at(p, end_)) + " is not an index");
  if (!at_token_end(next)) {
    next = texture_and_normal(next, p);
    if (next == nullptr) return nullptr;
  }
  return resolve(index, p) == nullptr ? nullptr : next;
}

// Skips "/t", "//n" or "/t/n", also with nothing after a slash.
const char* ObjReader::texture_and_normal(const char* p, const char* token) {
  for (int slashes = 0; slashes < 2 && p != end_ && *p == '/'; ++slashes) {
    std::int64_t ignored = 0;
    const char* next = parse_integer(++p, end_, ignored);
    if (next != nullptr) p = next;
  }
  if (at_token_end(p)) return p;
  return fail(token, ErrorCode::unreadable_mesh, in_quotes(word_at(token, end_)) + " is not an index");
}

const char* ObjReader::resolve(std::int64_t index, const char* place) {
  const auto count = static_cast<std::int64_t>(out_.mesh.positions.size());
  if (index == 0) return fail(place, ErrorCode::index_out_of_range, "index 0: indices count from 1");
  const std::int64_t resolved = index > 0 ? index - 1 : count + index;
  if (resolved < 0 || resolved >= static_cast<std::int64_t>(vertex_limit_)) {
    return fail(place, ErrorCode::index_out_of_range,
                "index " + in_quotes(word_at(place, end_)) + " names no vertex; " + std::to_string(count) +
                    " are defined before it");
  }
  if (resolved >= count && static_cast<std::size_t>(resolved) >= highest_forward_) {
    highest_forward_ = static_cast<std::size_t>(resolved);
    highest_forward_place_ = place;
  }
  faces_.add(static_cast<std::uint32_t>(resolved));
  return place;
}

// Skips to the end of the statement; a comment does not continue. Refuses binary data, and a line joined to it that
// begins with a statement of the surface: the '\' is then the end of a name or a path.
const char* ObjReader::pass_over(const char* p, bool continues) {
  for (; p != end_ && !is_newline(*p); ++p) {
    if (*p == '\0') return binary_data(p);
    continues = continues && !(*p == '#' && is_space(p[-1]));
    if (*p != '\\' || !continues) continue;
    const char* const next = end_of_continuation(p);
    if (next == nullptr) continue;
    const char* const line = skip_blanks(next, end_);
    if (const std::string_view word = word_at(line, end_); is_shape(word)) {
      return fail(line, ErrorCode::unreadable_mesh,
                  "'\\' at the end of the line before joins the statement " + in_quotes(word) +
                      " to that line; remove the '\\'");
    }
    p = next - 1;
  }
  return p;
}

std::string_view without_blanks_behind(const char* begin, const char* end) {
  const std::string_view text(begin, end);
  return text.substr(0, text.find_last_not_of(" \t") + 1);
}

void ObjReader::end_groups() {
  const std::size_t end = out_.mesh.triangles.size();
  for (const std::string_view name : names_) groups_.add(name, first_of_groups_, end);
  names_.clear();
  first_of_groups_ = end;
}

void ObjReader::end_object() {
  groups_.add(object_, first_of_object_, out_.mesh.triangles.size());
  first_of_object_ = out_.mesh.triangles.size();
}

// Reads the names of the groups that the faces after it belong to. A line of millions would take 16 bytes a name.
const char* ObjReader::group(const char* p) {
  end_groups();
  if (pass_over(p, true) == nullptr) return nullptr;
  for (p = blanks(p); !at_line_end(p) && *p != '#'; p = blanks(p)) {
    if (names_.size() == kMostGroupRanges) return groups_.give_up(), pass_over(p, true);
    const char* const name = p;
    for (; !at_token_end(p); ++p) {
      if (*p == '\0') return binary_data(p);
    }
    names_.emplace_back(name, p);
  }
  return pass_over(p, false);
}

// Reads the name of the object that the faces after it belong to: the rest of the line, up to a comment.
const char* ObjReader::object(const char* p) {
  end_object();
  p = skip_blanks(p, end_);
  const char* end = pass_over(p, true);
  if (end == nullptr) return nullptr;
  for (const char* hash = std::find(p, end, '#'); hash != end; hash = std::find(hash + 1, end, '#')) {
    if (is_space(hash[-1])) return object_ = without_blanks_behind(p, hash), pass_over(hash, false);
  }
  object_ = without_blanks_behind(p, end);
  return end;
}

const char* ObjReader::other(const char* p) {
  if (*p == '#' || *p == '$') return pass_over(p, false);  // '$': a comment of old exporters
  if (*p == '\\' && end_of_continuation(p) != nullptr) return blanks(p);
  // Anything but a word is the rest of a broken line; skipping that would silently lose a part of the mesh.
  if (!is_letter(*p)) {
    if (static_cast<unsigned char>(*p) < ' ') return binary_data(p);
    return fail(p, ErrorCode::unreadable_mesh, in_quotes(word_at(p, end_)) + " does not begin an OBJ statement");
  }
  const char* word_end = p;
  while (!at_token_end(word_end) && !is_space(*word_end)) ++word_end;
  const std::string_view word(p, word_end);
  const ObjRole role = role_of_obj(word);
  only_points_ = only_points_ && role == ObjRole::beside_points;
  out_.notes.skipped_primitives += role == ObjRole::line;
  if (role == ObjRole::surface) unread_.add(word);
  if (role == ObjRole::unknown) return unknown(p, word);
  return pass_over(word_end, true);
}

const char* ObjReader::unknown(const char* p, std::string_view word) {
  if (const std::string_view meant = meant_statement(word); !meant.empty()) {
    return fail(p, ErrorCode::unreadable_mesh,
                in_quotes(word) + " does not begin an OBJ statement; write " + in_quotes(meant) +
                    ", in lower case and with a blank behind it");
  }
  unread_.add(word);
  return pass_over(p, true);
}

const char* ObjReader::statement(const char* p) {
  const bool one_letter = p + 1 == end_ || is_space(p[1]) || p[1] == '\\';
  if (*p == 'v' && one_letter) return vertex(p + 1);
  if (*p == 'f' && one_letter) return face(p + 1);
  if (*p == 'g' && one_letter) return group(p + 1);
  if (*p == 'o' && one_letter) return object(p + 1);
  const bool two_letters = p + 1 != end_ && at_token_end(p + 2);
  if (*p == 'f' && two_letters && p[1] == 'o') return face(p + 2);  // faces in the format's first versions
  return other(p);
}

Result<ReadMesh> ObjReader::read() {
  const ObjEstimate expected = estimate_obj(source_.text());
  reserve_room(out_.mesh.positions, std::min(expected.vertices, vertex_limit_));
  reserve_room(out_.mesh.triangles, std::min(expected.faces, source_.limits.max_triangles));

  const char* p = after_mark(source_.text());
  for (p = skip_spaces(p, end_); p != end_; p = skip_spaces(p, end_)) {
    p = statement(p);
    if (p == nullptr) return std::move(*error_);
  }
  if (highest_forward_place_ != nullptr && highest_forward_ >= out_.mesh.positions.size()) {
    return at_line(source_, highest_forward_place_, ErrorCode::index_out_of_range,
                   "index " + std::to_string(highest_forward_ + 1) + ", but the file has " +
                       std::to_string(out_.mesh.positions.size()) + " vertices");
  }
  end_groups();
  end_object();
  out_.groups = groups_.take();
  unread_.move_to(out_.unread);
  if (auto split = split_polygons(source_, faces_.runs(), out_); !split) return std::move(split).error();
  if (out_.mesh.triangles.empty() && out_.notes.skipped_primitives == 0 && only_points_) {
    if (auto ok = make_cloud(source_, out_); !ok) return std::move(ok).error();
  }
  return std::move(out_);
}

}  // namespace

Result<ReadMesh> read_obj(const Source& source) {
  return read_without_padding(source, [](const Source& text) { return ObjReader(text).read(); });
}

}  // namespace meshgauge::api
