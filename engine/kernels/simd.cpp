// The kernels for instruction sets that work on several lanes at once. This file is compiled once for each of them,
// with another HWY_NAMESPACE each time. Only Highway's headers are included after HWY_BEFORE_NAMESPACE: the linker
// keeps one copy of an inline function, and every processor must be able to run it.
#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/kernels/kernels.h"

// SSSE3 and the finest AVX-512 gain nothing over their neighbours; vectors of unknown length fit no array.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/kernels/simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace meshgauge {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kLanes>;
using Floats = hn::CappedTag<float, kLanes>;
using D = hn::Vec<Doubles>;
using F = hn::Vec<Floats>;
constexpr Doubles kDoubles;
constexpr Floats kFloats;

constexpr std::uint32_t kLanes32 = static_cast<std::uint32_t>(kLanes);

// A triangle, or several triangles with one in each lane.
struct Triangles {
  D a[3], e1[3], e2[3], length, cx, cy;
};

Triangles load(const TriangleBlock& block, std::size_t i) {
  Triangles t;
  for (int k = 0; k < 3; ++k) {
    t.a[k] = hn::Load(kDoubles, block.a[k] + i);
    t.e1[k] = hn::Load(kDoubles, block.e1[k] + i);
    t.e2[k] = hn::Load(kDoubles, block.e2[k] + i);
  }
  t.length = hn::Load(kDoubles, block.length + i);
  t.cx = hn::Load(kDoubles, block.cx + i);
  t.cy = hn::Load(kDoubles, block.cy + i);
  return t;
}

// No MulAdd: a fused operation rounds once where the reference rounds twice.
D dot(const D x[3], const D y[3]) {
  return hn::Add(hn::Add(hn::Mul(x[0], y[0]), hn::Mul(x[1], y[1])), hn::Mul(x[2], y[2]));
}
D square(D x) { return hn::Mul(x, x); }
D clamp01(D s) { return hn::Min(hn::Max(s, hn::Zero(kDoubles)), hn::Set(kDoubles, 1.0)); }

// See the reference, scalar.cpp.
D distance_sq(const Triangles& t, D px, D py, D pz) {
  const D ap[3] = {hn::Sub(px, t.a[0]), hn::Sub(py, t.a[1]), hn::Sub(pz, t.a[2])};
  const D x = dot(ap, t.e1);
  const D rest[3] = {hn::Sub(ap[0], hn::Mul(x, t.e1[0])), hn::Sub(ap[1], hn::Mul(x, t.e1[1])),
                     hn::Sub(ap[2], hn::Mul(x, t.e1[2]))};
  const D y = dot(rest, t.e2);
  const D dx = hn::Sub(t.length, t.cx);
  const D back = hn::Sub(t.length, x);
  const D zero = hn::Zero(kDoubles);

  const D s_ac = clamp01(hn::Div(hn::Add(hn::Mul(x, t.cx), hn::Mul(y, t.cy)), hn::Add(square(t.cx), square(t.cy))));
  const D s_bc = clamp01(hn::Div(hn::Add(hn::Mul(back, dx), hn::Mul(y, t.cy)), hn::Add(square(dx), square(t.cy))));
  const D ac_x = hn::Mul(s_ac, t.cx), ac_y = hn::Mul(s_ac, t.cy);
  const D bc_x = hn::Sub(t.length, hn::Mul(s_bc, dx)), bc_y = hn::Mul(s_bc, t.cy);
  const D ac_sq = hn::Add(square(hn::Sub(ac_x, x)), square(hn::Sub(ac_y, y)));
  const D bc_sq = hn::Add(square(hn::Sub(bc_x, x)), square(hn::Sub(bc_y, y)));
  const auto beyond_ac = hn::Gt(hn::Sub(hn::Mul(t.cx, y), hn::Mul(t.cy, x)), zero);
  const auto beyond_bc = hn::Gt(hn::Sub(hn::Mul(dx, y), hn::Mul(t.cy, back)), zero);
  const auto use_ac = hn::AndNot(hn::And(beyond_bc, hn::Lt(bc_sq, ac_sq)), beyond_ac);
  D qx = hn::IfThenElse(use_ac, ac_x, hn::IfThenElse(beyond_bc, bc_x, x));
  D qy = hn::IfThenElse(use_ac, ac_y, hn::IfThenElse(beyond_bc, bc_y, y));
  const auto below = hn::Le(y, zero);
  qx = hn::IfThenElse(below, hn::Min(hn::Max(x, zero), t.length), qx);
  qy = hn::IfThenElse(below, zero, qy);
  const D gap[3] = {hn::Sub(ap[0], hn::Add(hn::Mul(qx, t.e1[0]), hn::Mul(qy, t.e2[0]))),
                    hn::Sub(ap[1], hn::Add(hn::Mul(qx, t.e1[1]), hn::Mul(qy, t.e2[1]))),
                    hn::Sub(ap[2], hn::Add(hn::Mul(qx, t.e1[2]), hn::Mul(qy, t.e2[2])))};
  return dot(gap, gap);
}

