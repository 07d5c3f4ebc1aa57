// The extent of a surface A on each side of a closed surface B: how far A reaches beyond B's outside, and into it.
//
// A point is inside where B winds around it at least once, and outside where it does not. So parts of B that overlap
// are one solid, a cavity is a part that faces the other way, and the distance is that to all of B, walls within the
// solid included. Where B winds around a point in the wrong direction, it has a part that is inside out, and nothing is
// said. docs/design.md, section 13, has the proof.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/area.h"
#include "engine/mesh.h"

namespace meshgauge {

// What is asked of the direction a_to_b. Lengths in the meshes' unit.
struct SideOptions {
  static constexpr double kLeastLength = 0.01;
  static constexpr double kGateTolerance = 1e-4;  // of the direction's upper bound: an interval that may hold a limit

  // A gate: limits >= 0 of the distance of A's points inside of B, and of those outside. Options::ends() are those
  // of both. The search ends when it is decided; Options::narrow narrows the intervals further.
  struct Limits {
    double inside = 0;
    double outside = 0;

    bool operator==(const Limits&) const = default;
  };
  std::optional<Limits> limits;
  // The width of an interval, relative to its lower end, or to kLeastLength of the direction's upper bound where that
  // is more.
  double length_tolerance = 0.01;
};

// lower <= sup of d(x,B) over the points x of A on that side <= upper, certified; 0 without such a point.
struct SideBounds {
  double lower = 0;
  double upper = 0;
  // A point of A on that side whose distance is at least `lower`, up to rounding, and the triangle of A that holds it.
  // nullopt: none is known.
  std::optional<Vec3> at;
  std::uint32_t triangle = 0;
};

// Why B has no sides. `at`: where, if it is a place.
struct NoSides {
  enum class Why {
    open,             // an edge with one triangle
    non_manifold,     // an edge with more than two triangles
    flipped,          // an edge that two triangles pass in the same direction: they face different ways
    inside_out,       // the volume is negative: all triangles face inwards
    no_volume,        // the volume is 0, or cannot be told from 0
    part_inside_out,  // B winds around a point of A in the wrong direction
  };
  Why why = Why::open;
  std::optional<Vec3> at;
};

struct SideOutcome {
  SideOptions options;
  std::optional<NoSides> refused;  // nullopt: both intervals hold
  SideBounds outside;
  SideBounds inside;
  std::uint64_t pieces = 0;  // triangles and parts of triangles that were bounded
  AreaStop stop = AreaStop::complete;
};

}  // namespace meshgauge
