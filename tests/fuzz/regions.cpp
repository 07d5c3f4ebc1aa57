// fuzz_certify regions: certified distances within regions (engine/measure/region_stage.h) of random and adversarial
// pairs against an independent subdivision.
//
// Each interval must meet the bracket of tests/oracle/region.h, whenever and for whatever reason the search ends, the
// whole must be covered, and a region that is said to be empty must be. Ends at the first violation.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "engine/hausdorff.h"
#include "engine/tree/prepared.h"
#include "fuzz/attacks.h"
#include "fuzz/dice.h"
#include "fuzz/generate.h"
#include "oracle/region.h"

namespace {

using namespace meshgauge;

constexpr int kCells = 150;

// Mostly a vertex of the mesh, whose coordinates are those of faces and edges, or a point between two.
Vec3 place(fuzz::Dice& dice, const Mesh& mesh) {
  const auto vertex = [&] {
    const Triangle& t = mesh.triangles[dice.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
    return mesh.positions[t[dice.below(3)]];
  };
  const Vec3 p = vertex();
  if (dice.chance(0.4)) return p;
  const Vec3 q = p + dice.uniform(-0.2, 1.2) * (vertex() - p);
  return dice.chance(0.5) ? q : Vec3(p.x(), q.y(), q.z());
}

Group make_group(fuzz::Dice& dice, const Mesh& mesh) {
  Group group;
  for (std::uint32_t t = dice.below(3); t < mesh.triangles.size(); t += 1 + dice.below(3))
    group.ranges.push_back({t, t + 1});
  if (group.ranges.empty()) group.ranges.push_back({0, 1});
  return group;
}

template <class Take>
Mesh triangles_of(const Mesh& mesh, const Take& take) {
  Mesh some{mesh.positions, {}};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (take(t)) some.triangles.push_back(mesh.triangles[t]);
  }
  return some;
}

// `pair.a` is measured from.
Region make_region(fuzz::Dice& dice, const fuzz::Pair& pair) {
  if (dice.chance(0.2)) return {make_group(dice, pair.a), {}};
  const auto any = [&] { return place(dice, dice.chance(0.5) ? pair.a : pair.b); };
  const Vec3 p = any(), q = any();
  if (dice.chance(0.5)) return {Box{p.cwiseMin(q), p.cwiseMax(q)}, {}};
  const double radius = (q - p).norm() * (dice.chance(0.5) ? 1 : dice.power(-3, 1));
  return {Sphere{p, std::min(radius, kMaxCoordinate)}, {}};
}

Mesh shaken(fuzz::Dice& dice, double most, Mesh mesh, double& error) {
  for (Vec3& p : mesh.positions) {
    const Vec3 q = p + most * dice.point();
    error = std::max(error, (q - p).norm() * (1 + 1e-12));
    p = q;
  }
  return mesh;
}

Prepared prepared(const Mesh& mesh, double error) {
  return Prepared(mesh, Prepared::Use::once, nullptr, std::nullopt, error);
}

bool has(const Region& region, std::size_t triangle) {
  const auto* group = std::get_if<Group>(&region.shape);
  return group && group->has(triangle);
}

// The bracket of a region, or with i = regions.size() that of the rest.
oracle::RegionBracket bracket_of(const fuzz::Pair& pair, std::span<const Region> regions, std::size_t i,
                                 long double slack) {
  if (i < regions.size() && !regions[i].is_group())
    return oracle::farthest_inside(pair.a, pair.b, regions[i], slack, kCells);
  if (i < regions.size()) {
    const Mesh group = triangles_of(pair.a, [&](std::size_t t) { return has(regions[i], t); });
    const Region all{Sphere{Vec3::Zero(), std::numeric_limits<double>::infinity()}, {}};
    return oracle::farthest_inside(group, pair.b, all, slack, kCells);
  }
  const Mesh rest = triangles_of(
      pair.a, [&](std::size_t t) { return std::ranges::none_of(regions, [&](const Region& r) { return has(r, t); }); });
  std::vector<Region> of_space;
  std::ranges::remove_copy_if(regions, std::back_inserter(of_space), &Region::is_group);
  return oracle::farthest_outside(rest, pair.b, of_space, slack, kCells);
}

std::string judge(const Bounds& found, bool is_empty, const oracle::RegionBracket& bracket, long double slack) {
  if (!(found.lower <= found.upper)) return "order";
  if (found.lower > bracket.high + slack) return "lower";
  if (bracket.low - slack > found.upper) return "upper";
  if (is_empty && !bracket.may_be_empty) return "empty";
  return "";
}

void print(const Region& region) {
  if (const auto* s = std::get_if<Sphere>(&region.shape))
    return void(
        std::printf("sphere %.17g %.17g %.17g radius %.17g\n", s->centre.x(), s->centre.y(), s->centre.z(), s->radius));
  if (const auto* group = std::get_if<Group>(&region.shape)) {
    for (const TriangleRange& range : group->ranges) std::printf("triangles %u to %u\n", range.first, range.end - 1);
    return;
  }
  const Box& b = std::get<Box>(region.shape);
  std::printf("box %.17g %.17g %.17g to %.17g %.17g %.17g\n", b.low.x(), b.low.y(), b.low.z(), b.high.x(), b.high.y(),
              b.high.z());
}

bool try_pair(std::uint64_t seed, std::uint64_t& narrow, std::uint64_t& intervals) {
  const fuzz::Pair pair = fuzz::generate(seed);
  if (pair.a.triangles.size() * pair.b.triangles.size() > 400) return true;  // the bracket would take too long
  fuzz::Dice dice(seed ^ 0x33333333U);
  const double size = std::max(diagonal(pair.a), diagonal(pair.b));
  const auto largest = [](const Mesh& mesh) {
    const Box box = bounding_box(mesh);
    return std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
  };
  const long double slack = 1e-12L * std::max({size, largest(pair.a), largest(pair.b)});
  double error_a = 0, error_b = 0;
  const double most = size > 1e-100 && size < 1e100 && dice.chance(0.2) ? size * dice.power(-8, -2) : 0;
  const Mesh a = shaken(dice, most, pair.a, error_a), b = shaken(dice, most, pair.b, error_b);
  Options options;
  options.direction = Direction::b_to_a;  // `pair.a` is mesh b, which has the groups
  options.max_work_items = dice.chance(0.1) ? dice.below(4) : 3000;
  options.tolerance = {std::nullopt, dice.power(-5, -2), 0.01};
  for (std::size_t n = 1 + dice.below(3); n > 0; --n) options.regions.push_back(make_region(dice, pair));
  if (dice.chance(0.1)) options.regions[0].max_distance = size * dice.unit();
  Control control;
  if (dice.chance(0.1)) control.cancel_at_check(1 + dice.below(100));
  const Outcome outcome = measure(prepared(b, error_b), prepared(a, error_a), options, control);
  std::string violated;
  for (std::size_t i = 0; i < outcome.regions.size() && violated.empty(); ++i) {
    const RegionOutcome& found = outcome.regions[i];
    const oracle::RegionBracket bracket = bracket_of(pair, options.regions, i, slack);
    violated = judge(*found.b_to_a, found.empty, bracket, slack);
    if (outcome.lower < found.lower || outcome.upper < found.upper) violated = "whole";
    ++intervals;
    narrow += found.stop == Stop::converged || found.stop == Stop::gate_decided ? 1 : 0;
    if (!violated.empty())
      std::printf("VIOLATION of '%s', region %zu, seed %llu: %s\n[%.17g, %.17g] and [%.17Lg, %.17Lg]\n",
                  violated.c_str(), i, static_cast<unsigned long long>(seed), pair.what.c_str(), found.lower,
                  found.upper, bracket.low, bracket.high);
  }
  if (!violated.empty()) {
    std::printf("the measured meshes err by %.17g and %.17g\n", error_a, error_b);
    for (const Region& region : options.regions) print(region);
    fuzz::print_obj(pair.a, "a.obj");
    fuzz::print_obj(pair.b, "b.obj");
  }
  return violated.empty();
}

}  // namespace

bool meshgauge::fuzz::attack_regions(std::uint64_t pairs, std::uint64_t seed) {
  std::uint64_t narrow = 0, intervals = 0;
  for (std::uint64_t i = 0; i < pairs; ++i) {
    if (!try_pair(seed + i, narrow, intervals)) return false;
  }
  std::printf("%llu pairs, %llu intervals, %llu of them as narrow as asked: no violation\n",
              static_cast<unsigned long long>(pairs), static_cast<unsigned long long>(intervals),
              static_cast<unsigned long long>(narrow));
  return true;
}
