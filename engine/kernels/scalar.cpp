#include "engine/kernels/kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "engine/kernels/flat.h"
#include "engine/kernels/walk.h"

namespace meshgauge {
namespace {

// Clamps s to [0, most] as the instructions do: never returns -0.
double clamp(double s, double most) {
  const double positive = s > 0 ? s : 0;
  return positive < most ? positive : most;
}

// The squared distance of a point from its closest_point() (engine/tree/triangle.h), without branches as in the SIMD
// kernels.
double distance_sq(const FlatTriangle& t, double px, double py, double pz) {
  const double ax = px - t.a[0], ay = py - t.a[1], az = pz - t.a[2];
  const double x = ax * t.e1[0] + ay * t.e1[1] + az * t.e1[2];
  const double rx = ax - x * t.e1[0], ry = ay - x * t.e1[1], rz = az - x * t.e1[2];
  const double y = rx * t.e2[0] + ry * t.e2[1] + rz * t.e2[2];
  const double dx = t.length - t.cx;
  const double back = t.length - x;

  const double s_ac = clamp((x * t.cx + y * t.cy) / (t.cx * t.cx + t.cy * t.cy), 1);
  const double s_bc = clamp((back * dx + y * t.cy) / (dx * dx + t.cy * t.cy), 1);
  const double ac_x = s_ac * t.cx, ac_y = s_ac * t.cy;
  const double bc_x = t.length - s_bc * dx, bc_y = s_bc * t.cy;
  const double ac_sq = (ac_x - x) * (ac_x - x) + (ac_y - y) * (ac_y - y);
  const double bc_sq = (bc_x - x) * (bc_x - x) + (bc_y - y) * (bc_y - y);
  const bool beyond_ac = t.cx * y - t.cy * x > 0;
  const bool beyond_bc = dx * y - t.cy * back > 0;
  const bool use_ac = beyond_ac && !(beyond_bc && bc_sq < ac_sq);
  const bool use_bc = beyond_bc && !use_ac;
  double qx = use_ac ? ac_x : use_bc ? bc_x : x;
  double qy = use_ac ? ac_y : use_bc ? bc_y : y;
  if (y <= 0) {
    qx = clamp(x, t.length);
    qy = 0;
  }
  const double gx = ax - (qx * t.e1[0] + qy * t.e2[0]);
  const double gy = ay - (qx * t.e1[1] + qy * t.e2[1]);
  const double gz = az - (qx * t.e1[2] + qy * t.e2[2]);
  return gx * gx + gy * gy + gz * gz;
}

struct P {
  double x, y, z;
};
P at(const PointBlock& block, std::size_t i) { return {block.at[0][i], block.at[1][i], block.at[2][i]}; }
P operator-(const P& a, const P& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
P operator+(const P& a, const P& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
P operator*(double s, const P& a) { return {s * a.x, s * a.y, s * a.z}; }
P operator/(const P& a, double s) { return {a.x / s, a.y / s, a.z / s}; }
double dot(const P& a, const P& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const P& a) { return std::sqrt(dot(a, a)); }

double prepare(const PointBlock corners[3], TriangleBlock& out) {
  double residual = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    P a = at(corners[0], i), b = at(corners[1], i), c = at(corners[2], i);
    const double ab = dot(b - a, b - a), bc = dot(c - b, c - b), ca = dot(a - c, a - c);
    if (bc > ab && bc >= ca) {
      std::tie(a, b, c) = std::tuple(b, c, a);
    } else if (ca > ab && ca > bc) {
      std::tie(a, b, c) = std::tuple(c, a, b);
    }
    double base = length(b - a);
    P e1 = (b - a) / base;
    if (base < kNegligibleLength) base = 0, e1 = {0, 0, 0};
    const P ac = c - a;
    const double along = dot(ac, e1);
    const double cx = clamp(along, base);
    P across = ac - along * e1;
    across = across - dot(across, e1) * e1;  // once more: orthogonal to rounding even where `across` is tiny
    double cy = length(across);
    P e2 = across / cy;
    if (cy < kNegligibleLength) cy = 0, e2 = {0, 0, 0};
    residual = std::max({residual, length(a + base * e1 - b), length(a + cx * e1 + cy * e2 - c)});
    store({{a.x, a.y, a.z}, {e1.x, e1.y, e1.z}, {e2.x, e2.y, e2.z}, base, cx, cy}, out, i);
  }
  return residual;
}

Closest nearest(const TreeView& tree, const double p[3], Closest best, std::uint64_t& tests, Polling& polling) {
  walk(tree, p, best.distance_sq, [&](std::uint32_t block) {
    tests += kLanes;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const double d_sq = distance_sq(flat(tree.blocks[block], lane), p[0], p[1], p[2]);
      if (d_sq < best.distance_sq) best = {d_sq, block * static_cast<std::uint32_t>(kLanes) + lane};
    }
    return polling.poll(tests, best.distance_sq) ? kEndWalk : best.distance_sq;
  });
  return best;
}

double farthest_sq(const TriangleBlock& block, std::size_t lane, const PointBlock& points) {
  const FlatTriangle triangle = flat(block, lane);
  double farthest = 0;
  for (std::size_t i = 0; i < kLanes / 2; ++i) {
    farthest = std::max(farthest, distance_sq(triangle, points.at[0][i], points.at[1][i], points.at[2][i]));
  }
  return farthest;
}

// What lower.inc and patch.inc need, for vectors of one lane.
using V = double;
constexpr std::size_t kStep = 1;
V spread(double x) { return x; }
V load(const double* from) { return *from; }
void store(V v, double* to) { *to = v; }
V least(V a, V b) { return b < a ? b : a; }
V most(V a, V b) { return b > a ? b : a; }
V magnitude(V v) { return std::abs(v); }
V choose(bool yes, V a, V b) { return yes ? a : b; }
bool both(bool a, bool b) { return a && b; }
bool except(bool a, bool b) { return a && !b; }
unsigned bits(bool yes) { return yes ? 1 : 0; }

#include "engine/kernels/lower.inc"
#include "engine/kernels/patch.inc"

}  // namespace

Kernels scalar_kernels() {
  return {"scalar", prepare, nearest, farthest_sq, project, cover, lower_boxes, lower_triangles};
}

}  // namespace meshgauge
