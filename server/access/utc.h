// Times in files: "2027-01-31T12:00:00Z" (RFC 3339 in UTC, to the second).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace meshgauge::server {

std::optional<std::chrono::system_clock::time_point> parse_utc(std::string_view text);  // nullopt: no such time
std::string to_utc(std::chrono::system_clock::time_point time);

}  // namespace meshgauge::server
