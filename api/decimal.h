// Formats numbers for files and reports.
#pragma once

#include <charconv>
#include <string>

namespace meshgauge::api {

// Returns the shortest decimal text that reads back as the same number.
inline std::string shortest(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

}  // namespace meshgauge::api
