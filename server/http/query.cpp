#include "server/http/query.h"

#include <algorithm>
#include <charconv>

#include "api/refused.h"
#include "server/http/text.h"

namespace meshgauge::server {

using api::malformed;
using api::Problem;

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 40)) + "'"; }

std::optional<Problem> read_query(std::string_view query, const std::vector<std::string_view>& known,
                                  const ReadParameter& read) {
  std::vector<std::string_view> seen;
  while (!query.empty()) {
    std::string_view value = next(query, "&");
    const std::string_view name = next(value, "=");
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      std::string names;
      for (const std::string_view one : known) names.append(names.empty() ? "" : ", ").append(one);
      return malformed("unknown query parameter " + quoted(name) + "; known: " + names);
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

}  // namespace meshgauge::server
