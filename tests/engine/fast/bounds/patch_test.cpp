#include "engine/fast/bounds/patch.h"

#include <doctest/doctest.h>

#include <numeric>

#include "engine/rounding.h"
#include "engine/thresholds.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

// B with what the certificate needs.
struct Ground {
  explicit Ground(const Mesh& b, const Kernels& kernels = *find_kernels("auto"))
      : mesh(b),
        tree(tree_of(mesh, kernels)),
        adjacency(mesh, pool),
        patch(tree, adjacency, Thresholds{}.patch_group) {}
  Ground(const Ground&) = delete;
  Ground& operator=(const Ground&) = delete;

  std::span<const Patch::Bound> bounds(const Mesh& a, double limit) {
    std::vector<std::uint32_t> all(a.triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    Work work;
    return patch.attempt(a, all, limit, work);
  }

  Mesh mesh;
  Bvh tree;
  ThreadPool pool{1};
  Adjacency adjacency;
  Patch patch;
};

bool failed(const Patch::Bound& bound) { return bound.upper == std::numeric_limits<double>::infinity(); }

std::size_t bounded(std::span<const Patch::Bound> bounds) {
  return bounds.size() - static_cast<std::size_t>(std::count_if(bounds.begin(), bounds.end(), failed));
}

// Four triangles, because fewer are not tried: copies of one.
Mesh four_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mesh mesh = shapes::triangle(a, b, c);
  mesh.triangles.resize(4, mesh.triangles[0]);
  return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (Triangle t : other.triangles) {
    for (std::uint32_t& v : t) v += first;
    mesh.triangles.push_back(t);
  }
}

// Returns the number of bounded triangles. No sample of one may exceed its bound.
std::size_t check(const Mesh& a, const Mesh& b, double limit, std::mt19937_64& random) {
  Ground ground(b);
  const auto bounds = ground.bounds(a, limit);
  const MeshView from(a);
  std::uniform_real_distribution<double> uniform(0, 1);
  Work work;
  for (std::size_t t = 0; t < bounds.size(); ++t) {
    if (failed(bounds[t])) continue;
    REQUIRE(bounds[t].upper <= limit);
    for (int i = 0; i < 30; ++i) {
      double u = uniform(random), v = uniform(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 x = (1 - u - v) * from.corner(t, 0) + u * from.corner(t, 1) + v * from.corner(t, 2);
      const double d = nearest_corner(ground.tree, x, work).distance;
      REQUIRE(d <= bounds[t].upper + rounding::kDistanceSlack + ground.tree.residual());
    }
  }
  return bounded(bounds);
}

// A sheet over the unit square with random heights, turned as a whole if `turned`.
Mesh sheet(std::uint32_t n, double height, std::mt19937_64& random, bool turned = false) {
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  Mesh mesh = shapes::grid(n);
  for (Vec3& p : mesh.positions) p.z() = height * uniform(random);
  for (Triangle& t : mesh.triangles) {
    if (turned) std::swap(t[0], t[1]);
  }
  return mesh;
}

// A sheet with some triangles missing, some turned, some doubled, some with a fin, and its vertices moved sideways by
// up to `fold` of an edge.
Mesh spoilt(std::uint32_t n, double height, double fold, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Mesh mesh = sheet(n, height, random, uniform(random) < 0.3);
  for (Vec3& p : mesh.positions) {
    p.x() += fold * (uniform(random) - 0.5) / n;
    p.y() += fold * (uniform(random) - 0.5) / n;
  }
  Mesh out{mesh.positions, {}};
  for (Triangle t : mesh.triangles) {
    const double what = uniform(random);
    if (what < 0.04) continue;
    if (what < 0.08) std::swap(t[0], t[1]);
    out.triangles.push_back(t);
    if (what > 0.97) out.triangles.push_back(t);
    if (what > 0.94 && what < 0.97) {
      out.positions.push_back(mesh.positions[t[0]] + Vec3(0.02, 0.01, height));
      out.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(out.positions.size() - 1)});
    }
  }
  if (out.triangles.empty()) out.triangles.push_back(mesh.triangles[0]);
  return uniform(random) < 0.5 ? shapes::unwelded(out) : out;
}

