// The front of strategy `auto`: pairs of which most is left out before anything is built.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "engine/hausdorff.h"
#include "engine/search/certify.h"
#include "engine/tree/prepared.h"
#include "patient_search.h"
#include "same_outcome.h"
#include "shapes.h"
#include "today.h"

using namespace meshgauge;

namespace {

Options precise(Direction direction = Direction::symmetric) {
  Options options;
  options.direction = direction;
  options.tolerance = {std::nullopt, 1e-7, std::nullopt};
  return options;
}

Outcome measured(const Mesh& a, const Mesh& b, const Options& options) {
  Control control;
  return measure(a, b, options, control);
}

// The same mesh with a bump around `at`, which is sunk for a negative height.
Mesh bumped(Mesh mesh, const Vec3& at, double height) {
  for (Vec3& p : mesh.positions) {
    const double near = std::max(0.0, 1 - (p - at).norm() / 0.3);
    p *= 1 + height * near * near;
  }
  return mesh;
}

Mesh turned(Mesh mesh, double angle) {
  for (Vec3& p : mesh.positions) {
    p = Vec3(std::cos(angle) * p.x() - std::sin(angle) * p.y(), std::sin(angle) * p.x() + std::cos(angle) * p.y(),
             p.z());
  }
  return mesh;
}

// The paper's strategy has no front: it judges what `auto` finds.
void check_against_four_point(const Mesh& a, const Mesh& b, Options options) {
  const Outcome found = measured(a, b, options);
  CHECK(found.stop == Stop::converged);
  options.strategy = Strategy::four_point;
  options.tolerance = {std::nullopt, 1e-5, std::nullopt};
  const Outcome judge = measured(a, b, options);
  CHECK(found.lower <= judge.upper);
  CHECK(judge.lower <= found.upper);
}

struct Kept {
  Mesh mesh_a, mesh_b;
  Prepared a{mesh_a}, b{mesh_b};
  std::size_t bare = a.bytes() + b.bytes();

  Outcome run(const Options& options) const {
    Control control;
    return measure(a, b, options, control);
  }
  // Orders and trees take more than the meshes themselves.
  bool nothing_built() const { return a.bytes() + b.bytes() < bare + bare / 4; }
};

void check_gates(const Mesh& mesh, const Mesh& other, const Outcome& known) {
  for (const double factor : {0.1, 0.5, 0.99, 1.01, 2.0, 10.0}) {
    Options options = precise();
    options.tolerance = {};
    options.max_distance = known.upper * factor;
    const Outcome out = measured(mesh, other, options);
    CHECK(out.stop == Stop::gate_decided);
    CHECK((out.upper <= *options.max_distance) == (factor > 1));
  }
}

}  // namespace

TEST_CASE("front: a mesh that is moved as a whole needs no order and no tree") {
  const Mesh mesh = shapes::sphere(40);
  for (const Vec3& by : {Vec3(1e-4, 0, 0), Vec3(0.03, -0.04, 0), Vec3(0, 0, 0.5), Vec3(3, 4, 0)}) {
    const Kept pair{mesh, shapes::moved(mesh, by)};
    const Outcome out = pair.run(precise());
    CHECK(out.stop == Stop::converged);
    CHECK(out.lower <= by.norm() * (1 + 1e-12));
    CHECK(out.upper >= by.norm() * (1 - 1e-12));
    CHECK(pair.nothing_built());
    REQUIRE(out.a_to_b->bounds.witness);
    const Witness& witness = *out.a_to_b->bounds.witness;
    CHECK((witness.point_a - witness.point_b).norm() == doctest::Approx(by.norm()).epsilon(1e-6));
  }
}

TEST_CASE("front: an identical copy has distance zero exactly, and its witness") {
  const Mesh mesh = shapes::sphere(20);
  const Outcome out = measured(mesh, mesh, precise());
  CHECK(out.upper == 0);
  REQUIRE(out.a_to_b->bounds.witness);
  CHECK(out.a_to_b->bounds.witness->point_a == out.a_to_b->bounds.witness->point_b);
}

