// Flags with a text that is parsed, for compare and check.
#pragma once

#include <optional>
#include <string>

#include "api/refused.h"
#include "check/manifest/settings.h"
#include "engine/result.h"

namespace meshgauge::cli {

inline constexpr const char* kRegionsHelp =
    "Measure these parts by themselves: '[{name: bore, box: {min: [0, 0, 0], max: [9, 9, 9]}, max_distance: 0.02 "
    "mm}]'; "
    "or sphere: {centre: [0, 0, 0], radius: 5}, or group: NAME, a group of the baseline's file";

// Sets `to` to what `parse` makes of the flag's text, if the flag is given.
template <class Parse, class Value>
Result<Done> read_flag(const char* flag, const std::optional<std::string>& text, const Parse& parse, Value& to) {
  if (!text) return Done{};
  const auto parsed = parse(*text);
  if (!parsed) return bad_flag(flag, parsed.error().message);
  return to = *parsed, Done{};
}

inline constexpr const char* kExpectHelp =
    "What the first mesh itself has to be like: '{watertight: true, triangles: {max: 20000}}'; docs/check.md";

inline constexpr const char* kAlignHelp =
    "Move A first: 'rigid' by best fit, or as '{transform: {row_major: [16 numbers]}}'; docs/alignment.md";

inline Result<Done> set_align(const std::optional<std::string>& text, std::optional<AlignOptions>& to) {
  if (!text) return Done{};
  const auto asked = check::parse_align(*text, "--align");
  if (!asked) return asked.error();
  return to = *asked, Done{};
}

// The flag that is named where limits do not fit each other.
inline const char* flag_beside(const std::optional<std::string>& uncertainty, const std::optional<std::string>& zone) {
  return uncertainty ? "--uncertainty" : zone ? "--zone" : "--max-share-beyond";
}

}  // namespace meshgauge::cli
