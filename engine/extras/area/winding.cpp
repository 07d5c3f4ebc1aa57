#include "engine/extras/area/winding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "engine/kernels/kernels.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::size_t kRays = 12;

// Each axis in both directions, the shortest way out of the box first, then the same with another shear.
struct Ray {
  int x, y, z;  // axes: z is that of the ray
  double s, t;
  bool up;
};

// Box offsets and the ray's position in them err by a few u, since coordinates are at most 1.
constexpr double kWide = 0x1p-47;

std::array<Ray, kRays> rays_from(const Vec3& p, const Box& box) {
  constexpr double kShears[2][2] = {{0.2163542, -0.1538791}, {-0.3490713, 0.4128867}};
  std::array<std::pair<double, int>, 6> ways;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(2 * k);
    ways[at] = {p[k] - box.low[k], 2 * k};
    ways[at + 1] = {box.high[k] - p[k], 2 * k + 1};
  }
  std::sort(ways.begin(), ways.end());
  std::array<Ray, kRays> rays;
  for (std::size_t i = 0; i < kRays; ++i) {
    const auto [length, way] = ways[i % 6];
    const auto& shear = kShears[i / 6];
    rays[i] = {(way / 2 + 1) % 3, (way / 2 + 2) % 3, way / 2, shear[0], shear[1], way % 2 == 1};
  }
  return rays;
}

// Whether the interval [low, high] meets that of the ray, which runs from shear * z0 to shear * z1.
bool meets(double low, double high, double shear, double z0, double z1) {
  const double a = shear * z0, b = shear * z1;
  return std::min(a, b) <= high + kWide && std::max(a, b) >= low - kWide;
}

bool may_meet(const WideNode& node, std::size_t lane, const Vec3& local, const Ray& ray) {
  const auto low = [&](int k) { return static_cast<double>(node.low[k][lane]) - local[k]; };
  const auto high = [&](int k) { return static_cast<double>(node.high[k][lane]) - local[k]; };
  double z0 = low(ray.z) - kWide, z1 = high(ray.z) + kWide;
  ray.up ? z0 = std::max(z0, 0.0) : z1 = std::min(z1, 0.0);
  return z0 <= z1 && meets(low(ray.x), high(ray.x), ray.s, z0, z1) && meets(low(ray.y), high(ray.y), ray.t, z0, z1);
}

// A corner as the ray sees it.
struct Seen {
  double x, y, z;
  double size;  // |q_x| + |q_y| + |q_z|
};

Seen seen(const Vec3& corner, const Vec3& p, const Ray& ray) {
  const double x = corner[ray.x] - p[ray.x], y = corner[ray.y] - p[ray.y], z = corner[ray.z] - p[ray.z];
  return {x - ray.s * z, y - ray.t * z, z, std::abs(x) + std::abs(y) + std::abs(z)};
}

// 1, -1: the sign of a value that errs by at most `error`; 0: unknown.
int sign(double value, double error) { return value > error ? 1 : value < -error ? -1 : 0; }

// Which side of the line through a and b the ray is on.
struct Edge {
  double value;
  int sign;
};

Edge edge(const Seen& a, const Seen& b) {
  const double value = a.x * b.y - b.x * a.y;
  return {value, sign(value, rounding::kRaySlack * a.size * b.size + rounding::kRayOffset)};
}

// Whether all three are surely on one side of 0.
bool one_side(double a, double b, double c, const std::array<Seen, 3>& q) {
  const double error = rounding::kRaySlack * std::max({q[0].size, q[1].size, q[2].size});
  return std::min({a, b, c}) > error || std::max({a, b, c}) < -error;
}

// The sign of the passing: 1, -1; 0: the ray does not meet the triangle. nullopt: unknown.
std::optional<int> passing(const std::array<Vec3, 3>& corners, const Vec3& p, const Ray& ray) {
  const std::array<Seen, 3> q{seen(corners[0], p, ray), seen(corners[1], p, ray), seen(corners[2], p, ray)};
  // The differences z have the exact signs.
  const double z_low = std::min({q[0].z, q[1].z, q[2].z}), z_high = std::max({q[0].z, q[1].z, q[2].z});
  if (ray.up ? z_high < 0 : z_low > 0) return 0;
  if (one_side(q[0].x, q[1].x, q[2].x, q) || one_side(q[0].y, q[1].y, q[2].y, q)) return 0;
  const Edge ab = edge(q[0], q[1]), bc = edge(q[1], q[2]), ca = edge(q[2], q[0]);
  const auto [least, most] = std::minmax({ab.sign, bc.sign, ca.sign});
  if (least < 0 && most > 0) return 0;
  if (least == 0 || most == 0) return std::nullopt;
  int towards = z_low > 0 ? 1 : z_high < 0 ? -1 : 0;  // of the z where the ray's line meets the triangle
  if (towards == 0) {
    const double volume = ab.value * q[2].z + bc.value * q[0].z + ca.value * q[1].z;
    const double error = 4 * rounding::kRaySlack * q[0].size * q[1].size * q[2].size + rounding::kRayOffset;
    towards = least * sign(volume, error);
  }
  if (towards == 0) return std::nullopt;
  if ((towards > 0) != ray.up) return 0;
  return ray.up ? least : -least;
}

// nullopt: the ray is of no use, or the polling stopped.
std::optional<int> winding_along(const Bvh& tree, const Vec3& p, const Ray& ray, std::uint64_t& tests,
                                 Polling& polling) {
  std::array<std::uint32_t, kMaxStack> stack;
  std::size_t size = 0;
  int sum = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::uint32_t at = stack[--size];
    if (at & WideNode::kLeaf) {
      const std::uint32_t block = at & ~WideNode::kLeaf;
      for (std::uint32_t t = Bvh::block_begin(block); t < tree.block_end(block); ++t) {
        const auto& mesh = tree.mesh();
        const auto passed = passing({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}, p, ray);
        if (!passed) return std::nullopt;
        sum += *passed;
      }
      tests += kLanes;
      if (polling.poll(tests)) return std::nullopt;
      continue;
    }
    const WideNode& node = tree.nodes()[at];
    const Vec3 local = p - Vec3(node.origin[0], node.origin[1], node.origin[2]);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (node.child[lane] != WideNode::kNone && may_meet(node, lane, local, ray)) stack[size++] = node.child[lane];
    }
  }
  return sum;
}

Box box_of(const Bvh& tree) {
  Box box;
  const WideNode& root = tree.nodes()[Bvh::kRoot];
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (root.child[lane] != WideNode::kNone) box.extend(Bvh::child_box(root, lane));
  }
  return box;
}

}  // namespace

std::optional<int> winding_number(const Bvh& tree, const Vec3& p, Work& work, const Interrupted* stop) {
  const Box box = box_of(tree);
  if (((box.low - p).array() > kWide).any() || ((p - box.high).array() > kWide).any()) return 0;
  Polling polling(stop, work.triangle_tests);
  for (const Ray& ray : rays_from(p, box)) {
    const auto found = winding_along(tree, p, ray, work.triangle_tests, polling);
    if (found || polling.stopped()) return found;
  }
  return std::nullopt;
}

}  // namespace meshgauge
