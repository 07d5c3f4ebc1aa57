// The query of a request: name=value pairs between "&". Nothing is decoded: the values that are allowed need no
// escapes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/problem.h"

namespace meshgauge::server {

// Calls read(name, value) for each parameter. Returns the first problem: an unknown name, a name that stands there
// twice, or what read() returns.
using ReadParameter = std::function<std::optional<api::Problem>(std::string_view name, std::string_view value)>;
std::optional<api::Problem> read_query(std::string_view query, const std::vector<std::string_view>& known,
                                       const ReadParameter& read);

// The value as a whole number from 1 to `most`.
std::variant<std::uint64_t, api::Problem> whole_number(std::string_view name, std::string_view value,
                                                       std::uint64_t most);

std::string quoted(std::string_view text);  // the beginning of a client's text, for a message

}  // namespace meshgauge::server
