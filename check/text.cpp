#include "check/text.h"

#include <charconv>
#include <cstdio>

#include "api/formats/text.h"

namespace meshgauge::check {

std::string shortest(double x) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, x).ptr;
  return {digits, end};
}

std::string rounded(double x, int digits) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, x);
  return buffer;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && api::is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && api::is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string text(const Vec3& p) {
  return "(" + shortest(p.x()) + ", " + shortest(p.y()) + ", " + shortest(p.z()) + ")";
}

}  // namespace meshgauge::check