TEST_CASE("front: bumps, turns and noise have the distance of the paper's strategy") {
  std::mt19937_64 random(62);
  const Mesh sphere = shapes::sphere(30), grid = shapes::grid(25), soup = shapes::soup(300, random);
  for (const Direction direction : {Direction::a_to_b, Direction::b_to_a, Direction::symmetric}) {
    const Options options = precise(direction);
    check_against_four_point(sphere, bumped(sphere, {1, 0, 0}, 0.1), options);
    check_against_four_point(sphere, bumped(bumped(sphere, {1, 0, 0}, 0.1), {0, 0, -1}, -0.2), options);
    check_against_four_point(grid, turned(grid, 0.01), options);
    check_against_four_point(soup, turned(soup, 0.3), options);
    check_against_four_point(sphere, turned(sphere, 1), options);  // it moves far along itself: the front declines
  }
}

TEST_CASE("front: a bump is found without an order and a tree of the whole mesh") {
  const Mesh mesh = shapes::sphere(60);
  const Kept pair{mesh, bumped(mesh, {0, 1, 0}, 0.1)};
  CHECK(pair.run(precise()).lower > 0.09);
  CHECK(pair.nothing_built());
}

TEST_CASE("front: kept meshes give the bits of new ones, also after their trees were built") {
  const Mesh mesh = shapes::sphere(30), other = bumped(mesh, {0, 1, 0}, 0.1), coarse = shapes::sphere(20);
  const Prepared kept(other, Prepared::Use::often), to_build(coarse);
  Control control;
  (void)measure(to_build, kept, precise(), control);
  for (const Direction direction : {Direction::a_to_b, Direction::b_to_a, Direction::symmetric}) {
    const Outcome again = measure(Prepared(mesh), kept, precise(direction), control);
    CHECK(same_outcome(again, measured(mesh, other, precise(direction))));
  }
}

TEST_CASE("front: gates are decided on the right side") {
  const Mesh mesh = shapes::sphere(30), other = bumped(mesh, {0, 1, 0}, 0.1);
  const Outcome known = measured(mesh, other, precise());
  check_gates(mesh, other, known);
}

TEST_CASE("front: the interval holds after an interruption at any check, with one thread and with two") {
  const Mesh mesh = shapes::sphere(60), other = bumped(mesh, {0, 1, 0}, 0.1);
  const Outcome known = measured(mesh, other, precise());
  for (const unsigned threads : {1U, 2U}) {
    Options options = precise();
    options.threads = threads;
    for (std::uint64_t check = 1; check < 100; ++check) {
      Control control;
      control.cancel_at_check(check);
      const Outcome out = measure(mesh, other, options, control);
      CHECK(out.lower <= known.upper);
      CHECK(known.lower <= out.upper);
    }
  }
}

TEST_CASE("front: meshes that are far from each other need no order and no tree") {
  const Mesh mesh = shapes::sphere(60), other = shapes::sphere(50, 0.7);
  for (const Vec3& by : {Vec3(3, 0, 0), Vec3(0, 8, 1), Vec3(-100, 30, 20), Vec3(0, 0, 1e4)}) {
    const Kept pair{mesh, shapes::moved(other, by)};
    const Outcome out = pair.run(precise(Direction::a_to_b));
    CHECK(out.stop == Stop::converged);
    CHECK(out.lower > by.norm() - 0.1);
    CHECK(out.upper < by.norm() + 0.4);  // the farthest point is 1 from its centre, the nearest 0.7 from the other one
    CHECK(pair.nothing_built());
  }
}

TEST_CASE("front: few triangles that are far from each other need no order and no tree either") {
  const Mesh mesh = shapes::sphere(6), other = shapes::sphere(8, 0.7);
  for (const Vec3& by : {Vec3(3, 0, 0), Vec3(0, 8, 1), Vec3(0, 0, 1e4)}) {
    const Kept pair{mesh, shapes::moved(other, by)};
    const Outcome out = pair.run(precise(Direction::a_to_b));
    CHECK(out.stop == Stop::converged);
    CHECK(pair.nothing_built());
    check_against_four_point(mesh, shapes::moved(other, by), precise(Direction::a_to_b));
  }
}

