#include "engine/paper/triangle_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::array<std::array<std::size_t, 2>, 3> kEdges{{{0, 1}, {1, 2}, {2, 0}}};
constexpr double kSetMargin = 256 * rounding::kUnit;
constexpr std::size_t kPulseEvery = 1024;  // triangle-triangle distances between two checks of the clock, about 1 ms

double clamp_ratio(double numerator, double denominator) {
  return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
}

double point_segment_sq(const Vec3& p, const Vec3& a, const Vec3& ab) {
  return squared_norm(p - a - clamp_ratio(dot(p - a, ab), squared_norm(ab)) * ab);
}

// Squared distance of the segments p..p+d and q..q+e. Either an end of one is nearest to the other segment, or the two
// lines' common perpendicular ends inside both; the latter is tried only when the lines are not parallel.
double segments_sq(const Vec3& p, const Vec3& d, const Vec3& q, const Vec3& e) {
  double best = std::min({point_segment_sq(p, q, e), point_segment_sq(p + d, q, e), point_segment_sq(q, p, d),
                          point_segment_sq(q + e, p, d)});
  const Vec3 n = d.cross(e);
  const double n_sq = squared_norm(n);
  if (n_sq > 0) {
    const Vec3 pq = q - p;
    const double s = std::clamp(dot(pq.cross(e), n) / n_sq, 0.0, 1.0);
    const double t = std::clamp(dot(pq.cross(d), n) / n_sq, 0.0, 1.0);
    best = std::min(best, squared_norm(pq + t * e - s * d));
  }
  return best;
}

// Whether the edge a..b crosses t. If rounding misses a crossing close to t's border, the distance between that border
// and the edge is close to zero, so nothing is lost.
bool pierces(const Vec3& a, const Vec3& b, const PreparedTriangle& t) {
  const Vec3 normal = t.e1.cross(t.e2);
  const double ha = dot(a - t.a, normal), hb = dot(b - t.a, normal);
  if ((ha > 0) == (hb > 0) || ha == hb) return false;
  const Vec3 x = a + (ha / (ha - hb)) * (b - a);
  const double u = dot(x - t.a, t.e1);
  const double v = dot(x - t.a - u * t.e1, t.e2);
  return v >= 0 && t.cx * v <= t.cy * u && (t.length - t.cx) * v <= t.cy * (t.length - u);
}

double box_distance_sq(const Box& a, const Box& b) {
  return squared_norm((a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(Vec3::Zero()));
}

CornersAndFrame with_frame(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{a, b, c}, prepare(a, b, c).triangle};
}

}  // namespace

double triangle_distance(const CornersAndFrame& s, const CornersAndFrame& t) {
  double best_sq = std::numeric_limits<double>::infinity();
  for (const Vec3& v : s.corners) best_sq = std::min(best_sq, squared_norm(v - closest_point(t.prepared, v)));
  for (const Vec3& v : t.corners) best_sq = std::min(best_sq, squared_norm(v - closest_point(s.prepared, v)));
  for (const auto& [i, j] : kEdges) {
    if (pierces(s.corners[i], s.corners[j], t.prepared) || pierces(t.corners[i], t.corners[j], s.prepared)) return 0;
    for (const auto& [k, l] : kEdges) {
      best_sq = std::min(
          best_sq, segments_sq(s.corners[i], s.corners[j] - s.corners[i], t.corners[k], t.corners[l] - t.corners[k]));
    }
  }
  return std::sqrt(best_sq);
}

Corner TriangleSet::measure(const Vec3& p, const Piece& parent) {
  const Slots* slots = set_of(parent);
  if (!slots) return nearest_corner(search_.to(), p, search_.work(), search_.stop());
  std::uint64_t& tests = search_.work().triangle_tests;
  Polling polling(search_.stop(), tests);
  Corner corner{p, std::numeric_limits<double>::infinity(), Nearest::kNone};
  for (const std::uint32_t slot : *slots) {
    const double d = distance(search_.to().prepared(slot), p);
    if (d < corner.distance) corner.distance = d, corner.slot = slot;
    if (polling.poll(++tests)) break;
  }
  corner.complete = !polling.stopped();
  return corner;
}

double TriangleSet::upper(const Piece& piece) {
  if (piece.depth == 0) return upper_of_whole(piece);
  if (const Slots* slots = set_of(piece))
    return least_farthest(piece, search_.to(), *slots, search_.work(), search_.stop());
  const auto& [a, b, c] = piece.corners;
  return least_farthest(piece, search_.to(), std::array{a.slot, b.slot, c.slot}, search_.work());
}

double TriangleSet::upper_of_whole(const Piece& whole) {
  Collected found = collect(whole);
  const double upper = least_farthest(whole, search_.to(), found.slots, search_.work(), search_.stop());
  if (found.complete && upper > search_.cull_below()) {  // else it is never split
    found.slots.shrink_to_fit();
    memory_bytes_ += found.slots.size() * sizeof(std::uint32_t) + sizeof(*sets_.begin());
    sets_.emplace(whole.triangle, std::move(found.slots));
  }
  return upper;
}

const TriangleSet::Slots* TriangleSet::set_of(const Piece& piece) const {
  const auto it = sets_.find(piece.triangle);
  return it == sets_.end() ? nullptr : &it->second;
}

TriangleSet::Collected TriangleSet::collect(const Piece& whole) {
  const auto& [a, b, c] = whole.corners;
  Slots slots{a.slot, b.slot, c.slot};
  const double reach = least_farthest(whole, search_.to(), slots, search_.work()) + kSetMargin;

  const CornersAndFrame s = with_frame(a.point, b.point, c.point);
  Box box;
  for (const Vec3& v : s.corners) box.extend(v);
  const Bvh& to = search_.to();
  std::vector<std::uint32_t> open{Bvh::kRoot};
  std::size_t tests = 0;
  while (!open.empty()) {
    const std::uint32_t child = open.back();
    open.pop_back();
    if (!(child & WideNode::kLeaf)) {
      const WideNode& node = to.nodes()[child];
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (node.child[lane] == WideNode::kNone) continue;
        if (std::sqrt(box_distance_sq(box, Bvh::child_box(node, lane))) <= reach) open.push_back(node.child[lane]);
      }
      continue;
    }
    if ((tests += kLanes) >= kPulseEvery) {
      tests = 0;
      if (search_.interrupted()) return {std::move(slots), false};
    }
    const std::uint32_t block = child & ~WideNode::kLeaf;
    for (std::uint32_t t = Bvh::block_begin(block); t < to.block_end(block); ++t) {
      const CornersAndFrame other{{to.mesh().corner(t, 0), to.mesh().corner(t, 1), to.mesh().corner(t, 2)},
                                  to.prepared(t)};
      if (triangle_distance(s, other) <= reach) slots.push_back(t);
    }
  }
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  return {std::move(slots), true};
}

}  // namespace meshgauge
