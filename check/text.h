// Numbers and places as people read them.
#pragma once

#include <string>
#include <string_view>

#include "api/decimal.h"
#include "engine/mesh.h"

namespace meshgauge::check {

using api::shortest;

// Rounded to `digits` significant ones: for tables, where every digit would be too many.
std::string rounded(double x, int digits = 6);

std::string_view trimmed(std::string_view text);  // without the blanks and line ends around it

// For URIs (RFC 3986): letters, digits and what is `kept` stay, every other byte is percent-encoded.
std::string percent_encoded(std::string_view bytes, std::string_view kept);

std::string text(const Vec3& p);  // "(1, 2.5, 3)", each number by shortest()

}  // namespace meshgauge::check
