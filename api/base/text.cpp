#include "api/base/text.h"

#include <clocale>
#include <cstdlib>
#include <string>

namespace meshgauge::api {

double out_of_range_value(const char* first, const char* last) {
  // from_chars reports overflow and underflow alike and sets no value. strtod tells them apart, but takes the decimal
  // point from the process's locale and needs a NUL at the end.
  static const locale_t c_locale = newlocale(LC_ALL_MASK, "C", locale_t{});
  const std::string digits(first, last);
  return strtod_l(digits.c_str(), nullptr, c_locale);
}

std::string printable(std::string_view text, std::size_t longest) {
  std::string out(text.substr(0, longest));
  for (char& c : out) c = c >= ' ' && c <= '~' ? c : '?';
  return text.size() > longest ? out + "..." : out;
}

std::string in_quotes(std::string_view text) { return "'" + printable(text, 32) + "'"; }

}  // namespace meshgauge::api