F gap(F low, F high, F p) { return hn::Max(hn::Max(hn::Sub(low, p), hn::Sub(p, high)), hn::Zero(kFloats)); }
D gap(D low, D high, D p) { return hn::Max(hn::Max(hn::Sub(low, p), hn::Sub(p, high)), hn::Zero(kDoubles)); }

struct Entry {
  float distance_sq;
  std::uint32_t child;
};

// Pushes the lanes that are set in `within`, which is not 0; see the reference, walk.h.
template <class Number>
std::size_t push(const WideNode& node, unsigned within, const Number distances_sq[kLanes], Entry* stack,
                 std::size_t size) {
  std::size_t nearest = size;
  Number least = distances_sq[__builtin_ctz(within)];
  for (; within != 0; within &= within - 1) {
    const int lane = __builtin_ctz(within);
    const bool nearer = distances_sq[lane] < least;
    least = nearer ? distances_sq[lane] : least;
    nearest = nearer ? size : nearest;
    stack[size].distance_sq = static_cast<float>(distances_sq[lane]);
    stack[size].child = node.child[lane];
    ++size;
  }
  const Entry last = stack[size - 1];
  stack[size - 1] = stack[nearest];
  stack[nearest] = last;
  return size;
}

// The same in double, for far queries; rarely needed.
HWY_NOINLINE std::size_t push_far_children(const WideNode& node, const double p[3], double limit, Entry* stack,
                                           std::size_t size) {
  constexpr hn::Rebind<float, Doubles> kHalf;
  const auto wide = [&](const float* values) { return hn::PromoteTo(kDoubles, hn::Load(kHalf, values)); };
  const D x = hn::Set(kDoubles, p[0]), y = hn::Set(kDoubles, p[1]), z = hn::Set(kDoubles, p[2]);
  HWY_ALIGN double distances_sq[kLanes];
  unsigned within = 0;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(kDoubles)) {
    const D gx = gap(wide(node.low[0] + i), wide(node.high[0] + i), x);
    const D gy = gap(wide(node.low[1] + i), wide(node.high[1] + i), y);
    const D gz = gap(wide(node.low[2] + i), wide(node.high[2] + i), z);
    hn::Store(hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz)), kDoubles, distances_sq + i);
  }
  for (unsigned lane = 0; lane < kLanes32; ++lane) within |= distances_sq[lane] <= limit ? 1U << lane : 0U;
  return within == 0 ? size : push(node, within, distances_sq, stack, size);
}

std::size_t push_children(const WideNode& node, const double p[3], double best_sq, float limit, Entry* stack,
                          std::size_t size) {
  const double local[3] = {p[0] - node.origin[0], p[1] - node.origin[1], p[2] - node.origin[2]};
  const auto fx = static_cast<float>(local[0]), fy = static_cast<float>(local[1]), fz = static_cast<float>(local[2]);
  const float far = kFar * node.reach;
  if (fx > far || fx < -far || fy > far || fy < -far || fz > far || fz < -far) {
    return push_far_children(node, local, far_limit(best_sq), stack, size);
  }
  const F x = hn::Set(kFloats, fx), y = hn::Set(kFloats, fy), z = hn::Set(kFloats, fz);
  HWY_ALIGN float distances_sq[kLanes];
  unsigned within = 0;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(kFloats)) {
    const F gx = gap(hn::Load(kFloats, node.low[0] + i), hn::Load(kFloats, node.high[0] + i), x);
    const F gy = gap(hn::Load(kFloats, node.low[1] + i), hn::Load(kFloats, node.high[1] + i), y);
    const F gz = gap(hn::Load(kFloats, node.low[2] + i), hn::Load(kFloats, node.high[2] + i), z);
    const F sum = hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz));
    hn::Store(sum, kFloats, distances_sq + i);
    HWY_ALIGN std::uint8_t bits[8] = {};
    hn::StoreMaskBits(kFloats, hn::Le(sum, hn::Set(kFloats, limit)), bits);
    within |= static_cast<unsigned>(bits[0]) << i;
  }
  return within == 0 ? size : push(node, within, distances_sq, stack, size);
}

