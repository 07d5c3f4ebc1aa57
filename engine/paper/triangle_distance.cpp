#include "engine/paper/triangle_distance.h"

#include <cmath>

#include <Eigen/Geometry>

namespace meshgauge {
namespace {

constexpr std::array<std::array<std::size_t, 2>, 3> kEdges{{{0, 1}, {1, 2}, {2, 0}}};

double clamp_ratio(double numerator, double denominator) {
  return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
}

double point_segment_sq(const Vec3& p, const Vec3& a, const Vec3& ab) {
  return (p - a - clamp_ratio((p - a).dot(ab), ab.squaredNorm()) * ab).squaredNorm();
}

// Squared distance of the segments p..p+d and q..q+e. Either an end of one is nearest to the other segment, or the two
// lines' common perpendicular ends inside both; the latter is tried only when the lines are not parallel.
double segments_sq(const Vec3& p, const Vec3& d, const Vec3& q, const Vec3& e) {
  double best = std::min({point_segment_sq(p, q, e), point_segment_sq(p + d, q, e), point_segment_sq(q, p, d),
                          point_segment_sq(q + e, p, d)});
  const Vec3 n = d.cross(e);
  const double n_sq = n.squaredNorm();
  if (n_sq > 0) {
    const Vec3 pq = q - p;
    const double s = std::clamp(pq.cross(e).dot(n) / n_sq, 0.0, 1.0);
    const double t = std::clamp(pq.cross(d).dot(n) / n_sq, 0.0, 1.0);
    best = std::min(best, (pq + t * e - s * d).squaredNorm());
  }
  return best;
}

// Whether the edge a..b crosses t. If rounding misses a crossing close to t's border, the distance between that border
// and the edge is close to zero, so nothing is lost.
bool pierces(const Vec3& a, const Vec3& b, const PreparedTriangle& t) {
  const Vec3 normal = t.e1.cross(t.e2);
  const double ha = (a - t.a).dot(normal), hb = (b - t.a).dot(normal);
  if ((ha > 0) == (hb > 0) || ha == hb) return false;
  const Vec3 x = a + (ha / (ha - hb)) * (b - a);
  const double u = (x - t.a).dot(t.e1);
  const double v = (x - t.a - u * t.e1).dot(t.e2);
  return v >= 0 && t.cx * v <= t.cy * u && (t.length - t.cx) * v <= t.cy * (t.length - u);
}

}  // namespace

double triangle_distance(const CornersAndFrame& s, const CornersAndFrame& t) {
  double best_sq = std::numeric_limits<double>::infinity();
  for (const Vec3& v : s.corners) best_sq = std::min(best_sq, (v - closest_point(t.prepared, v)).squaredNorm());
  for (const Vec3& v : t.corners) best_sq = std::min(best_sq, (v - closest_point(s.prepared, v)).squaredNorm());
  for (const auto& [i, j] : kEdges) {
    if (pierces(s.corners[i], s.corners[j], t.prepared) || pierces(t.corners[i], t.corners[j], s.prepared)) return 0;
    for (const auto& [k, l] : kEdges) {
      best_sq = std::min(
          best_sq, segments_sq(s.corners[i], s.corners[j] - s.corners[i], t.corners[k], t.corners[l] - t.corners[k]));
    }
  }
  return std::sqrt(best_sq);
}

}  // namespace meshgauge
