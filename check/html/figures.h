// Numbers as people read them: few digits, and never a statement that is not true of the interval.
#pragma once

#include <cstdint>
#include <string>

namespace meshgauge::check {

// x to that many significant digits, 1 to 17; zeros at the end are left out. "0.00012", "150000", "1.5e-12".
std::string to_digits(double x, int digits);
std::string to_digits_below(double x, int digits);  // the number written is not above x
std::string to_digits_above(double x, int digits);  // the number written is not below x

struct IntervalText {
  std::string lower;  // not above lower
  std::string upper;  // not below upper; "unknown" where it is infinite
  std::string limit;

  std::string both() const { return lower == upper ? lower : lower + " \xE2\x80\xA6 " + upper; }  // "1.2 … 1.3"
};

// As few digits as tell the two bounds apart, up to six, and as many as leave each on its side of the limit: what is
// written is as true as the interval is.
IntervalText to_text(double lower, double upper, double limit);

std::string grouped(std::uint64_t count);   // "1,234,567"
std::string in_bytes(std::uint64_t bytes);  // "1.4 MB"
std::string in_time(double ms);             // "1.4 s"

}  // namespace meshgauge::check
