#include "api/formats/three_mf/three_mf_attributes.h"

#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

bool is_whole(const char* next, const char* end) { return next != nullptr && skip_spaces(next, end) == end; }

}  // namespace

XmlDefect malformed_xml(std::string what) { return {ErrorCode::unreadable_mesh, std::move(what)}; }

std::optional<XmlDefect> read_coordinate(const char* text, double& value) {
  const char* const end = text + std::strlen(text);
  if (!is_whole(parse_number(skip_spaces(text, end), end, value), end)) {
    return malformed_xml("the coordinate " + in_quotes(text) + " is not a number");
  }
  if (std::isfinite(value)) return std::nullopt;
  return XmlDefect{ErrorCode::non_finite_vertex, "the coordinate " + in_quotes(text) + " is not finite"};
}

bool read_natural(const char* text, std::int64_t& value) {
  if (text == nullptr) return false;
  const char* const end = text + std::strlen(text);
  return is_whole(parse_integer(skip_spaces(text, end), end, value), end) && value >= 0;
}

std::optional<XmlDefect> read_transform(const char* text, std::optional<AffineMap>& transform) {
  if (text == nullptr) return std::nullopt;
  const char* const end = text + std::strlen(text);
  const char* p = text;
  std::array<double, 12> columns;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    p = skip_spaces(p, end);
    double& number = columns[k];
    const char* const next = parse_number(p, end, number);
    if (next == nullptr || !std::isfinite(number) || (next != end && !is_space(*next))) {
      return malformed_xml("the transform " + in_quotes(text) + " must have twelve finite numbers");
    }
    p = next;
  }
  if (!is_whole(p, end)) return malformed_xml("the transform " + in_quotes(text) + " has more than twelve numbers");
  transform = AffineMap{Eigen::Matrix3d(columns.data()), Vec3(columns.data() + 9)};
  return std::nullopt;
}

std::optional<XmlDefect> read_object_type(const char* text, bool& printed) {
  const std::string_view type = text == nullptr ? "model" : text;
  printed = type == "model" || type == "surface";
  if (printed || type == "support" || type == "solidsupport" || type == "other") return std::nullopt;
  return malformed_xml("the type " + in_quotes(type) + " of an object is not known");
}

std::optional<XmlDefect> read_unit(const char* text, LengthUnit& unit) {
  unit = LengthUnit::millimeter;
  if (text == nullptr) return std::nullopt;
  constexpr std::string_view kWords[] = {"micron", "millimeter", "centimeter", "meter", "inch", "foot"};
  for (const LengthUnit known : kLengthUnits) {
    if (kWords[static_cast<std::size_t>(known)] != text) continue;
    unit = known;
    return std::nullopt;
  }
  return malformed_xml("the unit " + in_quotes(text) + " is not known");
}

}  // namespace meshgauge::api