const Mesh kFlat = shapes::grid(4);
const Vec3 kA(0.3, 0.3, 0.01), kB(0.72, 0.34, 0.02), kC(0.36, 0.7, 0.03);  // over the middle of kFlat

}  // namespace

TEST_CASE("no sample exceeds the patch certificate: sheets with holes, folds, fins, doubled and turned triangles") {
  std::mt19937_64 random(31);
  std::size_t tried = 0, done = 0;
  for (int round = 0; round < 150; ++round) {
    for (const double height : {0.0, 0.01, 0.3}) {
      for (const double fold : {0.0, 1.0, 3.0}) {
        const auto n = static_cast<std::uint32_t>(2 + random() % 9), m = static_cast<std::uint32_t>(2 + random() % 9);
        const Mesh a = sheet(n, height / 2, random), b = spoilt(m, height, fold, random);
        const double limit = std::pow(10.0, -3 * std::uniform_real_distribution<double>(0, 1)(random));
        tried += a.triangles.size();
        done += check(a, b, limit, random);
      }
    }
  }
  CHECK(done > tried / 10);  // it succeeds often enough to be a test
}

TEST_CASE("no sample exceeds the patch certificate: two layers, closed shapes and soups") {
  std::mt19937_64 random(32);
  std::size_t done = 0;
  for (int round = 0; round < 60; ++round) {
    Mesh layers = spoilt(5, 0.02, 0.5, random);
    append(layers, shapes::moved(spoilt(5, 0.02, 0.5, random), {0, 0, 0.05}));
    done += check(shapes::moved(sheet(7, 0.02, random), {0, 0, 0.02}), layers, 0.1, random);
    done += check(shapes::sphere(9, 0.5), shapes::sphere(7, 0.49), 0.1, random);
    done += check(shapes::sphere(12, 0.5), shapes::cube(0.8, {-0.4, -0.4, -0.4}), 0.3, random);
    check(sheet(6, 0.1, random), shapes::soup(60, random), 0.2, random);
  }
  CHECK(done > 1000);
}

TEST_CASE("patch: a plane cut into other triangles is bounded by rounding alone") {
  for (const bool welded : {true, false}) {
    Ground ground(welded ? kFlat : shapes::unwelded(kFlat));
    const auto bounds = ground.bounds(four_of({0.1, 0.1, 0}, {0.9, 0.2, 0}, {0.3, 0.8, 0}), 1e-9);
    CHECK(bounded(bounds) == 4);
    CHECK(bounds[0].upper < 1e-11);
    CHECK(bounds[0].upper >= 128 * rounding::kUnit);
  }
}

TEST_CASE("patch: the bound is the largest difference of height") {
  Ground ground(kFlat);
  const auto bounds = ground.bounds(four_of(kA, kB, kC), 0.031);
  REQUIRE(bounded(bounds) == 4);
  CHECK(bounds[0].upper >= 0.03);
  CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.029)) == 0);
}

TEST_CASE("patch: a triangle over the border fails") {
  Ground ground(kFlat);
  CHECK(bounded(ground.bounds(four_of({0.3, 0.3, 0}, {1.05, 0.4, 0}, {0.3, 0.7, 0}), 0.01)) == 0);
  CHECK(bounded(ground.bounds(four_of({2.3, 0.3, 0}, {2.5, 0.4, 0}, {2.3, 0.7, 0}), 0.01)) == 0);
}

TEST_CASE("patch: a triangle over a hole fails, one beside it does not") {
  Mesh holed = kFlat;
  holed.triangles.erase(holed.triangles.begin() + 10);  // in [0.25, 0.5] x [0.25, 0.5]
  Ground ground(holed);
  CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.1)) == 0);
  CHECK(bounded(ground.bounds(four_of({0.6, 0.1, 0}, {0.9, 0.2, 0}, {0.7, 0.9, 0}), 0.1)) == 4);
}

TEST_CASE("patch: a triangle inside of one hole fails although no edge meets it") {
  Ground ground(shapes::grid(1));
  CHECK(bounded(ground.bounds(four_of({1.1, 0.2, 0}, {1.3, 0.3, 0}, {1.2, 0.5, 0}), 0.5)) == 0);
}

TEST_CASE("patch: a triangle over a turned triangle of B fails") {
  Mesh turned = kFlat;
  std::swap(turned.triangles[10][0], turned.triangles[10][1]);
  Ground ground(turned);
  CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.1)) == 0);
}

