// What somebody may have meant by a word that is not known.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace meshgauge::check {

// The one of `known` that is near, or nothing. Near: a few letters more, less, exchanged or swapped, '-' for '_',
// capitals, or one begins with the other ("timeout_ms").
std::string_view nearest(std::string_view word, std::span<const std::string_view> known);

// The end of a message: "; did you mean 'max_distance'?" when one is near, otherwise "; known: name, ...".
std::string suggestion(std::string_view word, std::span<const std::string_view> known);

}  // namespace meshgauge::check
