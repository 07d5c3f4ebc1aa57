// Parses lengths, shares and durations as people write them, alike in requests, manifests and flags.
#pragma once

#include <chrono>
#include <optional>
#include <string_view>

#include "api/units.h"
#include "engine/result.h"

namespace meshgauge::api {

// Errors are the end of a sentence; the caller adds the option or flag: "must be ..., not '5,0 mm'". Surrounding blanks
// are ignored.

struct Length {
  double number = 0;               // in `unit`; of a share: 0.01 is one percent
  std::optional<LengthUnit> unit;  // nullopt: none is given
  bool is_share = false;           // of the diagonal of mesh b's bounding box
};

// What may stand for a limit.
inline constexpr std::string_view kLengthOrShare =
    "a number (0.05), a number and a unit (0.05 mm) or a share of the baseline's diagonal (0.5 %)";

// Parses "0.05", "0.05 mm" or "0.05mm", with the spellings of parse_unit(), and with `or_share` "0.5 %". Refuses a
// decimal comma, hexadecimal, negative or infinite numbers and any text after the number.
Result<Length> parse_length(std::string_view text, bool or_share);

// Parses a share, "1 %", as a fraction of 1. A number without '%' is refused: it would be read either way. `of`: of
// what, for the message.
Result<double> parse_share(std::string_view text, std::string_view of = "the area");

// Parses "60 s", "500 ms", "2 min" or "60s"; a bare number is in seconds. Rounds to whole milliseconds, from 1
// to `most`.
Result<std::chrono::milliseconds> parse_duration(std::string_view text, std::chrono::milliseconds most);

}  // namespace meshgauge::api
