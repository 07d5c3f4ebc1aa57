// What a comparison's JSON says of the meshes and of the work, as tables. Whatever a service leaves out is left out.
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

std::string mesh_table(const GateOutcome& outcome);
std::string time_table(const Measured& measured);
std::string work_table(const GateOutcome& outcome);
std::string statistics_table(const Measured& measured);  // empty where none were asked for

}  // namespace meshgauge::check
