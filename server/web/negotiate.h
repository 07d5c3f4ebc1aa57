// Content negotiation (RFC 9110 section 12.5).
#pragma once

#include <string_view>

namespace meshgauge::server {

// Returns the weight, 0 to 1, that a field such as Accept or Accept-Encoding gives to a value: that of its most
// specific element that matches ("text/html" before "text/*" before "*/*" or "*"). 0: no element matches, the value is
// refused, or its weight is malformed. Other parameters are ignored.
double weight_of(std::string_view field, std::string_view value);

}  // namespace meshgauge::server
