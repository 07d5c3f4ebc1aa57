#include "server/http/parameters.h"

#include <optional>

#include "server/http/text.h"

namespace meshgauge::server {
namespace {

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

}  // namespace

bool for_each_parameter(std::string_view list,
                        const std::function<void(const std::string& name, const std::string& value)>& visit) {
  while (!(list = trimmed(list)).empty()) {
    const std::size_t equals = list.find('=');
    if (equals == std::string_view::npos || !is_token(list.substr(0, equals))) return false;
    const std::string name = lower(list.substr(0, equals));
    list.remove_prefix(equals + 1);
    const auto value = take_value(list);
    if (!value) return false;
    visit(name, *value);
  }
  return true;
}

std::string take_kind(std::string_view& value) { return lower(trimmed(next(value, ";"))); }

}  // namespace meshgauge::server
