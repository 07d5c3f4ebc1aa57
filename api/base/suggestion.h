// Suggests a known word for an unknown one.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace meshgauge::api {

// Returns the word of `known` that is near, or an empty view. Near: a few letters added, missing, replaced or
// swapped, '-' for '_', other case, or a common beginning ("timeout_ms").
std::string_view nearest(std::string_view word, std::span<const std::string_view> known);

// Returns the end of a message: "; did you mean 'max_distance'?" if a word is near, otherwise "; known: name, ...".
std::string suggestion(std::string_view word, std::span<const std::string_view> known);

}  // namespace meshgauge::api
