#include "api/formats/polygons/polygon_deviation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "engine/rounding.h"
#include "engine/tree/triangle.h"

namespace meshgauge::api {
namespace {

// Far more than the rounding errors of any formula here, relative to its result and to the face's extent.
constexpr double kRelative = 1 + 0x1p-40;
constexpr double kAbsolute = 0x1p-46;

double extent_of(std::span<const Vec3> corners) {
  double extent = 0;
  for (const Vec3& p : corners) extent = std::max(extent, (p - corners[0]).cwiseAbs().maxCoeff());
  return extent;
}

double distance(const PreparedTriangle& triangle, const Vec3& p) { return norm(closest_point(triangle, p) - p); }

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length_sq = squared_norm(ab);
  const double along = length_sq > 0 ? std::clamp(dot(p - a, ab) / length_sq, 0.0, 1.0) : 0;
  return norm(a + along * ab - p);
}

// Bounds the largest distance of a point on ac from the triangles abd and bcd (D3). Precondition: coordinates of at
// most 1.
double farthest_on_diagonal(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Preparation at_a = prepare(a, b, d), at_c = prepare(c, b, d);
  double low = 0, high = 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    const Vec3 x = a + middle * (c - a);
    (distance(at_a.triangle, x) < distance(at_c.triangle, x) ? low : high) = middle;
  }
  const double from_a = distance(at_a.triangle, a + high * (c - a)) + at_a.residual;
  const double from_c = distance(at_c.triangle, a + low * (c - a)) + at_c.residual;
  return std::min(from_a, from_c) + rounding::kDistanceSlack;
}

double area(const Vec3& a, const Vec3& b, const Vec3& c) { return norm((b - a).cross(c - a)) / 2; }

// A face seen along its normal.
class View {
 public:
  View(std::span<const Vec3> corners, const Vec3& normal) : corners_(corners), normal_(normalized(normal)) {
    Eigen::Index least = 0;
    normal_.cwiseAbs().minCoeff(&least);
    const Vec3 right = normalized(normal_.cross(Vec3::Unit(least))), up = normal_.cross(right);
    for (const Vec3& p : corners) outline_.push_back({dot(p - corners[0], right), dot(p - corners[0], up)});
    side_ = area_sign(outline_) < 0 ? -1 : 1;
  }

  std::span<const Point2> outline() const { return outline_; }
  double largest_crossing() const;
  // Returns true when three corners lie on one line or nearly so.
  bool has_straight_corners() const;

 private:
  std::size_t size() const { return outline_.size(); }
  int turn(std::size_t a, std::size_t b, std::size_t c) const {
    return side_ * orientation(outline_[a], outline_[b], outline_[c]);
  }
  double twice_area(std::size_t a, std::size_t b, std::size_t c) const {
    const Point2 &p = outline_[a], &q = outline_[b], &r = outline_[c];
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  }
  bool starts_inside(std::size_t from, std::size_t to) const;
  bool is_diagonal(std::size_t from, std::size_t to) const;
  double crossing(std::size_t i, std::size_t j, std::size_t k, std::size_t l, double above) const;

  std::span<const Vec3> corners_;
  Vec3 normal_;
  std::vector<Point2> outline_;
  int side_ = 1;
};

bool View::starts_inside(std::size_t from, std::size_t to) const {
  const std::size_t before = (from + size() - 1) % size(), after = (from + 1) % size();
  if (turn(before, from, after) >= 0) return turn(from, to, before) >= 0 && turn(to, from, after) >= 0;
  return turn(from, to, after) < 0 || turn(to, from, before) < 0;
}

// Returns true also for diagonals that touch the outline.
bool View::is_diagonal(std::size_t from, std::size_t to) const {
  if (!starts_inside(from, to) || !starts_inside(to, from)) return false;
  for (std::size_t a = 0; a < size(); ++a) {
    const std::size_t b = (a + 1) % size();
    if (turn(from, to, a) * turn(from, to, b) < 0 && turn(a, b, from) * turn(a, b, to) < 0) return false;
  }
  return true;
}

// Returns the distance at the crossing of the diagonals ik and jl, i < j < k < l (D2); 0: they do not cross, or are not
// farther apart than `above`.
double View::crossing(std::size_t i, std::size_t j, std::size_t k, std::size_t l, double above) const {
  const double to_j = twice_area(i, k, j), to_l = twice_area(i, k, l);
  const double to_i = twice_area(j, l, i), to_k = twice_area(j, l, k);
  if (!(to_j * to_l < 0 && to_i * to_k < 0)) return 0;
  const Vec3 on_first = corners_[i] + to_i / (to_i - to_k) * (corners_[k] - corners_[i]);
  const Vec3 on_second = corners_[j] + to_j / (to_j - to_l) * (corners_[l] - corners_[j]);
  if (std::abs(dot(on_first - on_second, normal_)) <= above) return 0;
  return std::max(distance_to_segment(on_first, corners_[j], corners_[l]),
                  distance_to_segment(on_second, corners_[i], corners_[k]));
}

