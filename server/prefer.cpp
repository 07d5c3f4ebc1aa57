#include "server/prefer.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace meshgauge::server {
namespace {

constexpr std::int64_t kMostSeconds = 3600;

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return (x | 0x20) == (y | 0x20); });
}

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
  preference = trimmed(preference.substr(0, preference.find(';')));  // parameters mean nothing to either
  const std::size_t equals = preference.find('=');
  const std::string_view name = trimmed(preference.substr(0, equals));
  if (same_name(name, "respond-async")) found.respond_async = true;
  if (same_name(name, "wait") && equals != std::string_view::npos && !found.wait) {
    found.wait = seconds_of(preference.substr(equals + 1));
  }
}

}  // namespace

Preferences preferences(const Head& head) {
  Found found;
  for (const auto& [name, value] : head.headers) {
    if (name != "prefer") continue;
    for (std::string_view rest = value; !rest.empty();) {
      const std::size_t comma = rest.find(',');
      take(rest.substr(0, comma), found);
      rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    }
  }
  Preferences result;
  if (found.respond_async) result.applied = "respond-async";
  if (found.wait) result.applied += (result.applied.empty() ? "wait=" : ", wait=") + std::to_string(*found.wait);
  if (!result.applied.empty()) result.wait = std::chrono::seconds(found.wait.value_or(0));
  return result;
}

}  // namespace meshgauge::server
