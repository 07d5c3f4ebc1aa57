// A linear lower bound of the distance over a triangle.
//
// Statement. Let P be a triangle with the corners p_i, and let F be a set of linear functions such that each triangle T
// of B has an f in F with f(x) <= d(x,T) for all x in P. Then the linear function with the values min over F of f(p_i)
// at the corners is at most d(.,B) on P.
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

#include <array>
#include <optional>

#include "engine/extras/area/enclosure.h"
#include "engine/search/piece.h"
#include "engine/tree/bvh.h"

namespace meshgauge {

// Returns values of at most `corners[i].distance`, or kNoMinorant when their sum would be at most `least_sum`. nullopt:
// `stop`, which is polled about every 0.1 ms, returned true. Thread safe. Precondition: the corners have slots of `to`.
inline constexpr Linear kNoMinorant{-1e300, -1e300, -1e300};
std::optional<Linear> linear_minorant(const Bvh& to, const std::array<Corner, 3>& corners, double least_sum, Work& work,
                                      const Interrupted* stop);

}  // namespace meshgauge
