// Parses limits and durations of gates.yaml and of flags.
#pragma once

#include <string_view>

#include "api/quantity.h"
#include "check/gate.h"
#include "engine/result.h"

namespace meshgauge::check {

using api::parse_duration;
using api::parse_share;

// Errors are the end of a sentence; the caller adds the key or flag: "must be ..., not '5,0 mm'". Surrounding blanks
// are ignored.

// Parses "0.05", "0.05 mm" or "0.05mm", with the spellings of api::parse_unit(), or "0.5 %" of the diagonal of the
// baseline's bounding box. Refuses a decimal comma, hexadecimal, negative or infinite numbers and any text after the
// number.
Result<Limit> parse_limit(std::string_view text);

// Parses a limit that is not a share.
Result<Limit> parse_length(std::string_view text);

// Parses max_share_beyond as a flag: a distance as parse_limit(), ':' and a share, "0.05 mm: 1 %".
Result<AreaLimit> parse_area_limit(std::string_view text);

// Parses one end of a zone: the limit inside, which is 0 or has a minus ("-0.05 mm"), or that outside, which may have a
// plus.
Result<Limit> parse_zone_end(std::string_view text, bool is_inside);

// Returns the zone of both ends. A 0 without a unit gets that of the other end.
ZoneLimit zone_of(Limit inside, Limit outside);

// Parses both, "-0.05 mm, 0.1 mm".
Result<ZoneLimit> parse_zone(std::string_view text);

// Refuses distances of a gate that do not have the same unit (one beside the main limit may be a bare 0), an
// uncertainty above a limit, and a zone without the direction from the candidate.
Result<Done> check_limits(const Gate& gate);

// Parses "mm" or "inches".
Result<LengthUnit> parse_unit(std::string_view text);

}  // namespace meshgauge::check
