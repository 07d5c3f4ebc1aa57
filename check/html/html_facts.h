// Facts about the meshes and the work, from a comparison's JSON, as tables. Members that a service leaves out are
// left out.
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

std::string expectation_table(const GateOutcome& outcome);  // empty if the gate expects nothing
std::string mesh_table(const GateOutcome& outcome);
std::string time_table(const Measured& measured);
std::string work_table(const GateOutcome& outcome);
std::string statistics_table(const Measured& measured);  // empty if no statistics were requested

}  // namespace meshgauge::check
