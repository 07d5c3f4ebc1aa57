#include "api/base/figures.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace meshgauge::api {
namespace {

constexpr int kFewest = 4;
constexpr int kMost = 17;  // distinguishes all doubles

double parsed(const std::string& text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// Shortest digits that read back as x: fixed notation for common sizes, otherwise "1.5e-6".
std::string plain(double x) {
  char text[64];
  const double size = std::abs(x);
  const bool fixed = size == 0 || (size >= 1e-4 && size < 1e9);
  const auto form = fixed ? std::chars_format::fixed : std::chars_format::scientific;
  std::string digits(text, std::to_chars(text, text + sizeof text, x, form).ptr);
  const auto e = digits.find('e');
  if (e == std::string::npos) return digits;
  digits.erase(e + 2, digits[e + 2] == '0' ? 1 : 0);  // exponents of two digits
  return digits.erase(e + 1, digits[e + 1] == '+' ? 1 : 0);
}

// x as an integer times a power of ten: "123456e-7".
struct Decimal {
  long long digits = 0;
  int exponent = 0;

  double value() const { return parsed(std::to_string(digits) + "e" + std::to_string(exponent)); }
};

Decimal rounded_to(double x, int digits) {
  char text[48];
  const auto end = std::to_chars(text, text + sizeof text, x, std::chars_format::scientific, digits - 1).ptr;
  std::string mantissa(text, end);
  const auto e = mantissa.find('e');
  const int exponent = std::atoi(mantissa.c_str() + e + 1);
  mantissa.erase(e);
  if (const auto point = mantissa.find('.'); point != std::string::npos) mantissa.erase(point, 1);
  return {std::atoll(mantissa.c_str()), exponent - (digits - 1)};
}

constexpr int kEnough = 6;  // digits; bounds that agree in them need not be told apart

// Whether the text gives the right verdict and an interval that is not much wider.
bool true_of(const IntervalText& text, double lower, double upper, double limit, int digits) {
  const double low = std::isfinite(lower) ? parsed(text.lower) : lower, high = parsed(text.upper),
               most = parsed(text.limit);
  if ((lower > limit) != (low > most)) return false;
  if (!std::isfinite(upper)) return true;
  return (upper <= limit) == (high <= most) && (digits >= kEnough || high - low <= 1.5 * (upper - lower));
}

}  // namespace

std::string to_digits(double x, int digits) {
  return std::isfinite(x) ? plain(rounded_to(x, digits).value()) : x > 0 ? "unknown" : "-";
}

std::string to_digits_below(double x, int digits) {
  if (!std::isfinite(x)) return "unknown";
  Decimal decimal = rounded_to(x, digits);
  if (decimal.value() > x) --decimal.digits;
  return plain(decimal.value());
}

std::string to_digits_above(double x, int digits) {
  if (!std::isfinite(x)) return "unknown";
  Decimal decimal = rounded_to(x, digits);
  if (decimal.value() < x) ++decimal.digits;
  return plain(decimal.value());
}

std::string plus_minus(double length, std::string_view unit) {
  return length > 0 ? " \xC2\xB1 " + with_unit(to_digits(length, 6), unit) : "";
}

// The last iteration succeeds: 17 digits distinguish all doubles.
IntervalText to_text(double lower, double upper, double limit) {
  IntervalText text;
  for (int digits = kFewest; digits <= kMost; ++digits) {
    text.lower = to_digits_below(lower, digits);
    text.upper = std::isfinite(upper) ? to_digits_above(upper, digits) : "unknown";
    text.limit = plain(limit).size() <= 10 ? plain(limit) : to_digits(limit, digits);
    if (true_of(text, lower, upper, limit, digits)) break;
  }
  return text;
}

std::string grouped(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3) {
    text.insert(static_cast<std::size_t>(at), 1, ',');
  }
  return text;
}

std::string in_bytes(std::uint64_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (size < 1e3) return std::to_string(bytes) + " B";
  if (size < 1e6) return to_digits(size / 1e3, 3) + " kB";
  return size < 1e9 ? to_digits(size / 1e6, 3) + " MB" : to_digits(size / 1e9, 3) + " GB";
}

std::string in_time(double ms) {
  if (ms < 1000) return to_digits(ms, ms < 10 ? 2 : 3) + " ms";
  return ms < 120'000 ? to_digits(ms / 1000, 3) + " s" : to_digits(ms / 60'000, 3) + " min";
}

std::string in_words(const Vec3& point) {
  constexpr int kPointDigits = 7, kLeastDecimals = 4;
  const double largest = point.cwiseAbs().maxCoeff();
  const int before = largest > 0 ? static_cast<int>(std::floor(std::log10(largest))) + 1 : 0;
  const int decimals = std::max(kPointDigits - before, kLeastDecimals);
  const auto text = [decimals](double x) {
    char digits[512];
    const auto end = std::to_chars(digits, digits + sizeof digits, x, std::chars_format::fixed, decimals).ptr;
    return plain(parsed({digits, end}) + 0.0);  // + 0.0: -0 is 0
  };
  return "(" + text(point.x()) + ", " + text(point.y()) + ", " + text(point.z()) + ")";
}

std::string edges_in_words(std::uint64_t count, std::string_view kind, const Vec3& first, std::string_view unit) {
  return std::to_string(count) + " " + std::string(kind) + (count == 1 ? " edge, at " : " edges, the first at ") +
         with_unit(in_words(first), unit);
}

}  // namespace meshgauge::api
