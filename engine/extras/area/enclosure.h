// The distance over one piece of A, between two linear functions, and what follows for the piece's area.
//
// An enclosure has two linear functions on a triangle, each by its values at the corners, with
//   low(x) <= d(x,B) <= high(x)   for all x of the exact piece.
// So the part of the piece where d > t has at least the area where low > t and at most that where high > t, and the
// mean of d lies between their means.
//
// Rounding (rounding.h R12): the shares err by less than kShareSlack absolutely; means of `high` by kMeanSlack
// relatively; the other functions round down themselves.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace meshgauge {

// The values of a linear function at the corners of a triangle.
using Linear = std::array<double, 3>;

inline double least(const Linear& f) { return std::min({f[0], f[1], f[2]}); }
inline double most(const Linear& f) { return std::max({f[0], f[1], f[2]}); }

struct Enclosure {
  Linear low{};   // certified, slack included; may be negative
  Linear high{};  // certified, slack included
};

// The share of the triangle where f > t.
inline double share_beyond(const Linear& f, double t) {
  const double low = least(f), high = most(f);
  if (low > t) return 1;
  if (high <= t) return 0;
  const double middle = std::max(std::min(f[0], f[1]), std::min(std::max(f[0], f[1]), f[2]));
  // The part beside one corner is a triangle whose edges are shares of the piece's edges.
  if (middle <= t) return (high - t) / (high - low) * ((high - t) / (high - middle));
  return 1 - (t - low) / (middle - low) * ((t - low) / (high - low));
}

inline double mean(const Linear& f) { return (f[0] + f[1] + f[2]) / 3; }

// The mean of f^2. Precondition: f >= 0.
inline double mean_square(const Linear& f) {
  return (f[0] * f[0] + f[1] * f[1] + f[2] * f[2] + f[0] * f[1] + f[1] * f[2] + f[2] * f[0]) / 6;
}

// Lower bounds of the means of d and d^2, where d >= max(low, 0). The mean: by Jensen's inequality.
inline double mean_below(const Linear& low) {
  constexpr double kRound = 0x1p-50;  // 3 roundings of sums of at most the sum of magnitudes
  return std::max(mean(low) - kRound * (std::abs(low[0]) + std::abs(low[1]) + std::abs(low[2])), 0.0);
}

// Where low changes its sign, let -d be its least value. max(low, 0) differs from low + d by at most d, so its root
// mean square is at least that of low + d, less d.
inline double mean_square_below(const Linear& low) {
  const double bottom = least(low);
  if (bottom >= 0) return mean_square(low);
  constexpr double kRoundDown = 1 - 0x1p-47;
  const double shifted = std::sqrt(mean_square({low[0] - bottom, low[1] - bottom, low[2] - bottom}));
  const double below = std::max(kRoundDown * shifted + bottom, mean_below(low));
  return below * below * kRoundDown;
}

inline double mean_width(const Enclosure& e) { return mean(e.high) - mean_below(e.low); }
inline double square_width(const Enclosure& e) { return mean_square(e.high) - mean_square_below(e.low); }

}  // namespace meshgauge
