// A linear lower bound of the distance over a triangle, or over each of several triangles.
//
// Statement. Let P be the hull of the points p_i, and let F be a set of linear functions such that each triangle T of B
// has an f in F with f(x) <= d(x,T) for all x in P. Then on a triangle with corners among the p_i the linear function
// with the values min over F of f(p_i) at the corners is at most d(.,B).
// Proof. d(x,B) = min over T of d(x,T) >= min over F of f(x). That minimum is concave, so at x = sum w_i p_i it is at
// least sum w_i (its value at p_i).
//
// F. For any unit vector n: f(x) = x.n - max over corners v of T of v.n (the plane through the highest corner
// separates: rounding.h R5). It holds for any set of triangles when the maximum is over a box around them. And the
// constant d(c,box) - r, with c any point and r its largest distance from a corner of P, since d(.,box) is 1-Lipschitz
// and |x-c| <= r. The directions n are guesses; a poor one makes the bound lower, never wrong.
//
// Rounding: R12. The result is computed, without slack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/search/piece.h"
#include "engine/tree/bvh.h"

namespace meshgauge {

// A point and the value there.
struct MinorantPoint {
  Vec3 point;
  double value;        // in: the most that is wanted; out: that of the lower bound
  std::uint32_t slot;  // a triangle of `to`, probably the nearest
};
inline constexpr std::size_t kMostMinorantPoints = 12;

enum class MinorantFound : std::uint8_t { yes, too_low, interrupted };

// Lowers the values to those of a lower bound. too_low: their sum would be at most `least_sum`; interrupted: `stop`,
// which is polled about every 0.1 ms, returned true; then the values are unchanged. Thread safe. Precondition: 3 to
// kMostMinorantPoints points.
MinorantFound lower_to_minorant(const Bvh& to, std::span<MinorantPoint> points, double least_sum, Work& work,
                                const Interrupted* stop);

}  // namespace meshgauge
