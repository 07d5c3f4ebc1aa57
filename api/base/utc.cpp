#include "api/base/utc.h"

#include <array>
#include <ctime>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

namespace chr = std::chrono;

constexpr std::string_view kShape = "0000-00-00T00:00:00Z";

bool has_shape(std::string_view text) {
  if (text.size() != kShape.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (kShape[i] == '0' ? !is_digit(text[i]) : text[i] != kShape[i]) return false;
  }
  return true;
}

int number(std::string_view text, std::size_t at, std::size_t digits) {
  int value = 0;
  for (const char c : text.substr(at, digits)) value = 10 * value + (c - '0');
  return value;
}

}  // namespace

std::optional<chr::system_clock::time_point> parse_utc(std::string_view text) {
  if (!has_shape(text)) return std::nullopt;
  const chr::year_month_day day{chr::year(number(text, 0, 4)), chr::month(static_cast<unsigned>(number(text, 5, 2))),
                                chr::day(static_cast<unsigned>(number(text, 8, 2)))};
  const int hour = number(text, 11, 2);
  const int minute = number(text, 14, 2);
  const int second = number(text, 17, 2);
  // system_clock counts nanoseconds in 64 bits, which overflow in 2262.
  if (!day.ok() || int(day.year()) < 1970 || int(day.year()) > 2200 || hour > 23 || minute > 59 || second > 59) {
    return std::nullopt;
  }
  return chr::sys_days(day) + chr::hours(hour) + chr::minutes(minute) + chr::seconds(second);
}

std::string to_utc(chr::system_clock::time_point time) {
  const std::time_t seconds = chr::floor<chr::seconds>(time).time_since_epoch().count();
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

std::string to_utc_ms(chr::system_clock::time_point time) {
  const auto ms = chr::floor<chr::milliseconds>(time) - chr::floor<chr::seconds>(time);
  const std::string digits = std::to_string(1000 + ms.count());  // "1007": keeps leading zeros
  return to_utc(time).replace(19, 1, "." + digits.substr(1) + "Z");
}

}  // namespace meshgauge::api
