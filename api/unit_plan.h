// Which unit each mesh of a comparison is in, and which one its lengths are measured in. The rules are those of
// docs/units.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/formats/format.h"
#include "api/units.h"
#include "engine/result.h"
#include "engine/scaling.h"

namespace meshgauge::api {

// "mm", "millimeter", "Millimetres", "\"", "µm": the usual spellings, ASCII letters in either case. nullopt: none.
std::optional<LengthUnit> parse_unit(std::string_view text);

std::string_view in_words(LengthUnit unit);  // "millimetres", for sentences

inline constexpr std::string_view kUnitNames = "um, mm, cm, m, in, ft";

// In the place of a limit's unit: the unit of mesh b, whichever that is (AskedUnits::limit_of_b).
inline constexpr std::string_view kUnitOfB = "b";

// What a request says of units.
struct AskedUnits {
  std::optional<LengthUnit> a;      // declared; the file's own unit is not asked then
  std::optional<LengthUnit> b;      // likewise
  std::optional<LengthUnit> limit;  // none: a number without unit, or no limit
  bool limit_of_b = false;          // the limit is a number in the unit of mesh b, known or not

  bool operator==(const AskedUnits&) const = default;
};

// The limit's unit as a request names it; empty: none.
std::string_view limit_unit_name(const AskedUnits& asked);

struct KnownUnit {
  std::optional<LengthUnit> unit;  // none: not known
  UnitSource source = UnitSource::unknown;

  bool operator==(const KnownUnit&) const = default;
};

// What the file of a mesh says.
struct FileUnit {
  Format format = Format::obj;
  std::optional<LengthUnit> unit;
  std::string_view name = {};  // for messages; empty: "a" or "b"
};

struct UnitPlan {
  KnownUnit a;
  KnownUnit b;
  KnownUnit result;  // of every length that is measured
};

// The plan, or an Error that names both meshes with their units and says what to declare. Pure.
Result<UnitPlan> resolve(const FileUnit& a, const FileUnit& b, const AskedUnits& asked, bool has_limit);

// What a mesh's coordinates are multiplied by. One, where either is not known.
Factor factor_between(const KnownUnit& mesh, const KnownUnit& result);

}  // namespace meshgauge::api
