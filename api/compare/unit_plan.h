// Resolves the units of a comparison: of each mesh and of the result. docs/units.md has the rules.
#pragma once

#include <optional>
#include <string_view>

#include "api/base/units.h"
#include "api/formats/format.h"
#include "api/options/asked_units.h"
#include "engine/mesh/scaling.h"
#include "engine/result.h"

namespace meshgauge::api {

struct KnownUnit {
  std::optional<LengthUnit> unit;  // nullopt: not known
  UnitSource source = UnitSource::unknown;

  bool operator==(const KnownUnit&) const = default;
};

// The unit that a mesh file names.
struct FileUnit {
  Format format = Format::obj;
  std::optional<LengthUnit> unit;
  std::string_view name = {};  // the mesh's name in messages; empty: "a" or "b"
};

struct UnitPlan {
  KnownUnit a;
  KnownUnit b;
  KnownUnit result;  // unit of every measured length
};

// Resolves the units of a pair. `option`: the name of the option whose length is in the unit that `asked` has for
// limits (first_length() of api/options/gate.h); empty: there is no such length. Error: when the units contradict that
// length's or each other; the message names the option and both meshes with their units, and says what to declare.
// Pure.
Result<UnitPlan> resolve(const FileUnit& a, const FileUnit& b, const AskedUnits& asked, std::string_view option);

// Returns the factor from a mesh's unit to the result's; 1 when either is unknown.
Factor factor_between(const KnownUnit& mesh, const KnownUnit& result);

}  // namespace meshgauge::api
