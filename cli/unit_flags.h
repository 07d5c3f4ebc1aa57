// --unit, --unit-a and --unit-b: what the numbers of two mesh files are in.
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

// `a` and `b`: what the command calls its files.
void declare(CLI::App& command, UnitFlags& flags, const std::string& a, const std::string& b);

// Sets the declared units; --unit-a and --unit-b take precedence over --unit. The Error names its flag.
Result<Done> set_units(const UnitFlags& flags, api::AskedUnits& units);

}  // namespace meshgauge::cli
