#include "engine/extras/area/minorant.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "engine/kernels/walk.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr double kLeastLength = 0x1p-400;  // a shorter vector has no direction
constexpr double kGoodEnough = 0x1p-10;    // of the sum of the values, which may fall by so much without more attempts
constexpr std::uint64_t kTestsOfOne = 8;   // a triangle takes as long as so many of a query's tests

std::optional<Vec3> direction_of(const Vec3& v) {
  const double length = norm(v);
  if (!(length > kLeastLength)) return std::nullopt;
  return v / length;
}

// The bound while the tree is walked.
class Minorant {
 public:
  Minorant(const Bvh& to, std::span<const MinorantPoint> points) : to_(to), points_(points) {
    for (std::size_t i = 0; i < size(); ++i) {
      values_[i] = points[i].value;
      centre_ += points[i].point;
    }
    centre_ /= static_cast<double>(size());
    for (const MinorantPoint& p : points) radius_ = std::max(radius_, norm(p.point - centre_));
    radius_ += rounding::kDistanceSlack;
    for (int k = 0; k < 3; ++k) probe_.centre[k] = centre_[k];
    add_shared_directions();
    update();
    for (std::size_t i = 0; i < size(); ++i) {
      if (is_first_of_slot(i)) add(points[i].slot);
    }
  }

  double value(std::size_t i) const { return values_[i]; }
  const LowerProbe& probe() const { return probe_; }
  double sum() const { return sum_; }
  double most() const { return most_; }
  // A box farther than this from the centre cannot lower any value.
  double reach() const { return std::max(most_, 0.0) + radius_; }

  // Takes triangle `slot` into account.
  void add(std::uint32_t slot) {
    const MeshView mesh = to_.mesh();
    const std::array<Vec3, 3> corners{mesh.corner(slot, 0), mesh.corner(slot, 1), mesh.corner(slot, 2)};
    const PreparedTriangle triangle = to_.prepared(slot);
    Best best;
    const Vec3 from = centre_ - closest_point(triangle, centre_);
    if (attempt(from, corners, best)) return share(from);
    Vec3 normal = triangle.e1.cross(triangle.e2);
    if (dot(normal, from) < 0) normal = -normal;
    if (attempt(normal, corners, best)) return share(normal);
    for (std::size_t d = 0; d < probe_.directions; ++d) {
      if (attempt(shared_[d].heights, top_of(corners, shared_[d].n), best)) return;
    }
    for (const MinorantPoint& p : points_) {
      if (sum_ - best.sum <= kGoodEnough * sum_) break;
      if (attempt(p.point - closest_point(triangle, p.point), corners, best)) return;
    }
    values_ = best.values;
    update();
  }

 private:
  using Values = std::array<double, kMostMinorantPoints>;  // by point
  struct Direction {
    Vec3 n;
    Values heights;
  };
  struct Best {
    Values values{};
    double sum = -1e300;
  };

  std::size_t size() const { return points_.size(); }
  bool is_first_of_slot(std::size_t i) const {
    return std::none_of(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(i),
                        [&](const MinorantPoint& p) { return p.slot == points_[i].slot; });
  }

  // The values have fallen.
  void update() {
    sum_ = 0, most_ = values_[0];
    for (std::size_t i = 0; i < size(); ++i) sum_ += values_[i], most_ = std::max(most_, values_[i]);
    probe_.limit_sq = far_limit(reach() * reach());
    for (std::size_t d = 0; d < probe_.directions; ++d) {
      const Values& h = shared_[d].heights;
      double top = h[0] - values_[0];
      for (std::size_t i = 1; i < size(); ++i) top = std::min(top, h[i] - values_[i]);
      probe_.tops[d] = top;
    }
  }

