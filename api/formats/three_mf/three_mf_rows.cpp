#include "api/formats/three_mf/three_mf_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "api/base/text.h"
#include "api/formats/file/source.h"

namespace meshgauge::api {
namespace {

constexpr unsigned kAllThree = 7;  // bits of x, y and z, and of v1, v2 and v3

// Attributes of a triangle that are not read. More names would need a limit, as expat's memory for names is one.
constexpr std::string_view kIgnored[] = {"pid", "p1", "p2", "p3", "paint_color", "paint_seam", "paint_supports"};

// A place in a text that ends with '>'. No step but end() goes behind a '>', so the last one stops each loop, and no
// step needs to look for the end of the text. Each returns false where the text is not of the common form.
class RowCursor {
 public:
  explicit RowCursor(std::string_view text) : begin_(text.data()), p_(begin_), end_(begin_ + text.size()) {}

  XmlTaken taken() const { return {static_cast<std::size_t>(p_ - begin_), lines_}; }

  // Goes behind white space and `tag`.
  bool begin(std::string_view tag) {
    if (p_ == end_) return false;
    spaces();
    return word(tag);
  }

  // Goes to the next attribute. false: there is none, or no space before it.
  bool attribute() { return spaces() && *p_ != '/'; }
  char here() const { return *p_; }
  char after() const { return *p_ == '>' ? '\0' : p_[1]; }

  // Goes behind `word`, which has no '>'.
  bool word(std::string_view word) {
    if (static_cast<std::size_t>(end_ - p_) <= word.size() || !std::equal(word.begin(), word.end(), p_)) return false;
    p_ += word.size();
    return true;
  }

  // Goes behind `length` letters of a name, which are here, and ="VALUE".
  bool coordinate(std::size_t length, double& value) {
    if (!open(length)) return false;
    const char* const next = parse_number(p_, end_, value);
    return next != nullptr && std::isfinite(value) && close(next);
  }
  bool index(std::size_t length, std::size_t vertices, std::uint32_t& value) {
    std::int64_t number = 0;
    if (!open(length)) return false;
    const char* const next = parse_integer(p_, end_, number);
    if (next == nullptr || static_cast<std::uint64_t>(number) >= vertices) return false;
    value = static_cast<std::uint32_t>(number);
    return close(next);
  }
  bool ignored(std::size_t length) {
    if (!open(length)) return false;
    const char* next = p_;
    while (*next >= ' ' && *next <= '~' && *next != '<' && *next != '&' && *next != '>' && *next != quote_) ++next;
    return close(next);
  }

  // Goes behind the "/>" of the tag.
  bool end() {
    if (*p_ != '/' || p_[1] != '>') return false;
    p_ += 2;
    return true;
  }

 private:
  // Counts lines as expat does: they end with \n, \r\n or \r.
  bool spaces() {
    const char* const before = p_;
    for (;; ++p_) {
      if (*p_ == ' ' || *p_ == '\t' || (*p_ == '\r' && p_[1] == '\n')) continue;
      if (!is_newline(*p_)) return p_ != before;
      ++lines_;
    }
  }
  bool open(std::size_t length) {
    p_ += length;
    if (*p_ != '=') return false;
    quote_ = *++p_;
    if (quote_ != '"' && quote_ != '\'') return false;
    ++p_;
    return true;
  }
  bool close(const char* next) {
    if (*next != quote_) return false;
    p_ = next + 1;
    return true;
  }

  const char* begin_;
  const char* p_;
  const char* end_;
  std::size_t lines_ = 0;
  char quote_ = '\0';
};

// Sets a bit of `seen`; false: it is set.
bool set_first_time(unsigned bit, unsigned& seen) {
  const bool is_first = (seen >> bit & 1U) == 0;
  seen |= 1U << bit;
  return is_first;
}

bool read_vertex(RowCursor& at, Vec3& position) {
  if (!at.begin("<vertex")) return false;
  unsigned seen = 0;
  while (at.attribute()) {
    const char axis = at.here();
    if (axis < 'x' || axis > 'z' || !set_first_time(static_cast<unsigned>(axis - 'x'), seen)) return false;
    if (!at.coordinate(1, position[axis - 'x'])) return false;
  }
  return seen == kAllThree && at.end();
}

bool read_ignored(RowCursor& at, unsigned& seen) {
  constexpr unsigned kFirstBit = 3;
  for (std::size_t i = 0; i < std::size(kIgnored); ++i) {
    if (!at.word(kIgnored[i])) continue;
    return set_first_time(kFirstBit + static_cast<unsigned>(i), seen) && at.ignored(0);
  }
  return false;
}

bool read_triangle(RowCursor& at, std::size_t vertices, Triangle& triangle) {
  if (!at.begin("<triangle")) return false;
  unsigned seen = 0;
  while (at.attribute()) {
    if (at.here() != 'v') {
      if (!read_ignored(at, seen)) return false;
      continue;
    }
    const char number = at.after();
    if (number < '1' || number > '3') return false;
    const auto corner = static_cast<unsigned>(number - '1');
    if (!set_first_time(corner, seen) || !at.index(2, vertices, triangle[corner])) return false;
  }
  return (seen & kAllThree) == kAllThree && at.end();
}

template <class Row, class ReadRow>
XmlTaken take_rows(std::string_view text, std::size_t most, std::vector<Row>& rows, const ReadRow& read_row) {
  constexpr std::size_t kFewestBytes = 27;  // of <vertex x="1" y="1" z="1"/>
  reserve_more(rows, std::min(text.size() / kFewestBytes, most - rows.size()));
  RowCursor at(text);
  XmlTaken taken;
  for (Row row; rows.size() < most && read_row(at, row); taken = at.taken()) rows.push_back(row);
  return taken;
}

}  // namespace

XmlTaken take_mf_vertices(std::string_view text, std::size_t most, std::vector<Vec3>& positions) {
  return take_rows(text, most, positions, [](RowCursor& at, Vec3& position) { return read_vertex(at, position); });
}

XmlTaken take_mf_triangles(std::string_view text, std::size_t most, std::size_t vertices,
                           std::vector<Triangle>& triangles) {
  return take_rows(text, most, triangles,
                   [&](RowCursor& at, Triangle& triangle) { return read_triangle(at, vertices, triangle); });
}

}  // namespace meshgauge::api
