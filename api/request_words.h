// The words of a request: lengths with a unit, shares in percent, directions of a gate. Replaced by what they mean, so
// that what a manifest takes is taken in JSON too.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/result.h"

namespace meshgauge::api {

// Replaces in an `options` document: "0.05 mm" as a limit, the uncertainty, or the limit of a region by its number, and
// adds the unit as gate.units; "1 %" as a share of the area by 0.01; "candidate_to_baseline" by "a_to_b". What is no
// text stays; parse_options() judges it. Errors: invalid_request, with a JSON pointer in Error::where, for a text that
// is no such quantity, for two units in one gate, and for a bare number beside a unit.
Result<Done> resolve_words(nlohmann::json& options);

}  // namespace meshgauge::api
