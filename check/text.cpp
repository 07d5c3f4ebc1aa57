#include "check/text.h"

#include <cstdio>

namespace meshgauge::check {

std::string rounded(double x, int digits) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, x);
  return buffer;
}

}  // namespace meshgauge::check
