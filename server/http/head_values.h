// Values of headers and the query of a request, for its handlers.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/base/problem.h"
#include "server/http/head.h"

namespace meshgauge::server {

// Calls visit(name, value) for each "name=value" of a list separated by semicolons, names in lower case: the parameters
// of a header's value (RFC 9110 section 5.6.6), form-data; name="a"; filename="part.stl". Returns false at the first
// element that is malformed or has the name of an earlier one: of two boundaries another parser may take the other one.
bool for_each_parameter(std::string_view list,
                        const std::function<void(const std::string& name, const std::string& value)>& visit);

// Removes from `value` what comes before the parameters, and returns it in lower case: the media type of a
// Content-Type, the kind of a Content-Disposition.
std::string take_kind(std::string_view& value);

// Content negotiation (RFC 9110 section 12.5). Returns the weight, 0 to 1, that a field such as Accept or
// Accept-Encoding gives to a value: that of its most specific element that matches ("text/html" before "text/*" before
// "*/*" or "*"). 0: no element matches, the value is refused, or its weight is malformed. Other parameters are ignored.
double weight_of(std::string_view field, std::string_view value);

// The header Prefer (RFC 7240): Prefer: respond-async, wait=10
struct Preferences {
  // Time that the client waits for the result before it gets a 202; nullopt: until the result is there.
  std::optional<std::chrono::milliseconds> wait;
  std::string applied;  // value for Preference-Applied; empty: no preference was sent
};

// Unknown and malformed preferences are ignored, as the RFC demands. Of two with the same name the first counts. `wait`
// is capped at one hour.
Preferences read_preferences(const Head& head);

// The header Idempotency-Key: a client's name for a request, under which it can be repeated safely.
struct IdempotencyKey {
  std::string value;                    // as sent; empty: none was sent, or an empty one
  std::optional<api::Problem> problem;  // it was sent twice, or is not 1 to 255 visible ASCII characters
};
IdempotencyKey read_idempotency_key(const Head& head);

// The query: name=value pairs between "&". Nothing is decoded: the values that are allowed need no escapes. Calls
// read(name, value) for each parameter. Returns the first problem: an unknown name, a name that stands there twice, or
// what read() returns.
using ReadParameter = std::function<std::optional<api::Problem>(std::string_view name, std::string_view value)>;
std::optional<api::Problem> read_query(std::string_view query, const std::vector<std::string_view>& known,
                                       const ReadParameter& read);

// The value as a whole number from 1 to `most`.
std::variant<std::uint64_t, api::Problem> whole_number(std::string_view name, std::string_view value,
                                                       std::uint64_t most);

std::string quoted(std::string_view text);  // the beginning of a client's text, for a message

}  // namespace meshgauge::server
