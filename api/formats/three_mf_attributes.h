// The values of attributes in the XML of a 3MF. Each may have spaces around it and nothing else.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "api/formats/xml.h"

namespace meshgauge::api {

XmlDefect malformed(std::string what);

// Bit-equal to strtod, and finite.
std::optional<XmlDefect> read_coordinate(const char* text, double& value);

// An integer from 0; false for anything else, nullptr included.
bool read_natural(const char* text, std::int64_t& value);

// Twelve finite numbers, row by row of the matrix that is applied to row vectors. Nothing where there is no attribute
// (nullptr).
std::optional<XmlDefect> read_transform(const char* text, std::optional<Eigen::Affine3d>& transform);

// What an object is for: only a "model", which is also meant without an attribute (nullptr), and a "surface" are part
// of what is printed; "support", "solidsupport" and "other" are not.
std::optional<XmlDefect> read_object_type(const char* text, bool& printed);

// Millimetres where there is no attribute (nullptr).
std::optional<XmlDefect> read_unit(const char* text, LengthUnit& unit);

}  // namespace meshgauge::api
