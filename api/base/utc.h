// Converts times to and from text: "2027-01-31T12:00:00Z" (RFC 3339 in UTC).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace meshgauge::api {

// Parses a time with a resolution of one second, from 1970 to 2200. nullopt: not such a time.
std::optional<std::chrono::system_clock::time_point> parse_utc(std::string_view text);

std::string to_utc(std::chrono::system_clock::time_point time);     // "2027-01-31T12:00:00Z"
std::string to_utc_ms(std::chrono::system_clock::time_point time);  // "2027-01-31T12:00:00.123Z"

}  // namespace meshgauge::api