TEST_CASE("front: far pairs have the distance of the paper's strategy") {
  std::mt19937_64 random(63);
  const Mesh sphere = shapes::sphere(50), soup = shapes::soup(6000, random), grid = shapes::grid(60);
  constexpr Direction kDirections[] = {Direction::a_to_b, Direction::b_to_a, Direction::symmetric};
  CAPTURE(today());
  for (const std::uint64_t direction : todays_part(3, 3)) {
    const Options options = precise(kDirections[direction]);
    check_against_four_point(sphere, shapes::moved(grid, {3, 1, 0}), options);
    check_against_four_point(soup, shapes::moved(sphere, {0, 0, 30}), options);
    check_against_four_point(shapes::scaled(soup, 3), sphere, options);
    check_against_four_point(sphere, shapes::moved(soup, {1.5, 0.5, 0}), options);
    check_against_four_point(shapes::scaled(sphere, 0.01), shapes::scaled(sphere, 5), options);  // far inside
  }
}

TEST_CASE("front: far pairs: gates, kept meshes and interruptions") {
  const Mesh mesh = shapes::sphere(60), other = shapes::moved(shapes::sphere(50, 0.7), {3, 0, 0});
  const Outcome known = measured(mesh, other, precise());
  check_gates(mesh, other, known);
  const Prepared kept(mesh, Prepared::Use::often), to(other);
  for (int i = 0; i < 2; ++i) {
    Control control;
    CHECK(same_outcome(measure(kept, to, precise(), control), known));
  }
  for (std::uint64_t check = 1; check < 120; ++check) {
    Control control;
    control.cancel_at_check(check);
    const Outcome out = measure(mesh, other, precise(), control);
    CHECK(out.lower <= known.upper);
    CHECK(known.lower <= out.upper);
  }
}

TEST_CASE("front: a triangle of which only a vertex is searched is not within what that vertex is") {
  // In triangle 0, vertex v moves farthest, mostly along B; w moves less, and is farther from B.
  constexpr std::uint32_t n = 16, w = 7 * (n + 1) + 7, v = w + 1;
  Mesh b = shapes::moved(shapes::grid(n, n), {-8, -8, 0});
  std::swap(b.triangles[0], b.triangles[2 * (7 * n + 7)]);
  Mesh a = b;
  a.positions[v] += Vec3(0.8, 0, 0.5);
  a.positions[w] += Vec3(0, 0, 0.9);
  constexpr double kLimit = 0.7;
  double area = 0, beyond = 0;
  for (const Triangle& t : a.triangles) {
    std::array<Vec3, 3> p{a.positions[t[0]], a.positions[t[1]], a.positions[t[2]]};
    std::sort(p.begin(), p.end(), [](const Vec3& x, const Vec3& y) { return x.z() > y.z(); });
    const double here = (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2, top = std::max(p[0].z() - kLimit, 0.0);
    area += here;
    if (top > 0) beyond += here * top / (p[0].z() - p[1].z()) * top / (p[0].z() - p[2].z());
  }
  for (const double tolerance : {0.6, 1e-3}) {
    Options options = precise(Direction::a_to_b);
    options.tolerance = {tolerance, std::nullopt, std::nullopt};
    options.areas.emplace().share_tolerance = 1e-6;
    options.areas->beyond.push_back({kLimit, {}});
    const AreaInterval share = measured(a, b, options).areas->a_to_b->beyond[0];
    CHECK(share.lower <= beyond / area);
    CHECK(beyond / area <= share.upper);
  }
}

TEST_CASE("front: unused vertices of any coordinates change nothing") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Mesh mesh = shapes::sphere(20), other = shapes::moved(mesh, {0.1, 0, 0});
  const Outcome known = measured(mesh, other, precise());
  mesh.positions.insert(mesh.positions.end(), {Vec3::Constant(nan), Vec3(-1e9, 0, 0)});
  other.positions.insert(other.positions.end(), {Vec3(-1e9, 0, 0), Vec3::Constant(nan), Vec3::Zero()});
  const Outcome out = measured(mesh, other, precise());
  CHECK(out.lower <= known.upper);
  CHECK(known.lower <= out.upper);
  CHECK(out.stop == Stop::converged);
}

TEST_CASE("front: a certified lower bound never exceeds the reach of a tree that holds a part of B") {
  PatientSearch part(shapes::moved(shapes::cube(1), {5, 0, 0}), shapes::cube(1));
  const Bounds all = Certifier().certify(part.search, Frame{}, never_interrupted);
  REQUIRE(all.lower > 1);
  part.search.set_reach(0.5);
  const Bounds bounds = Certifier().certify(part.search, Frame{}, never_interrupted);
  CHECK(bounds.lower <= 0.5);
  CHECK(bounds.lower > 0.499);
  CHECK(bounds.upper == all.upper);
}
