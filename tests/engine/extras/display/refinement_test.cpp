#include "engine/extras/display/refinement.h"

#include <algorithm>
#include <map>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "engine/hausdorff.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

double longest_edge(const Mesh& mesh) {
  double longest = 0;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      longest = std::max(longest, (mesh.positions[t[i]] - mesh.positions[t[(i + 1) % 3]]).norm());
    }
  }
  return longest;
}

// Twice the area as a vector. It is 0 for a closed surface, and changes if a triangle is turned over.
Vec3 area_of(const Mesh& mesh) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const MeshView view(mesh);
    sum += (view.corner(t, 1) - view.corner(t, 0)).cross(view.corner(t, 2) - view.corner(t, 0));
  }
  return sum;
}

// The number of edges that only one triangle has.
std::size_t borders(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[std::minmax(t[i], t[(i + 1) % 3])];
  }
  return static_cast<std::size_t>(
      std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second == 1; }));
}

}  // namespace

TEST_CASE("refined: no edge is too long, no crack opens, and the surface is the same") {
  for (const double longest : {0.7, 0.3, 0.11}) {
    const auto cube = refined(shapes::cube(), {longest, 100'000});
    REQUIRE(cube.has_value());
    CHECK(longest_edge(*cube) <= longest);
    CHECK(borders(*cube) == 0);
    Control control;
    Options options;
    options.tolerance = {1e-9, std::nullopt, std::nullopt};
    CHECK(measure(*cube, shapes::cube(), options, control).upper < 1e-8);

    const Mesh slivers = shapes::scaled(shapes::triangle({0, 0, 0}, {3, 0, 0}, {2.9, 0.01, 0}), 1);
    const auto split = refined(slivers, {longest, 100'000});
    REQUIRE(split.has_value());
    CHECK((area_of(*split) - area_of(slivers)).norm() < 1e-12);
  }
}

TEST_CASE("refined: the given vertices keep their numbers, and short edges stay") {
  const Mesh grid = shapes::grid(4);
  CHECK_FALSE(refined(grid, {0.5, 1000}).has_value());
  Mesh mixed = grid;
  mixed.positions.insert(mixed.positions.end(), {{0, 0, 1}, {5, 0, 1}, {0, 0.1, 1}});
  mixed.triangles.push_back({25, 26, 27});
  const auto result = refined(mixed, {0.5, 1000});
  REQUIRE(result.has_value());
  CHECK(std::equal(mixed.positions.begin(), mixed.positions.end(), result->positions.begin()));
  CHECK(std::equal(grid.triangles.begin(), grid.triangles.end(), result->triangles.begin()));
  CHECK(longest_edge(*result) <= 0.5);
  CHECK(validate(*result, {}, "a").ok());
}

TEST_CASE("refined: there are at most max_triangles, and the longest edges are split first") {
  CHECK_FALSE(refined(shapes::cube(), {0.01, 12}).has_value());
  for (const std::size_t most : {60U, 500U, 4000U}) {
    const auto some = refined(shapes::cube(), {1e-9, most});
    REQUIRE(some.has_value());
    CHECK(some->triangles.size() <= most);
    CHECK(some->triangles.size() > most / 8);
    CHECK(borders(*some) == 0);
  }
  const auto nothing_is_short_enough = refined(shapes::cube(), {0, 100});
  REQUIRE(nothing_is_short_enough.has_value());
  CHECK(nothing_is_short_enough->triangles.size() <= 100);
}

TEST_CASE("refined: an interruption returns the mesh reached so far") {
  int asked = 0;
  const auto result = refined(shapes::cube(), {0.01, 1'000'000}, [&asked] { return ++asked > 2; });
  REQUIRE(result.has_value());
  CHECK(result->triangles.size() < 200);
  CHECK(borders(*result) == 0);
  CHECK_FALSE(refined(shapes::cube(), {0.01, 1'000'000}, [] { return true; }).has_value());
}
