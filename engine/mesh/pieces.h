// Triangles cut by planes, with what rounding has moved of each corner: engine/mesh/clipping.h has the statement and
// proof.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/mesh.h"

namespace meshgauge {

struct CutCorner {
  Vec3 at;
  Vec3 off;  // the largest difference of each coordinate from the corner that this one stands for

  // Upper bound of the length of `off`.
  double distance_off() const;
};

// Corners in order. The corners that they stand for are those of a convex polygon. Fewer than three: a segment, a
// point, nothing.
using Polygon = std::vector<CutCorner>;

// The part of one triangle that satisfies some conditions, between an inner and an outer copy.
struct Pieces {
  Polygon inner;
  Polygon outer;
};

// Heights above a plane, positive on one side: n . (x - origin) - offset.
struct Plane {
  Vec3 normal;  // of length 1 up to rounding
  Vec3 origin;
  double offset = 0;
  int axis = -1;  // at least 0: the normal is exactly this axis or its reverse, and the offset is 0

  double height(const Vec3& x) const;
  // What the computed height of a corner may be off.
  double height_off(const CutCorner& corner) const;
};

// A half-space between two: {inner.height <= 0} within it within {outer.height <= 0}.
struct HalfSpace {
  Plane inner;
  Plane outer;
};

// Cuts both copies by the half-space.
Pieces within(const Pieces& pieces, const HalfSpace& half);
// Cuts both copies by the complement: the closure of what is not in the half-space.
Pieces beyond(const Pieces& pieces, const HalfSpace& half);
// Divides both copies: if they are equal, a triangle in two at its longest edge, another polygon into triangles; else
// by a plane across the widest axis. Rounding is in `off` of the new corners.
std::vector<Pieces> divided(const Pieces& pieces);

// Upper bound of the distance of any point in the hull of `outer` from the fan of triangles of `inner`; infinite when
// only `inner` is empty. A point in the hull of `inner` and one of the fan stand for the same exact point, and both are
// within distance_off(inner) of it: that counts twice, but for a triangle.
double gap(const Pieces& pieces);
// The largest CutCorner::distance_off().
double distance_off(const Polygon& polygon);

}  // namespace meshgauge
