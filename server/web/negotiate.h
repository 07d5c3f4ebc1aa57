// What a client would rather have (RFC 9110 section 12.5).
#pragma once

#include <string_view>

namespace meshgauge::server {

// The weight, 0 to 1, that a field such as Accept or Accept-Encoding gives to a value: that of the most exact of its
// elements that fits ("text/html" before "text/*" before "*/*" or "*"); 0: named by none, or refused. Weights that are
// none are 0; other parameters are not looked at.
double weight_of(std::string_view field, std::string_view value);

}  // namespace meshgauge::server
