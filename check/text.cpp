#include "check/text.h"

#include <cstdio>

#include "api/base/text.h"

namespace meshgauge::check {

std::string rounded(double x, int digits) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, x);
  return buffer;
}

std::string percent_encoded(std::string_view bytes, std::string_view kept) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string uri;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = api::is_letter(c) || api::is_digit(c) || kept.find(c) != std::string_view::npos;
    uri += plain ? std::string(1, c) : std::string{'%', kHex[byte >> 4U], kHex[byte & 15U]};
  }
  return uri;
}

}  // namespace meshgauge::check