double View::largest_crossing() const {
  const std::size_t n = size();
  const bool all = turns_of(outline_).convex;
  std::array<std::array<bool, kMostMeasuredCorners>, kMostMeasuredCorners> diagonal{};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) diagonal[i][j] = all || is_diagonal(i, j);
  }
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i + 2; k < n; ++k) {
      if (!diagonal[i][k]) continue;
      for (std::size_t j = i + 1; j < k; ++j) {
        for (std::size_t l = k + 1; l < n; ++l) {
          if (diagonal[j][l]) largest = std::max(largest, crossing(i, j, k, l, largest));
        }
      }
    }
  }
  return largest;
}

}  // namespace

// The products in each height and their sum have errors of at most a few 2^-53 of the sum of their magnitudes.
double thickness(std::span<const Vec3> corners, const Vec3& normal) {
  double low = 0, high = 0, magnitude = 0;
  for (const Vec3& p : corners) {
    const Vec3 from_first = p - corners[0];
    const double height = dot(from_first, normal);
    low = std::min(low, height);
    high = std::max(high, height);
    magnitude = std::max(magnitude, dot(from_first.cwiseAbs(), normal.cwiseAbs()));
  }
  return ((high - low) + 0x1p-48 * magnitude) / norm(normal) * kRelative;
}

double deviation_along_axis(std::span<const Vec3> corners, const Vec3& normal) {
  return thickness(corners, normal) * norm(normal) / normal.cwiseAbs().maxCoeff() * kRelative;
}

bool diagonals_cross(const std::array<Vec3, 4>& corners) {
  const auto& [a, b, c, d] = corners;
  const Vec3 normal = (c - a).cross(d - b);
  const double normal_sq = squared_norm(normal);
  const double on_ac = dot((b - a).cross(d - b), normal), on_bd = dot((b - a).cross(c - a), normal);
  return on_ac > 0 && on_ac < normal_sq && on_bd > 0 && on_bd < normal_sq;
}

double quad_deviation(const std::array<Vec3, 4>& corners, double of_interest, StepBudget& budget) {
  constexpr std::size_t kBisectionSteps = 2000;
  const auto& [a, b, c, d] = corners;
  const Vec3 normal = (c - a).cross(d - b);
  if (diagonals_cross(corners)) {
    const double apart = thickness(corners, normal);
    if (apart <= of_interest) return apart;
    const double smaller_area = std::min(area(a, b, c) + area(a, c, d), area(a, b, d) + area(b, c, d));
    if (smaller_area < 0.95 * norm(normal)) return apart;
  }
  if (!budget.spend(kBisectionSteps)) return deviation_along_axis(corners, normal);
  const double extent = extent_of(corners);
  const auto unit = [extent, &origin = corners[0]](const Vec3& p) -> Vec3 { return (p - origin) / extent; };
  return extent * kRelative *
         std::max(farthest_on_diagonal(unit(a), unit(b), unit(c), unit(d)),
                  farthest_on_diagonal(unit(b), unit(c), unit(d), unit(a)));
}

bool View::has_straight_corners() const {
  constexpr double kNearly = 0x1p-30;
  const double extent = extent_of(corners_);
  for (std::size_t a = 0; a < size(); ++a) {
    for (std::size_t b = a + 1; b < size(); ++b) {
      for (std::size_t c = b + 1; c < size(); ++c) {
        if (!(std::abs(twice_area(a, b, c)) > kNearly * extent * extent)) return true;
      }
    }
  }
  return false;
}

double polygon_deviation(std::span<const Vec3> corners, const Vec3& normal, StepBudget& budget) {
  const View view(corners, normal);
  if (crosses_itself(view.outline(), budget) || budget.left() == 0) return deviation_along_axis(corners, normal);
  const double thick = thickness(corners, normal);
  const std::size_t n = corners.size();
  // Cost of all pairs of crossing diagonals, and of each diagonal against each edge.
  const std::size_t steps = n * n * n * n / 24 + n * n * n / 2 * kOrientationSteps;
  if (n > kMostMeasuredCorners || !budget.spend(steps)) return thick;
  // With a corner on a diagonal, crossings do not bound all overlaps (D2).
  if (view.has_straight_corners()) return thick;
  return std::min(thick, view.largest_crossing() * kRelative + kAbsolute * extent_of(corners));
}

}  // namespace meshgauge::api
