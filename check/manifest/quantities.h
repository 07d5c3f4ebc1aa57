// Limits and durations as people write them, in gates.yaml and as flags.
#pragma once

#include <chrono>
#include <string_view>

#include "check/gate.h"
#include "engine/result.h"

namespace meshgauge::check {

// In the message of an error the subject is missing, for its caller to put in front, the key or the flag: "must be ...,
// not '5,0 mm'". Blanks around the text do not matter.

// "0.05", "0.05 mm", "0.05mm": with one of the spellings of api::parse_unit(). "0.5 %": of the diagonal of the
// baseline's bounding box. Refused: a comma for the point, hexadecimal, a number below 0 or without end, anything else
// behind the number.
Result<Limit> parse_limit(std::string_view text);

// The same without the share.
Result<Limit> parse_length(std::string_view text);

// "mm", "inches".
Result<LengthUnit> parse_unit(std::string_view text);

// "60 s", "500 ms", "2 min", "60s"; a number alone is seconds. Rounded to whole milliseconds, and then within
// api::kTimeoutMsRange.
Result<std::chrono::milliseconds> parse_duration(std::string_view text);

}  // namespace meshgauge::check
