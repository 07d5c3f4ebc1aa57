// Topology and volume against brute force, exact arithmetic and closed forms.
#include "engine/mesh/topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include <doctest/doctest.h>

#include "oracle/dyadic.h"
#include "shapes.h"

using namespace meshgauge;
using oracle::Dyadic;

namespace {

Topology topology_of(const Mesh& mesh) { return topology(mesh, bounding_box(mesh)).value(); }

using Place = std::array<double, 3>;
Place place(const Vec3& p) { return {p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}; }

// Counts by maps of positions.
struct Counts {
  std::size_t edges = 0, open = 0, non_manifold = 0, flipped = 0, components = 0, vertices = 0, triangles = 0;
};

Counts counted(const Mesh& mesh) {
  Counts counts;
  std::map<std::pair<Place, Place>, std::array<std::size_t, 2>> edges;
  std::map<Place, std::set<Place>> beside;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto corner = [&](std::uint32_t i) { return place(mesh.positions[mesh.triangles[t][i % 3]]); };
    if (corner(0) == corner(1) || corner(1) == corner(2) || corner(2) == corner(0)) continue;
    ++counts.triangles;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const Place a = corner(i), b = corner(i + 1);
      ++edges[{std::min(a, b), std::max(a, b)}][a < b];
      beside[a].insert(b), beside[b].insert(a);
    }
  }
  counts.edges = edges.size();
  for (const auto& [ends, passes] : edges) {
    counts.open += passes[0] + passes[1] == 1;
    counts.non_manifold += passes[0] + passes[1] > 2;
    counts.flipped += passes[0] > 1 || passes[1] > 1;
  }
  counts.vertices = beside.size();
  std::set<Place> seen;
  const std::function<void(const Place&)> visit = [&](const Place& p) {
    if (!seen.insert(p).second) return;
    for (const Place& q : beside[p]) visit(q);
  };
  for (const auto& [p, others] : beside) {
    counts.components += !seen.contains(p);
    visit(p);
  }
  return counts;
}

Dyadic six_volumes(const Mesh& mesh) {
  Dyadic sum;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<Dyadic, 3>, 3> m;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) m[i][k] = mesh.positions[t[i]][static_cast<Eigen::Index>(k)];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
      sum = sum + m[0][k] * (m[1][l] * m[2][n] - m[1][n] * m[2][l]);
    }
  }
  return sum;
}

void check_against_exact(const Mesh& mesh) {
  const Topology found = topology_of(mesh);
  const Counts exact = counted(mesh);
  CHECK(found.edges == exact.edges);
  CHECK(found.open.count == exact.open);
  CHECK(found.non_manifold.count == exact.non_manifold);
  CHECK(found.flipped.count == exact.flipped);
  CHECK(found.components == exact.components);
  CHECK(found.euler_characteristic ==
        static_cast<std::int64_t>(exact.vertices + exact.triangles) - static_cast<std::int64_t>(exact.edges));
  REQUIRE(found.volume.has_value() == (exact.edges > 0 && exact.open + exact.non_manifold + exact.flipped == 0));
  if (!found.volume) return;
  const Dyadic six = six_volumes(mesh);
  if (std::isfinite(found.volume->lower)) CHECK(Dyadic(6) * Dyadic(found.volume->lower) <= six);
  if (std::isfinite(found.volume->upper)) CHECK(six <= Dyadic(6) * Dyadic(found.volume->upper));
}

bool holds(const std::optional<Volume>& volume, double value, double width) {
  return volume && volume->lower <= value && value <= volume->upper && volume->upper - volume->lower <= width;
}

Mesh random_of(std::mt19937_64& random, const Mesh& shape) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double size = std::ldexp(1.0, static_cast<int>(random() % 60) - 30), far = random() % 2 ? 0 : 1000 * size;
  std::map<Place, Vec3> to;  // one image for each position
  Mesh mesh = shape;
  for (Vec3& p : mesh.positions) {
    const auto [image, is_new] = to.try_emplace(place(p), Vec3::Zero());
    if (is_new) image->second = Vec3(far, -far, far) + size * Vec3(uniform(random), uniform(random), uniform(random));
    p = image->second;
  }
  return random() % 2 ? shapes::unwelded(mesh) : mesh;
}

}  // namespace