void closest_of_block(const TriangleBlock& block, std::uint32_t number, const double p[3], Closest& best) {
  const D px = hn::Set(kDoubles, p[0]), py = hn::Set(kDoubles, p[1]), pz = hn::Set(kDoubles, p[2]);
  HWY_ALIGN double d_sq[kLanes];
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(kDoubles)) {
    hn::Store(distance_sq(load(block, i), px, py, pz), kDoubles, d_sq + i);
  }
  for (std::uint32_t lane = 0; lane < kLanes32; ++lane) {
    if (d_sq[lane] < best.distance_sq) {
      best.distance_sq = d_sq[lane];
      best.slot = number * kLanes32 + lane;
    }
  }
}

// The triangle of one lane, copied to all lanes.
Triangles spread(const TriangleBlock& block, std::size_t lane) {
  Triangles t;
  for (int k = 0; k < 3; ++k) {
    t.a[k] = hn::Set(kDoubles, block.a[k][lane]);
    t.e1[k] = hn::Set(kDoubles, block.e1[k][lane]);
    t.e2[k] = hn::Set(kDoubles, block.e2[k][lane]);
  }
  t.length = hn::Set(kDoubles, block.length[lane]);
  t.cx = hn::Set(kDoubles, block.cx[lane]);
  t.cy = hn::Set(kDoubles, block.cy[lane]);
  return t;
}

double farthest_sq(const TriangleBlock& block, std::size_t lane, const PointBlock& points) {
  const Triangles triangle = spread(block, lane);
  HWY_ALIGN double d_sq[kLanes];
  for (std::size_t i = 0; i < kLanes / 2; i += hn::Lanes(kDoubles)) {
    hn::Store(distance_sq(triangle, hn::Load(kDoubles, points.at[0] + i), hn::Load(kDoubles, points.at[1] + i),
                          hn::Load(kDoubles, points.at[2] + i)),
              kDoubles, d_sq + i);
  }
  double farthest = 0;
  for (std::size_t i = 0; i < kLanes / 2; ++i) farthest = d_sq[i] > farthest ? d_sq[i] : farthest;
  return farthest;
}

Closest nearest(const TreeView& tree, const double p[3], Closest best, std::uint64_t& tests, Polling& polling) {
  Entry stack[kMaxStack];
  std::size_t size = 0;
  stack[size++] = Entry{0, 0};
  float limit = near_limit(best.distance_sq);
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.distance_sq > limit) continue;
    if (entry.child & WideNode::kLeaf) {
      const std::uint32_t number = entry.child & ~WideNode::kLeaf;
      tests += kLanes;
      closest_of_block(tree.blocks[number], number, p, best);
      if (polling.poll(tests, best.distance_sq)) break;
      limit = near_limit(best.distance_sq);
    } else {
      size = push_children(tree.nodes[entry.child], p, best.distance_sq, limit, stack, size);
    }
  }
  return best;
}

// A point, or several points with one in each lane.
struct Points {
  D x, y, z;
};

Points load(const PointBlock& block, std::size_t i) {
  return {hn::Load(kDoubles, block.at[0] + i), hn::Load(kDoubles, block.at[1] + i),
          hn::Load(kDoubles, block.at[2] + i)};
}
void store(const Points& p, double to[3][kLanes], std::size_t i) {
  hn::Store(p.x, kDoubles, to[0] + i);
  hn::Store(p.y, kDoubles, to[1] + i);
  hn::Store(p.z, kDoubles, to[2] + i);
}
Points add(const Points& a, const Points& b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
Points sub(const Points& a, const Points& b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
Points mul(D s, const Points& a) { return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)}; }
Points div(const Points& a, D s) { return {hn::Div(a.x, s), hn::Div(a.y, s), hn::Div(a.z, s)}; }
D dot(const Points& a, const Points& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
D length(const Points& a) { return hn::Sqrt(dot(a, a)); }
template <class Mask>
Points choose(Mask mask, const Points& yes, const Points& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y), hn::IfThenElse(mask, yes.z, no.z)};
}