  // The mean direction from B to P, and the normals of P and of the owners on that side. A triangle beyond a convex
  // edge of B lies below its neighbour's plane.
  void add_shared_directions() {
    constexpr std::size_t kMostOwners = 3;
    Vec3 away = Vec3::Zero();
    std::array<Vec3, kMostOwners> normals;
    std::size_t owners = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      const PreparedTriangle owner = to_.prepared(points_[i].slot);
      away += points_[i].point - closest_point(owner, points_[i].point);
      if (owners < kMostOwners && is_first_of_slot(i)) normals[owners++] = owner.e1.cross(owner.e2);
    }
    const auto add_towards = [&](const Vec3& v) { add_direction(dot(v, away) < 0 ? Vec3(-v) : v); };
    for (std::size_t i = 0; i < owners; ++i) add_towards(normals[i]);
    add_direction(away);
    const Vec3& first = points_[0].point;
    add_towards((points_[1].point - first).cross(points_[2].point - first));
  }

  // A direction that keeps one triangle often keeps its neighbours, too.
  void share(const Vec3& v) {
    if (probe_.directions == LowerProbe::kMaxDirections) return;
    add_direction(v);
    update();
  }

  void add_direction(const Vec3& v) {
    const auto n = direction_of(v);
    if (!n) return;
    for (int k = 0; k < 3; ++k) probe_.n[probe_.directions][k] = (*n)[k];
    shared_[probe_.directions++] = {*n, heights(*n)};
  }

  Values heights(const Vec3& n) const {
    Values found;
    for (std::size_t i = 0; i < size(); ++i) found[i] = dot(points_[i].point, n);
    return found;
  }

  static double top_of(const std::array<Vec3, 3>& corners, const Vec3& n) {
    return std::max({dot(corners[0], n), dot(corners[1], n), dot(corners[2], n)});
  }

  bool attempt(const Vec3& v, const std::array<Vec3, 3>& corners, Best& best) const {
    const auto n = direction_of(v);
    return n && attempt(heights(*n), top_of(corners, *n), best);
  }

  // Keeps the values that fall least. True: the triangle lowers none.
  bool attempt(const Values& heights, double top, Best& best) const {
    Values fallen;
    double sum = 0;
    bool any = false;
    for (std::size_t i = 0; i < size(); ++i) {
      const double value = heights[i] - top;
      any = any || value < values_[i];
      sum += fallen[i] = std::min(values_[i], value);
    }
    if (sum > best.sum) best = {fallen, sum};
    return !any;
  }

  const Bvh& to_;
  const std::span<const MinorantPoint> points_;
  Values values_;
  double sum_ = 0, most_ = 0;
  Vec3 centre_ = Vec3::Zero();
  double radius_ = 0;
  std::array<Direction, LowerProbe::kMaxDirections> shared_;
  LowerProbe probe_{};
};

// Pushes the children that may lower a value, the nearest on top. Returns the new size of the stack.
std::size_t push_children(const Kernels& kernels, const WideNode& node, const Minorant& minorant, WalkEntry* stack,
                          std::size_t size) {
  PointBlock low, high;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      low.at[k][lane] = node.origin[k] + static_cast<double>(node.low[k][lane]);
      high.at[k][lane] = node.origin[k] + static_cast<double>(node.high[k][lane]);
    }
  }
  alignas(64) double distances_sq[kLanes];
  const std::size_t bottom = size;
  std::size_t nearest = size;
  double least = 0;
  for (unsigned may = kernels.lower_boxes(low, high, minorant.probe(), distances_sq); may != 0; may &= may - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(may));
    if (size == bottom || distances_sq[lane] < least) least = distances_sq[lane], nearest = size;
    stack[size++] = {static_cast<float>(distances_sq[lane]), node.child[lane]};
  }
  if (size > bottom) std::swap(stack[nearest], stack[size - 1]);
  return size;
}

// Takes the triangles of a leaf into account. Lanes beyond the last triangle repeat it.
void add_block(const Bvh& to, std::uint32_t block, Minorant& minorant) {
  const std::uint32_t begin = Bvh::block_begin(block), last = to.block_end(block) - 1;
  std::array<PointBlock, 3> corners;
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& p = to.mesh().corner(std::min(begin + lane, last), static_cast<int>(c));
      for (int k = 0; k < 3; ++k) corners[c].at[k][lane] = p[k];
    }
  }
  for (unsigned may = to.kernels().lower_triangles(corners.data(), minorant.probe()); may != 0; may &= may - 1) {
    const std::uint32_t t = begin + static_cast<std::uint32_t>(std::countr_zero(may));
    if (t <= last) minorant.add(t);
  }
}

}  // namespace

MinorantFound lower_to_minorant(const Bvh& to, std::span<MinorantPoint> points, double least_sum, Work& work,
                                const Interrupted* stop) {
  Minorant minorant(to, points);
  Polling polling(stop, work.triangle_tests);
  std::array<WalkEntry, kMaxStack> stack;
  std::size_t size = 0;
  std::uint64_t boxes = 0;
  stack[size++] = {0, Bvh::kRoot};
  while (size > 0 && minorant.most() > 0 && minorant.sum() > least_sum) {
    const WalkEntry entry = stack[--size];
    const double reach = minorant.reach();
    if (entry.distance_sq > near_limit(reach * reach)) continue;
    if (!(entry.child & WideNode::kLeaf)) {
      size = push_children(to.kernels(), to.nodes()[entry.child], minorant, stack.data(), size);
      boxes += kLanes;
    } else {
      add_block(to, entry.child & ~WideNode::kLeaf, minorant);
      work.triangle_tests += kTestsOfOne * kLanes;
    }
    if (polling.poll(work.triangle_tests + boxes)) return MinorantFound::interrupted;
  }
  const bool is_any = minorant.most() > 0;  // else 0 is as good
  if (!((is_any ? minorant.sum() : 0) > least_sum)) return MinorantFound::too_low;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].value = is_any ? minorant.value(i) : 0;
  return MinorantFound::yes;
}

}  // namespace meshgauge
