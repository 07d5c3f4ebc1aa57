#include "api/formats/xyz_heading.h"

#include <algorithm>
#include <string>

#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

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

}  // namespace

XyzHeading xyz_heading(std::string_view line) {
  const char* const end = line.data() + line.size();
  const bool slashes = line.starts_with("//");
  const std::size_t marks = line.find_first_not_of(slashes ? '/' : '#');
  const char* const columns = marks == std::string_view::npos ? end : line.data() + marks;
  if (begins_with_x_y_z(columns, end)) return XyzHeading::x_y_z;
  return slashes || names_x_y_z(columns, end) ? XyzHeading::other_columns : XyzHeading::none;
}

}  // namespace meshgauge::api
