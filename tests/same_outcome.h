// Compares the outcomes of two measurements bit by bit, except for their timings and threads.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "engine/hausdorff.h"

namespace meshgauge {

inline bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

inline bool same_bits(const Vec3& a, const Vec3& b) {
  return same_bits(a.x(), b.x()) && same_bits(a.y(), b.y()) && same_bits(a.z(), b.z());
}

inline bool same_bits(const std::optional<Witness>& a, const std::optional<Witness>& b) {
  if (!a || !b) return !a && !b;
  return same_bits(a->point_a, b->point_a) && same_bits(a->point_b, b->point_b) && a->triangle_a == b->triangle_a &&
         a->triangle_b == b->triangle_b;
}

inline bool same_work(const Work& a, const Work& b) {
  return a.nearest_queries == b.nearest_queries && a.cache_hits == b.cache_hits &&
         a.triangle_tests == b.triangle_tests && a.subdivisions == b.subdivisions && a.max_depth == b.max_depth &&
         a.peak_heap == b.peak_heap;
}

inline bool same_directed(const std::optional<Directed>& a, const std::optional<Directed>& b) {
  if (!a || !b) return !a && !b;
  return same_bits(a->bounds.lower, b->bounds.lower) && same_bits(a->bounds.upper, b->bounds.upper) &&
         same_bits(a->bounds.witness, b->bounds.witness) && a->culling.triangles == b->culling.triangles &&
         a->culling.survivors == b->culling.survivors && same_work(a->work, b->work);
}

inline bool same_outcome(const Outcome& a, const Outcome& b) {
  return a.stop == b.stop && a.met_by == b.met_by && same_bits(a.lower, b.lower) && same_bits(a.upper, b.upper) &&
         same_directed(a.a_to_b, b.a_to_b) && same_directed(a.b_to_a, b.b_to_a) &&
         same_bits(a.precision_floor, b.precision_floor) && same_bits(a.diagonal_a, b.diagonal_a) && a.simd == b.simd;
}

}  // namespace meshgauge
