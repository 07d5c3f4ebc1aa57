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

std::string percent_encoded(std::string_view bytes, std::string_view kept) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string uri;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = is_letter(c) || is_digit(c) || kept.find(c) != std::string_view::npos;
    uri += plain ? std::string(1, c) : std::string{'%', kHex[byte >> 4U], kHex[byte & 15U]};
  }
  return uri;
}

}  // namespace meshgauge::api
