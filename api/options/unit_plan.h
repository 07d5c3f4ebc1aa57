// Resolves the units of a comparison: of each mesh and of the result. docs/units.md has the rules.
#pragma once

#include <optional>
#include <string_view>

#include "api/base/units.h"
#include "api/formats/format.h"
#include "engine/mesh/scaling.h"
#include "engine/result.h"

namespace meshgauge::api {

// Parses the usual spellings of a unit, ASCII letters in either case: "mm", "millimeter", "Millimetres", "\"", "µm".
// nullopt: not a unit.
std::optional<LengthUnit> parse_unit(std::string_view text);

std::string_view in_words(LengthUnit unit);  // "millimetres", for sentences

// Given as a limit's unit: the unit of mesh b (AskedUnits::limit_of_b).
inline constexpr std::string_view kUnitOfB = "b";

// Given as a limit's unit: the diagonal of mesh b's bounding box (AskedUnits::limit_of_diagonal).
inline constexpr std::string_view kUnitOfDiagonal = "diagonal";

// The units that a request declares.
struct AskedUnits {
  std::optional<LengthUnit> a;      // overrides the file's unit; nullopt: not declared
  std::optional<LengthUnit> b;      // overrides the file's unit; nullopt: not declared
  std::optional<LengthUnit> limit;  // of the limits and of lengths beside them; nullopt: without unit, or none
  bool limit_of_b = false;          // true: the limit is in the unit of mesh b, known or not
  bool limit_of_diagonal = false;   // true: limits are fractions of the diagonal of mesh b's bounding box

  bool operator==(const AskedUnits&) const = default;
};

// Returns the limit's unit as a request names it: a unit, kUnitOfB or kUnitOfDiagonal; empty: none.
std::string_view limit_unit_name(const AskedUnits& asked);

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
