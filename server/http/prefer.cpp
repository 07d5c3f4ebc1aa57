#include "server/http/prefer.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "server/http/text.h"

namespace meshgauge::server {
namespace {

constexpr std::int64_t kMostSeconds = 3600;

std::optional<std::int64_t> seconds_of(std::string_view value) {
  value = trimmed(value);
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
  std::int64_t seconds = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), seconds);
  if (end != value.data() + value.size() || value.empty() || value.front() == '-') return std::nullopt;
  if (error == std::errc::result_out_of_range) return kMostSeconds;
  if (error != std::errc()) return std::nullopt;
  return std::min(seconds, kMostSeconds);
}

struct Found {
  bool respond_async = false;
  std::optional<std::int64_t> wait;
};

void take(std::string_view preference, Found& found) {
  preference = next(preference, ";");  // neither preference has parameters
  const std::string name = lower(trimmed(next(preference, "=")));
  if (name == "respond-async") found.respond_async = true;
  if (name == "wait" && !found.wait) found.wait = seconds_of(preference);
}

}  // namespace

Preferences preferences(const Head& head) {
  Found found;
  for (const auto& [name, value] : head.headers) {
    if (name != "prefer") continue;
    for (std::string_view rest = value; !rest.empty();) take(next(rest, ","), found);
  }
  Preferences result;
  if (found.respond_async) result.applied = "respond-async";
  if (found.wait) result.applied += (result.applied.empty() ? "wait=" : ", wait=") + std::to_string(*found.wait);
  if (!result.applied.empty()) result.wait = std::chrono::seconds(found.wait.value_or(0));
  return result;
}

}  // namespace meshgauge::server