TEST_CASE("topology: cubes, tetrahedra and spheres have their closed forms") {
  const Topology cube = topology_of(shapes::cube(2, {5, 6, 7}));
  CHECK(cube.watertight());
  CHECK(cube.oriented());
  CHECK(cube.edges == 18);
  CHECK(cube.components == 1);
  CHECK(cube.euler_characteristic == 2);
  CHECK(holds(cube.volume, 8, 1e-10));
  CHECK(holds(topology_of(shapes::turned(shapes::cube(2))).volume, -8, 1e-10));
  CHECK(holds(topology_of(shapes::unwelded(shapes::cube(3))).volume, 27, 1e-9));
  const Mesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  CHECK(holds(topology_of(tetrahedron).volume, 1.0 / 6, 1e-10));
  const Topology ball = topology_of(shapes::closed_sphere(40));  // with collapsed triangles at the poles
  CHECK(ball.watertight());
  CHECK(ball.euler_characteristic == 2);
  CHECK(ball.volume->upper < 4.0 / 3 * std::acos(-1.0));
  CHECK(ball.volume->lower > 0.99 * 4.0 / 3 * std::acos(-1.0));
}

TEST_CASE("topology: an open box names its first open edge") {
  Mesh box = shapes::cube();
  box.triangles.erase(box.triangles.begin() + 2, box.triangles.begin() + 4);  // the face z = 1
  const Topology found = topology_of(box);
  CHECK(found.open.count == 4);
  CHECK(found.open.first.z() == 1);
  CHECK((found.open.first.x() == 0.5) != (found.open.first.y() == 0.5));
  CHECK(!found.watertight());
  CHECK(found.oriented());
  CHECK(found.euler_characteristic == 1);
  CHECK(!found.volume);
}

TEST_CASE("topology: a Moebius strip is not oriented, and a turned triangle is seen") {
  constexpr std::uint32_t kAround = 12;
  Mesh strip;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const double angle = 2 * std::acos(-1.0) * i / kAround;
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    const Vec3 across = std::cos(angle / 2) * out + std::sin(angle / 2) * Vec3(0, 0, 1);
    strip.positions.push_back(3 * out - across);
    strip.positions.push_back(3 * out + across);
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const bool last = i + 1 == kAround;  // the ends are joined the other way round
    const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    strip.triangles.insert(strip.triangles.end(), {{a, b, c}, {b, d, c}});
  }
  const Topology found = topology_of(strip);
  CHECK(found.open.count == 2 * kAround);
  CHECK(found.flipped.count == 1);
  CHECK(!found.oriented());
  CHECK(found.components == 1);
  CHECK(found.euler_characteristic == 0);

  Mesh cube = shapes::cube();
  std::swap(cube.triangles[0][1], cube.triangles[0][2]);
  CHECK(topology_of(cube).watertight());
  CHECK(topology_of(cube).flipped.count == 3);
  CHECK(!topology_of(cube).volume);
}

TEST_CASE("topology: two shells, a touching vertex, a cavity, duplicated and collapsed triangles") {
  const Topology two = topology_of(shapes::joined(shapes::cube(), shapes::cube(1, {3, 0, 0})));
  CHECK(two.components == 2);
  CHECK(holds(two.volume, 2, 1e-11));
  CHECK(topology_of(shapes::joined(shapes::cube(), shapes::cube(1, {1, 1, 1}))).components == 1);  // share a corner
  const Topology hollow = topology_of(shapes::joined(shapes::cube(4), shapes::turned(shapes::cube(1, {1, 1, 1}))));
  CHECK(hollow.watertight());
  CHECK(holds(hollow.volume, 63, 1e-9));
  const Topology beside = topology_of(shapes::joined(shapes::cube(), shapes::cube(1, {1, 1, 0})));  // share an edge
  CHECK(beside.non_manifold.count == 1);
  CHECK(!beside.watertight());
  Mesh doubled = shapes::cube();
  doubled.triangles.push_back(doubled.triangles[0]);
  CHECK(topology_of(doubled).non_manifold.count == 3);
  Mesh fin = shapes::cube();
  fin.triangles.push_back({0, 1, 0});
  CHECK(topology_of(fin).watertight());
  CHECK(topology_of(Mesh{{{1, 2, 3}, {4, 5, 6}}, {{0, 0, 1}, {1, 1, 1}}}).edges == 0);
  CHECK(!topology_of(Mesh{{{1, 2, 3}, {4, 5, 6}}, {{0, 0, 1}, {1, 1, 1}}}).watertight());
}

