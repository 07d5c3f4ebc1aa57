// The parameters of a header's value: form-data; name="a"; filename="part.stl" (RFC 9110 section 5.6.6).
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace meshgauge::server {

// Calls visit(name, value) for each "name=value" of a list that semicolons part, names in lower case; false when the
// list is malformed.
bool for_each_parameter(std::string_view list,
                        const std::function<void(const std::string& name, const std::string& value)>& visit);

// What a Content-Type or Content-Disposition says before its parameters, in lower case; `value` is left with these.
std::string take_kind(std::string_view& value);

}  // namespace meshgauge::server
