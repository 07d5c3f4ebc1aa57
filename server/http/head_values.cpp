#include "server/http/head_values.h"

#include <algorithm>
#include <charconv>
#include <set>

#include "api/base/text.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;

constexpr std::int64_t kMostSeconds = 3600;
constexpr std::size_t kMostKeyBytes = 255;

// Removes a token, or a quoted string with backslash escapes, from `rest` and returns its text. nullopt: malformed.
std::optional<std::string> take_value(std::string_view& rest) {
  std::string value;
  if (!rest.starts_with('"')) {
    value = trimmed(next(rest, ";"));
    return is_token(value) ? std::optional(value) : std::nullopt;
  }
  for (std::size_t i = 1; i < rest.size(); ++i) {
    if (rest[i] == '"') {
      rest.remove_prefix(i + 1);
      return trimmed(next(rest, ";")).empty() ? std::optional(value) : std::nullopt;
    }
    if (rest[i] == '\\' && i + 1 < rest.size()) ++i;
    value += rest[i];
  }
  return std::nullopt;
}

// How specifically the range matches; 0: not at all.
int fit(const std::string& range, std::string_view value) {
  if (range == value) return 3;
  if (range == "*/*" || range == "*") return 1;
  const bool any_of_type = range.size() > 2 && range.ends_with("/*");
  return any_of_type && value.starts_with(std::string_view(range).substr(0, range.size() - 1)) ? 2 : 0;
}

double weight(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string parameter = lower(trimmed(next(parameters, ";")));
    if (!parameter.starts_with("q=")) continue;
    double q = 0;
    const char* const end = parameter.data() + parameter.size();
    const auto read = std::from_chars(parameter.data() + 2, end, q, std::chars_format::fixed);
    return read.ec == std::errc() && read.ptr == end && q >= 0 && q <= 1 ? q : 0;
  }
  return 1;
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
  preference = next(preference, ";");  // neither preference has parameters
  const std::string name = lower(trimmed(next(preference, "=")));
  if (name == "respond-async") found.respond_async = true;
  if (name == "wait" && !found.wait) found.wait = seconds_of(preference);
}

}  // namespace

bool for_each_parameter(std::string_view list,
                        const std::function<void(const std::string& name, const std::string& value)>& visit) {
  std::set<std::string> seen;
  while (!(list = trimmed(list)).empty()) {
    const std::size_t equals = list.find('=');
    if (equals == std::string_view::npos || !is_token(list.substr(0, equals))) return false;
    const std::string name = lower(list.substr(0, equals));
    if (!seen.insert(name).second) return false;
    list.remove_prefix(equals + 1);
    const auto value = take_value(list);
    if (!value) return false;
    visit(name, *value);
  }
  return true;
}

std::string take_kind(std::string_view& value) { return lower(trimmed(next(value, ";"))); }

double weight_of(std::string_view field, std::string_view value) {
  int best = 0;
  double found = 0;
  while (!field.empty()) {
    std::string_view element = next(field, ",");
    const int fits = fit(lower(trimmed(next(element, ";"))), value);
    if (fits <= best) continue;
    best = fits;
    found = weight(element);
  }
  return found;
}

Preferences read_preferences(const Head& head) {
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

IdempotencyKey read_idempotency_key(const Head& head) {
  const auto count = std::count_if(head.headers.begin(), head.headers.end(),
                                   [](const auto& header) { return header.first == "idempotency-key"; });
  if (count == 0) return {};
  std::string key(head.header("idempotency-key"));
  const bool visible = std::all_of(key.begin(), key.end(), [](char c) { return c > 0x20 && c < 0x7F; });
  if (count == 1 && !key.empty() && key.size() <= kMostKeyBytes && visible) return {std::move(key), std::nullopt};
  return {std::move(key), malformed("Idempotency-Key must be sent once, with 1 to 255 visible ASCII characters")};
}

std::optional<Problem> read_query(std::string_view query, const std::vector<std::string_view>& known,
                                  const ReadParameter& read) {
  std::vector<std::string_view> seen;
  while (!query.empty()) {
    std::string_view value = next(query, "&");
    const std::string_view name = next(value, "=");
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return malformed("unknown query parameter " + quoted(name) + "; known: " + api::listed(known));
    }
    if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
      return malformed("'" + std::string(name) + "' stands there twice");
    }
    seen.push_back(name);
    if (auto refusal = read(name, value)) return refusal;
  }
  return std::nullopt;
}

std::variant<std::uint64_t, Problem> whole_number(std::string_view name, std::string_view value, std::uint64_t most) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error == std::errc() && end == value.data() + value.size() && number >= 1 && number <= most) return number;
  return malformed("'" + std::string(name) + "' must be a whole number from 1 to " + std::to_string(most) + ", not " +
                   quoted(value));
}

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 40)) + "'"; }

}  // namespace meshgauge::server
