// Flags --unit, --unit-a and --unit-b: units of the numbers in two mesh files.
#pragma once

#include <optional>
#include <string>

#include "api/unit_plan.h"
#include "engine/result.h"

namespace CLI {
class App;
}

namespace meshgauge::cli {

struct UnitFlags {
  std::optional<std::string> both, a, b;
};

// `a` and `b`: names of the two files in the help.
void declare(CLI::App& command, UnitFlags& flags, const std::string& a, const std::string& b);

// Sets the declared units; --unit-a and --unit-b take precedence over --unit. The Error names its flag.
Result<Done> set_units(const UnitFlags& flags, api::AskedUnits& units);

}  // namespace meshgauge::cli
