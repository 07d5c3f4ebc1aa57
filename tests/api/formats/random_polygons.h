// Random outlines on a grid of integers, simple by an exact test, and their exact placement in space.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/mesh.h"
#include "tests/fuzz/dice.h"

namespace meshgauge::api::test {

struct GridPoint {
  std::int64_t x = 0;
  std::int64_t y = 0;

  bool operator==(const GridPoint&) const = default;
};

using Outline = std::vector<GridPoint>;

// Twice the area of a, b, c: > 0 counter-clockwise. Exact for coordinates below 2^30.
std::int64_t twice_area(const GridPoint& a, const GridPoint& b, const GridPoint& c);
std::int64_t twice_area(const Outline& outline);

// Returns true when p lies on the segment ab, ends included.
bool on_segment(const GridPoint& p, const GridPoint& a, const GridPoint& b);
// Returns true when the segments cross at an inner point of both.
bool cross_inside(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d);

// Coordinates are multiples of 12, at most 12,000: room for points between them.
enum class OutlineKind { convex, star, tangled, comb, spiral, hole, pinched };
inline constexpr OutlineKind kOutlineKinds[] = {OutlineKind::convex, OutlineKind::star,   OutlineKind::tangled,
                                                OutlineKind::comb,   OutlineKind::spiral, OutlineKind::hole,
                                                OutlineKind::pinched};
Outline random_outline(OutlineKind kind, fuzz::Dice& dice);

// Changes an outline without changing its surface, except spikes that stick out.
void add_collinear_corners(Outline& outline, fuzz::Dice& dice);
void add_repeated_corners(Outline& outline, fuzz::Dice& dice);
void add_spikes(Outline& outline, fuzz::Dice& dice);
void turn_around(Outline& outline, fuzz::Dice& dice);  // rotates the corners, and reverses them at random

// x, y -> origin + x * right + y * up, exact for every outline above.
struct Placing {
  Vec3 origin = Vec3::Zero();
  Vec3 right = Vec3::UnitX();
  Vec3 up = Vec3::UnitY();

  Vec3 operator()(const GridPoint& p) const {
    return origin + static_cast<double>(p.x) * right + static_cast<double>(p.y) * up;
  }
};
Placing random_placing(fuzz::Dice& dice);

}  // namespace meshgauge::api::test
