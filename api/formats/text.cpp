#include "api/formats/text.h"

#include <clocale>
#include <cstdlib>
#include <string>

namespace meshgauge::api {

double out_of_range_value(const char* first, const char* last) {
  // from_chars tells overflow and underflow alike and leaves no value. strtod tells them apart, but would take
  // the decimal point from the process's locale, and needs the text to end by NUL.
  static const locale_t c_locale = newlocale(LC_ALL_MASK, "C", locale_t{});
  const std::string digits(first, last);
  return strtod_l(digits.c_str(), nullptr, c_locale);
}

}  // namespace meshgauge::api
