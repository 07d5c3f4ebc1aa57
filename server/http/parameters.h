// Parses the parameters of a header's value (RFC 9110 section 5.6.6): form-data; name="a"; filename="part.stl"
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace meshgauge::server {

// Calls visit(name, value) for each "name=value" of a list separated by semicolons, names in lower case. Returns false
// at the first malformed element.
bool for_each_parameter(std::string_view list,
                        const std::function<void(const std::string& name, const std::string& value)>& visit);

// Removes from `value` what comes before the parameters, and returns it in lower case: the media type of a
// Content-Type, the kind of a Content-Disposition.
std::string take_kind(std::string_view& value);

}  // namespace meshgauge::server
