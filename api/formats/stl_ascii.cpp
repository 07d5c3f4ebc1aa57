#include "api/formats/stl_ascii.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

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

}  // namespace

Result<ReadMesh> read_ascii_stl(const Source& source) { return AsciiReader(source).read(); }

}  // namespace meshgauge::api
