// One gate as a card of the report: what was found, its pictures, and tables of facts about the meshes and the work.
#pragma once

#include <cstddef>
#include <string>

#include "check/html/picture.h"
#include "check/outcome.h"

namespace meshgauge::check {

std::string gate_id(std::size_t index);  // its anchor: "gate-3" for index 2

// Returns the result as one sentence that the interval supports. Not escaped.
std::string sentence(const GateOutcome& outcome);

// `picture` may be null.
std::string gate_card(const GateOutcome& outcome, const GatePicture* picture, std::size_t index, Undecided rule);

}  // namespace meshgauge::check
