#include "server/access/utc.h"

#include <array>
#include <cstdio>

#include "server/text.h"

namespace meshgauge::server {
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
  // A system_clock counts nanoseconds, which end in 2262.
  if (!day.ok() || int(day.year()) < 1970 || int(day.year()) > 2200 || hour > 23 || minute > 59 || second > 59) {
    return std::nullopt;
  }
  return chr::sys_days(day) + chr::hours(hour) + chr::minutes(minute) + chr::seconds(second);
}

std::string to_utc(chr::system_clock::time_point time) {
  const auto day = chr::floor<chr::days>(time);
  const chr::year_month_day date(day);
  const chr::hh_mm_ss clock(chr::floor<chr::seconds>(time - day));
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02ld:%02ld:%02ldZ", int(date.year()), unsigned(date.month()),
                unsigned(date.day()), static_cast<long>(clock.hours().count()),
                static_cast<long>(clock.minutes().count()), static_cast<long>(clock.seconds().count()));
  return text.data();
}

}  // namespace meshgauge::server
