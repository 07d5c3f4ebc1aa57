// The parts of a request that have a shape of their own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/options/expectations.h"
#include "api/options/reading.h"
#include "engine/extras/align/align.h"
#include "engine/region.h"

namespace meshgauge::api {

// Reads 1 to Region::kMost regions: {"name": "bore", "box": {"min": [x, y, z], "max": [x, y, z]}}, {"name": "tip",
// "sphere": {"centre": [x, y, z], "radius": r}} or {"name": "lid", "group": "Lid"}, whose ranges are not known yet;
// each with an optional max_distance.
std::vector<Region> read_regions(const JsonValue& value, const std::string& at, Reading& reading);

// Reads {"watertight": true, "triangles": {"max": 20000}, "volume": {"within": 0.01}}.
Expectations read_expect(const JsonValue& value, const std::string& at, Reading& reading);

// Reads "none", "rigid" or an object (openapi.yaml, Align). nullopt: "none", or a mistake.
std::optional<AlignOptions> read_align(const JsonValue& value, const std::string& at, Reading& reading);

// The rotation of a given transform may be off orthonormal by this (off_orthonormal()): entries written with six
// decimals err by 5e-7, which makes 2 sqrt(3) 5e-7 + 3 (5e-7)^2 < 1.8e-6.
inline constexpr double kMostOffOrthonormal = 4e-6;

// Reads {"row_major": [16 numbers]}, or column_major. The rotation of what is written may be off orthonormal by
// kMostOffOrthonormal; that of the motion is one.
std::optional<RigidMotion> read_transform(const JsonValue& value, const std::string& at, Reading& reading);

}  // namespace meshgauge::api
