#include "engine/tree/nearest.h"

#include <doctest/doctest.h>

#include "engine/rounding.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

void check_queries(const Mesh& mesh, const Kernels& kernels, int queries, std::mt19937_64& random) {
  const Bvh tree = tree_of(mesh, kernels);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < queries; ++i) {
    Vec3 p(uniform(random), uniform(random), uniform(random));
    if (i % 3 == 0) p = mesh.positions[static_cast<std::size_t>(i) % mesh.positions.size()];
    double brute = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      brute = std::min(brute, distance(tree.prepared(t), p));
    }
    std::uint64_t tests = 0;
    const Nearest found = nearest(tree, p, tests);
    REQUIRE(found.known());
    CHECK(found.distance == doctest::Approx(brute).epsilon(1e-15));
    CHECK(found.distance == distance(tree.prepared(found.slot), p));
    CHECK(tests > 0);

    const double below = certified_distance_below(tree, p).value();
    CHECK(below <= brute);
    CHECK(below >= brute - 2 * rounding::kSeparationSlack);
  }
}

}  // namespace

TEST_CASE("nearest and its certified lower bound agree with brute force") {
  std::mt19937_64 random(4);
  for (const Kernels& kernels : supported_kernels()) {
    check_queries(shapes::sphere(12, 0.8), kernels, 300, random);
    check_queries(shapes::soup(200, random), kernels, 300, random);
    check_queries(shapes::cube(0.5), kernels, 300, random);
    check_queries(shapes::triangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0}), kernels, 10, random);
    check_queries(shapes::triangle({0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}), kernels, 300, random);
  }
}

TEST_CASE("a query ends where it is near enough, and else finds the nearest") {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Bvh tree = tree_of(shapes::sphere(60, 0.8));
  std::uint64_t all_tests = 0, fewer_tests = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    const double enough = 0.3 * uniform(random);
    const Nearest exact = nearest(tree, p, all_tests);
    const Nearest found = nearest(tree, p, fewer_tests, Nearest::kNone, nullptr, enough);
    CHECK(found.distance >= exact.distance);
    CHECK((found.distance <= enough || found.distance == exact.distance));
    CHECK(found.complete);
  }
  CHECK(fewer_tests < all_tests);
}

TEST_CASE("a query from any distance tests only some of the triangles") {
  for (const double size : {1.0, 1e-2, 1e-4, 1e-6}) {
    const Mesh mesh = shapes::moved(shapes::scaled(shapes::sphere(100), size / 4), {0.7, 0.7, 0.7});
    const Bvh tree = tree_of(mesh);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1, 0);
    for (const Kernels& kernels : supported_kernels()) {
      std::uint64_t tests = 0;
      Polling never;
      for (int i = 0; i < 100; ++i) {
        const Vec3 p(uniform(random), uniform(random), uniform(random));
        kernels.nearest(tree.view(), p.data(), {std::numeric_limits<double>::infinity(), Nearest::kNone}, tests, never);
      }
      CHECK(tests < 100 * 2000);  // of 40,000 triangles, all about as far
    }
  }
}
