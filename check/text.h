// Numbers and points as text for people.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "api/decimal.h"
#include "engine/mesh.h"

namespace meshgauge::check {

using api::shortest;

// Rounds to `digits` significant digits, for tables.
std::string rounded(double x, int digits = 6);

std::string_view trimmed(std::string_view text);  // without surrounding blanks and line ends

// Percent-encodes every byte except letters, digits and those in `kept` (RFC 3986).
std::string percent_encoded(std::string_view bytes, std::string_view kept);

std::string text(const Vec3& p);  // "(1, 2.5, 3)", each number by shortest()

// Returns "4 open edges, the first at (0.5, 0, 1) mm" for the kind "open". `unit` may be empty.
std::string edges_in_words(std::uint64_t count, std::string_view kind, const Vec3& first, std::string_view unit);

}  // namespace meshgauge::check
