#include "cli/unit_flags.h"

#include <CLI/CLI.hpp>

#include "api/refused.h"
#include "check/manifest/quantities.h"

namespace meshgauge::cli {
namespace {

Result<Done> set(const std::optional<std::string>& text, const char* flag, std::optional<api::LengthUnit>& unit) {
  if (!text) return Done{};
  const auto parsed = check::parse_unit(*text);
  if (!parsed) return bad_flag(flag, parsed.error().message);
  return unit = *parsed, Done{};
}

}  // namespace

void declare(CLI::App& command, UnitFlags& flags, const std::string& a, const std::string& b) {
  const std::string names(api::kUnitNames);
  command.add_option("--unit", flags.both, "The unit of both files, whatever they say themselves: " + names);
  command.add_option("--unit-a", flags.a, "The unit of " + a);
  command.add_option("--unit-b", flags.b, "The unit of " + b);
}

Result<Done> set_units(const UnitFlags& flags, api::AskedUnits& units) {
  if (auto ok = set(flags.both, "--unit", units.a); !ok) return ok;
  units.b = units.a;
  if (auto ok = set(flags.a, "--unit-a", units.a); !ok) return ok;
  return set(flags.b, "--unit-b", units.b);
}

}  // namespace meshgauge::cli
