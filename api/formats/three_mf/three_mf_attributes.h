// Reads values of attributes in the XML of a 3MF. Spaces around a value are allowed, nothing else.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "api/formats/file/affine_map.h"
#include "api/formats/three_mf/xml.h"

namespace meshgauge::api {

XmlDefect malformed_xml(std::string what);

// Reads a coordinate, bit-equal to strtod; a defect when it is not finite.
std::optional<XmlDefect> read_coordinate(const char* text, double& value);

// Reads an integer >= 0. false: `text` is something else, or nullptr.
bool read_natural(const char* text, std::int64_t& value);

// Reads twelve finite numbers, row by row of a matrix for row vectors. Sets nullopt without the attribute (nullptr).
std::optional<XmlDefect> read_transform(const char* text, std::optional<AffineMap>& transform);

// Reads the type of an object. Printed are "model", which is also the default (nullptr), and "surface"; not printed are
// "support", "solidsupport" and "other".
std::optional<XmlDefect> read_object_type(const char* text, bool& printed);

// Reads the unit; millimetres without the attribute (nullptr).
std::optional<XmlDefect> read_unit(const char* text, LengthUnit& unit);

}  // namespace meshgauge::api
