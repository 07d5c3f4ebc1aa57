// Regions: which part of a surface is measured by itself (docs/design.md, section 12).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/mesh.h"

namespace meshgauge {

// A closed ball.
struct Sphere {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

// Triangles first to end - 1 of a mesh.
struct TriangleRange {
  std::uint32_t first = 0;
  std::uint32_t end = 0;

  bool operator==(const TriangleRange&) const = default;
};

// A named part of a mesh, by its triangles. As a region: of mesh b.
struct Group {
  std::string name;
  std::vector<TriangleRange> ranges;  // not empty, ascending and disjoint

  bool has(std::size_t triangle) const {
    const auto after = std::ranges::upper_bound(ranges, triangle, {}, &TriangleRange::first);
    return after != ranges.begin() && triangle < std::prev(after)->end;
  }
  bool operator==(const Group&) const = default;
};

// A closed region. Coordinates and lengths are in the meshes' unit, of at most kMaxCoordinate in magnitude.
// Preconditions: low <= high on each axis of a box; radius >= 0.
struct Region {
  static constexpr std::size_t kMost = 64;  // of one measurement

  std::variant<Box, Sphere, Group> shape;
  std::optional<double> max_distance;  // nullopt: Options::max_distance
  std::string name = {};               // for the caller

  bool is_group() const { return std::holds_alternative<Group>(shape); }
};

}  // namespace meshgauge