// See the reference, scalar.cpp. Returns the residual of each lane.
D prepare(const Points& p, const Points& q, const Points& r, TriangleBlock& out, std::size_t i) {
  const D zero = hn::Zero(kDoubles), negligible = hn::Set(kDoubles, kNegligibleLength);
  const Points none{zero, zero, zero};
  const D pq = dot(sub(q, p), sub(q, p)), qr = dot(sub(r, q), sub(r, q)), rp = dot(sub(p, r), sub(p, r));
  const auto from_q = hn::And(hn::Gt(qr, pq), hn::Ge(qr, rp));
  const auto from_r = hn::And(hn::Gt(rp, pq), hn::Gt(rp, qr));
  const Points a = choose(from_q, q, choose(from_r, r, p));
  const Points b = choose(from_q, r, choose(from_r, p, q));
  const Points c = choose(from_q, p, choose(from_r, q, r));
  D base = length(sub(b, a));
  const auto is_point = hn::Lt(base, negligible);
  const Points e1 = choose(is_point, none, div(sub(b, a), base));
  base = hn::IfThenElse(is_point, zero, base);
  const Points ac = sub(c, a);
  const D along = dot(ac, e1);
  const D cx = hn::Min(hn::Max(along, zero), base);
  Points across = sub(ac, mul(along, e1));
  across = sub(across, mul(dot(across, e1), e1));
  D cy = length(across);
  const auto is_segment = hn::Lt(cy, negligible);
  const Points e2 = choose(is_segment, none, div(across, cy));
  cy = hn::IfThenElse(is_segment, zero, cy);
  store(a, out.a, i);
  store(e1, out.e1, i);
  store(e2, out.e2, i);
  hn::Store(base, kDoubles, out.length + i);
  hn::Store(cx, kDoubles, out.cx + i);
  hn::Store(cy, kDoubles, out.cy + i);
  const D at_b = length(sub(add(a, mul(base, e1)), b));
  const D at_c = length(sub(add(add(a, mul(cx, e1)), mul(cy, e2)), c));
  return hn::Max(at_b, at_c);
}

double prepare(const PointBlock corners[3], TriangleBlock& out) {
  HWY_ALIGN double residuals[kLanes];
  double residual = 0;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(kDoubles)) {
    hn::Store(prepare(load(corners[0], i), load(corners[1], i), load(corners[2], i), out, i), kDoubles, residuals + i);
  }
  for (const double lane : residuals) residual = lane > residual ? lane : residual;
  return residual;
}

// What lower.inc and patch.inc need.
using V = D;
using M = hn::Mask<Doubles>;
constexpr std::size_t kStep = hn::MaxLanes(kDoubles);
V spread(double x) { return hn::Set(kDoubles, x); }
V load(const double* from) { return hn::Load(kDoubles, from); }
void store(V v, double* to) { hn::Store(v, kDoubles, to); }
V least(V a, V b) { return hn::Min(a, b); }
V most(V a, V b) { return hn::Max(a, b); }
V magnitude(V v) { return hn::Abs(v); }
V choose(M yes, V a, V b) { return hn::IfThenElse(yes, a, b); }
M both(M a, M b) { return hn::And(a, b); }
M except(M a, M b) { return hn::AndNot(b, a); }
unsigned bits(M mask) {
  HWY_ALIGN std::uint8_t result[8] = {};
  hn::StoreMaskBits(kDoubles, mask, result);
  return result[0];
}

#include "engine/kernels/lower.inc"
#include "engine/kernels/patch.inc"

}  // namespace

void fill(Kernels& kernels) {
  kernels.prepare = prepare;
  kernels.nearest = nearest;
  kernels.farthest_sq = farthest_sq;
  kernels.project = project;
  kernels.cover = cover;
  kernels.lower_boxes = lower_boxes;
  kernels.lower_triangles = lower_triangles;
}

}  // namespace HWY_NAMESPACE
}  // namespace meshgauge
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace meshgauge {
namespace {

struct Target {
  const char* name;
  bool (*supported)();
  void (*fill)(Kernels&);
};

// Uses the compiler's own test of the processor. Highway's library has one, too, but calibrates a clock for 4 ms at
// every start of a program.
#if HWY_ARCH_X86
bool has_sse4() {
  return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("aes");
}
bool has_avx2() {
  return has_sse4() && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
         __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");  // implies F16C, which is older; clang 14 has no name for that
}
bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd");
}
#endif

// The fastest first.
constexpr Target kTargets[] = {
#if HWY_TARGETS & HWY_AVX3
    {"avx512", has_avx512, N_AVX3::fill},
#endif
#if HWY_TARGETS & HWY_AVX2
    {"avx2", has_avx2, N_AVX2::fill},
#endif
#if HWY_TARGETS & HWY_SSE4
    {"sse4", has_sse4, N_SSE4::fill},
#endif
#if HWY_TARGETS & HWY_NEON
    {"neon", [] { return true; }, N_NEON::fill},
#endif
    {nullptr, nullptr, nullptr},
};

}  // namespace

std::vector<Kernels> simd_kernels() {
  std::vector<Kernels> result;
  for (const Target& target : kTargets) {
    if (!target.name || !target.supported()) continue;
    target.fill(result.emplace_back());
    result.back().name = target.name;
  }
  return result;
}

}  // namespace meshgauge
#endif  // HWY_ONCE
