#include "api/options/asked_units.h"

#include <utility>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using api::LengthUnit;
using api::parse_unit;

TEST_CASE("units: the usual spellings, and nothing else") {
  const std::pair<LengthUnit, std::vector<const char*>> all[] = {
      {LengthUnit::micron, {"um", "UM", "\xC2\xB5m", "\xCE\xBCm", "micron", "Microns", "micrometer", "micrometres"}},
      {LengthUnit::millimeter, {"mm", "MM", "Mm", "millimeter", "millimeters", "millimetre", "millimetres"}},
      {LengthUnit::centimeter, {"cm", "centimeter", "centimeters", "centimetre", "CENTIMETRES"}},
      {LengthUnit::meter, {"m", "M", "meter", "meters", "metre", "metres"}},
      {LengthUnit::inch, {"in", "inch", "inches", "\"", "IN"}},
      {LengthUnit::foot, {"ft", "foot", "feet", "'"}}};
  for (const auto& [unit, spellings] : all) {
    for (const char* spelling : spellings) {
      CAPTURE(spelling);
      CHECK(parse_unit(spelling) == unit);
    }
    CHECK(parse_unit(to_string(unit)) == unit);
    CHECK(parse_unit(in_words(unit)) == unit);
  }
  CHECK(api::unit_names() == "um, mm, cm, m, in, ft");
  for (const char* none : {"", " ", "mm ", " mm", "km", "nm", "parsec", "mms", "inchs", "%", "px", "1", "b", "''"}) {
    CAPTURE(none);
    CHECK_FALSE(parse_unit(none));
  }
}