TEST_CASE("topology: minus zero is zero, and a vertex that no triangle uses may be NaN") {
  Mesh cube = shapes::unwelded(shapes::cube());
  for (std::size_t i = 0; i < cube.positions.size(); i += 2) cube.positions[i] = -(-cube.positions[i] - Vec3::Zero());
  CHECK(topology_of(cube).watertight());
  cube.positions.resize(200'000, Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  CHECK(topology_of(cube).watertight());
}

TEST_CASE("topology: counts and volumes of random meshes hold the exact ones") {
  std::mt19937_64 random(17);
  for (int i = 0; i < 300; ++i) {
    CAPTURE(i);
    const Mesh cubes = shapes::joined(shapes::cube(), shapes::cube(1, {i % 2 + 1.0, 0, 3}));
    Mesh mesh = random_of(random, i % 3 == 0 ? shapes::closed_sphere(4) : cubes);
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    check_against_exact(mesh);
    if (random() % 2) std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
    if (random() % 2) mesh.triangles.push_back(mesh.triangles[1]);
    if (random() % 2) mesh.triangles.pop_back();
    check_against_exact(mesh);
  }
  for (int i = 0; i < 200; ++i) {  // triangles between a few places of a grid: all kinds of edges
    CAPTURE(i);
    Mesh mesh;
    for (std::uint32_t v = 0; v < 30; ++v) {
      const auto at = [&] { return static_cast<double>(random() % 3); };
      mesh.positions.emplace_back(at(), at(), at());
    }
    const auto vertex = [&] { return static_cast<std::uint32_t>(random() % 30); };
    for (std::size_t t = random() % 60 + 1; t > 0; --t) mesh.triangles.push_back({vertex(), vertex(), vertex()});
    check_against_exact(mesh);
  }
}

TEST_CASE("topology: the smallest, the largest and the flattest coordinates") {
  const double least = std::numeric_limits<double>::denorm_min();
  for (const double size : {least, 3 * least, 0x1p-1000, 0x1p-400, 0x1p-330, 0x1p300, 0x1p341, 0x1p1019}) {
    CAPTURE(size);
    check_against_exact(shapes::cube(size));
    check_against_exact(shapes::cube(size, Vec3::Constant(-size / 2)));
  }
  CHECK(topology_of(shapes::cube(0x1p1019)).volume->upper == std::numeric_limits<double>::infinity());
  CHECK(topology_of(shapes::cube(0x1p1019)).volume->lower == std::numeric_limits<double>::max());
  Mesh flat = shapes::cube(1, {1e9, 1e9, 0});
  for (Vec3& p : flat.positions) p.z() *= 1e-300;
  check_against_exact(flat);
  CHECK(topology_of(flat).volume->lower <= 1e-300);
}

TEST_CASE("topology: a volume in another unit holds the exact one") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Factor factor : {Factor{1, 1}, Factor{127, 5}, Factor{5, 127}, Factor{304800, 1}, Factor{1, 304800}}) {
    const Dyadic over = factor.over, times = factor.times;
    for (int i = 0; i < 100; ++i) {
      const double x = uniform(random);
      Topology given;
      given.open.first = {x, 2 * x, 0};
      given.volume = Volume{x, x};
      const Topology image = scaled(given, factor);
      const Volume volume = image.volume.value();
      CHECK(image.open.first.isApprox(given.open.first * factor.times / factor.over));
      const Dyadic exact = Dyadic(x) * times * times * times, cube = over * over * over;
      CHECK(Dyadic(volume.lower) * cube <= exact);
      CHECK(exact <= Dyadic(volume.upper) * cube);
      CHECK(volume.upper - volume.lower <= 1e-14 * std::abs(volume.upper));
    }
  }
}

TEST_CASE("topology: ends soon after an interruption") {
  const Mesh mesh = shapes::grid(300);
  std::size_t asked = 0;
  CHECK(topology(mesh, bounding_box(mesh), [&] { return ++asked, false; }));
  CHECK(asked > 40);
  for (std::size_t last = 1; last <= asked; ++last) {
    std::size_t so_far = 0;
    CHECK(!topology(mesh, bounding_box(mesh), [&] { return ++so_far >= last; }));
    CHECK(so_far == last);
  }
}