TEST_CASE("patch: B may be turned as a whole") {
  Mesh turned = kFlat;
  for (Triangle& t : turned.triangles) std::swap(t[0], t[1]);
  Ground ground(turned);
  CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.1)) == 4);
}

TEST_CASE("patch: a third triangle at an edge opens it") {
  Mesh fin = kFlat;
  fin.positions.emplace_back(0.5, 0.5, 1);
  fin.triangles.push_back({fin.triangles[10][0], fin.triangles[10][2], 25});
  Ground ground(fin);
  CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.1)) == 0);
  CHECK(bounded(ground.bounds(four_of({0.6, 0.1, 0}, {0.9, 0.2, 0}, {0.7, 0.9, 0}), 0.1)) == 4);
}

TEST_CASE("patch: two triangles that run along an edge in the same direction leave it open") {
  // The square [0,1]^2 in the plane, and a second triangle on the same side of its diagonal, far below elsewhere.
  const Mesh book{{{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 1, -5}}, {{0, 1, 2}, {0, 1, 3}}};
  Ground ground(shapes::scaled(book, 0.2));
  CHECK(bounded(ground.bounds(four_of({0.06, 0.08, 0}, {0.12, 0.1, 0}, {0.06, 0.14, 0}), 0.1)) == 0);
}

TEST_CASE("patch: a fold over the triangle fails") {
  Mesh folded = kFlat;
  for (Vec3& p : folded.positions) {
    if (p.x() > 0.5) p = {1 - p.x(), p.y(), 0.01};  // the right half lies over the left
  }
  Ground ground(folded);
  CHECK(bounded(ground.bounds(four_of({0.3, 0.3, 0}, {0.6, 0.35, 0}, {0.3, 0.7, 0}), 0.1)) == 0);
  CHECK(bounded(ground.bounds(four_of({0.1, 0.3, 0}, {0.4, 0.35, 0}, {0.1, 0.7, 0}), 0.1)) == 4);
}

TEST_CASE("patch: a second sheet counts only if it is within the limit") {
  for (const double height : {0.05, 0.2}) {
    Mesh two = kFlat;
    append(two, shapes::moved(shapes::grid(1, 0.5), {0, 0, height}));  // its border runs over the triangle
    Ground ground(two);
    CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.1)) == (height > 0.1 ? 4 : 0));
  }
}

TEST_CASE("patch: a step of B that is higher than the limit fails") {
  Mesh step = kFlat;
  for (Vec3& p : step.positions) {
    if (p.x() > 0.6) p.z() = -0.3;
  }
  Ground ground(step);
  CHECK(bounded(ground.bounds(four_of(kA, kB, kC), 0.1)) == 0);
  CHECK(bounded(ground.bounds(four_of({0.1, 0.1, 0}, {0.45, 0.2, 0}, {0.2, 0.9, 0}), 0.1)) == 4);
}

TEST_CASE("patch: degenerate triangles fail, and do not disturb the others") {
  Mesh a = shapes::moved(shapes::scaled(shapes::grid(3), 0.4), {0.3, 0.3, 0.01});
  a.triangles.push_back({0, 0, 5});
  a.triangles.push_back({0, 1, 2});  // collinear
  Mesh b = kFlat;
  b.triangles.push_back({3, 3, 7});
  b.triangles.push_back({1, 1, 1});
  Ground ground(b);
  const auto bounds = ground.bounds(a, 0.1);
  CHECK(bounded(bounds) == a.triangles.size() - 2);
  CHECK(failed(bounds[a.triangles.size() - 1]));
  CHECK(failed(bounds[a.triangles.size() - 2]));
}

TEST_CASE("patch: every instruction set gives the same bits") {
  std::mt19937_64 random(33);
  for (int round = 0; round < 20; ++round) {
    const Mesh a = sheet(9, 0.05, random), b = spoilt(8, 0.1, 1, random);
    std::vector<double> expected;
    for (const Kernels& kernels : supported_kernels()) {
      Ground ground(b, kernels);
      std::vector<double> uppers;
      for (const Patch::Bound& bound : ground.bounds(a, 0.2)) uppers.push_back(bound.upper);
      if (expected.empty()) expected = uppers;
      CHECK(uppers == expected);
    }
  }
}
