// Convex polygons in a plane, for the overlay bound: few corners, no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <initializer_list>

#include "engine/vector.h"

namespace meshgauge {

using Vec2 = Eigen::Vector2d;

// The points x with inward . (x - origin) >= 0. `inward` is not a unit vector, which saves a division: a comparison
// multiplies the other side by `scale` instead, which is between the length of `inward` and sqrt(2) times it.
struct HalfPlane {
  Vec2 origin;
  Vec2 inward;
  double scale;

  // Signed distance times the length of `inward`.
  double weighted_distance(const Vec2& x) const { return dot(inward, x - origin); }
  // Whether x is at least `offset` inside, or outside. Both err towards no for offsets above the rounding of 32u.
  bool surely_inside(const Vec2& x, double offset) const { return weighted_distance(x) > offset * scale; }
  bool surely_outside(const Vec2& x, double offset) const { return weighted_distance(x) < -offset * scale; }
  HalfPlane flipped() const { return {origin, -inward, scale}; }
};

// The half-plane to the left of a -> b. For a = b every point counts as on the line.
inline HalfPlane left_of(const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  return {a, Vec2(-d.y(), d.x()), std::abs(d.x()) + std::abs(d.y())};
}

// A convex polygon. A copy leaves out the unused corners, because polygons are copied often.
struct Polygon {
  // A cut adds one corner to a convex polygon. Rounded corners may be out of convex position by a little, and then a
  // cut can multiply their number by up to 1.5: from 3, six cuts give at most 28.
  static constexpr std::size_t kMaxCorners = 28;
  std::array<Vec2, kMaxCorners> corners;
  std::size_t size = 0;

  Polygon() {}  // NOLINT(modernize-use-equals-default): the default would fill the corners with zeros first
  Polygon(std::initializer_list<Vec2> points) {
    for (const Vec2& p : points) add(p);
  }
  Polygon(const Polygon& other) : size(other.size) { copy_corners(other); }
  Polygon& operator=(const Polygon& other) {
    size = other.size;
    copy_corners(other);
    return *this;
  }
  ~Polygon() = default;

  void add(const Vec2& p) {
    assert(size < kMaxCorners);
    corners[size++] = p;
  }
  Vec2 centre() const {
    Vec2 sum = Vec2::Zero();
    for (std::size_t i = 0; i < size; ++i) sum += corners[i];
    return sum / static_cast<double>(size);
  }

 private:
  void copy_corners(const Polygon& other) {
    for (std::size_t i = 0; i < other.size; ++i) corners[i] = other.corners[i];
  }
};

// Clips the polygon to the half-plane moved outwards by 1 to sqrt(2) times `offset` (inwards if negative).
inline void clip(Polygon& polygon, const HalfPlane& half, double offset) {
  std::array<double, Polygon::kMaxCorners> inside;  // distance, weighted
  bool any = false, all = true;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    inside[i] = half.weighted_distance(polygon.corners[i]) + offset * half.scale;
    any = any || inside[i] >= 0;
    all = all && inside[i] >= 0;
  }
  if (all) return;
  Polygon out;
  for (std::size_t i = 0; any && i < polygon.size; ++i) {
    const std::size_t next = i + 1 == polygon.size ? 0 : i + 1;
    const Vec2 &a = polygon.corners[i], &b = polygon.corners[next];
    const double da = inside[i], db = inside[next];
    if (da >= 0) out.add(a);
    if ((da < 0) != (db < 0)) out.add(a + (da / (da - db)) * (b - a));
  }
  polygon = out;
}

// The part of a segment a..b that is left after clipping, as an interval of the parameter: 0 at a, 1 at b.
struct Interval {
  double from = 0;
  double to = 1;
  bool empty = false;

  // Clips the segment to the half-plane moved outwards by 1 to sqrt(2) times `offset`.
  void clip(const HalfPlane& half, const Vec2& a, const Vec2& b, double offset) {
    const double da = half.weighted_distance(a) + offset * half.scale;
    const double db = half.weighted_distance(b) + offset * half.scale;
    if (da < 0 && db < 0) empty = true;
    if (da < 0 && db >= 0) from = std::max(from, da / (da - db));
    if (da >= 0 && db < 0) to = std::min(to, da / (da - db));
  }
};

}  // namespace meshgauge
