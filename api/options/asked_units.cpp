#include "api/options/asked_units.h"

#include <algorithm>
#include <iterator>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

struct Spelling {
  std::string_view text;
  LengthUnit unit;
};
constexpr Spelling kSpellings[] = {{"um", LengthUnit::micron},
                                   {"\xC2\xB5m", LengthUnit::micron},  // U+00B5
                                   {"\xCE\xBCm", LengthUnit::micron},  // U+03BC
                                   {"micron", LengthUnit::micron},
                                   {"microns", LengthUnit::micron},
                                   {"micrometer", LengthUnit::micron},
                                   {"micrometers", LengthUnit::micron},
                                   {"micrometre", LengthUnit::micron},
                                   {"micrometres", LengthUnit::micron},
                                   {"mm", LengthUnit::millimeter},
                                   {"millimeter", LengthUnit::millimeter},
                                   {"millimeters", LengthUnit::millimeter},
                                   {"millimetre", LengthUnit::millimeter},
                                   {"millimetres", LengthUnit::millimeter},
                                   {"cm", LengthUnit::centimeter},
                                   {"centimeter", LengthUnit::centimeter},
                                   {"centimeters", LengthUnit::centimeter},
                                   {"centimetre", LengthUnit::centimeter},
                                   {"centimetres", LengthUnit::centimeter},
                                   {"m", LengthUnit::meter},
                                   {"meter", LengthUnit::meter},
                                   {"meters", LengthUnit::meter},
                                   {"metre", LengthUnit::meter},
                                   {"metres", LengthUnit::meter},
                                   {"in", LengthUnit::inch},
                                   {"inch", LengthUnit::inch},
                                   {"inches", LengthUnit::inch},
                                   {"\"", LengthUnit::inch},
                                   {"ft", LengthUnit::foot},
                                   {"foot", LengthUnit::foot},
                                   {"feet", LengthUnit::foot},
                                   {"'", LengthUnit::foot}};

}  // namespace

std::optional<LengthUnit> parse_unit(std::string_view text) {
  const auto found = std::find_if(std::begin(kSpellings), std::end(kSpellings),
                                  [&](const Spelling& spelling) { return same_word(text, spelling.text); });
  return found == std::end(kSpellings) ? std::nullopt : std::optional(found->unit);
}

std::string_view in_words(LengthUnit unit) {
  constexpr std::string_view kWords[] = {"micrometres", "millimetres", "centimetres", "metres", "inches", "feet"};
  return kWords[static_cast<std::size_t>(unit)];
}

std::string_view limit_unit_name(const AskedUnits& asked) {
  if (asked.limit_of_diagonal) return kUnitOfDiagonal;
  if (asked.limit_of_b) return kUnitOfB;
  return asked.limit ? to_string(*asked.limit) : std::string_view();
}

}  // namespace meshgauge::api
