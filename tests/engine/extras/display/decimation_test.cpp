#include "engine/extras/display/decimation.h"

#include <algorithm>
#include <chrono>
#include <random>
#include <set>

#include <doctest/doctest.h>

#include "engine/hausdorff.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

// Decimates and checks what holds for every result.
Decimated checked(const Mesh& mesh, std::size_t most, std::span<const std::uint8_t> rank = {}) {
  const auto made = decimated(mesh, {most, rank});
  REQUIRE(made.has_value());
  const Mesh& result = made->mesh;
  CHECK(validate(result, {}, "a").ok());
  CHECK(result.triangles.size() <= most);
  REQUIRE(made->source.size() == result.positions.size());
  for (std::size_t v = 0; v < made->source.size(); ++v) CHECK(mesh.positions[made->source[v]] == result.positions[v]);
  std::set<Triangle> seen;
  std::vector<bool> used(result.positions.size());
  for (Triangle t : result.triangles) {
    for (const std::uint32_t v : t) used[v] = true;
    std::sort(t.begin(), t.end());
    CHECK(seen.insert(t).second);
  }
  CHECK(std::count(used.begin(), used.end(), false) == 0);
  return *made;
}

double distance(const Mesh& a, const Mesh& b) {
  Control control;
  return measure(a, b, {}, control).upper;
}

}  // namespace

TEST_CASE("decimated: most of the budget is used, and the shape stays") {
  const Mesh sphere = shapes::sphere(100);  // 40,000 triangles
  for (const std::size_t most : {20'000U, 5000U, 1000U, 200U}) {
    const Decimated made = checked(sphere, most);
    CHECK(made.mesh.triangles.size() >= most * 6 / 10);
    CHECK(distance(made.mesh, sphere) < 8 / std::sqrt(static_cast<double>(most)));
    CHECK(count_degenerate(made.mesh) == 0);
  }
  const Decimated plane = checked(shapes::grid(300), 10'000);
  CHECK(plane.mesh.triangles.size() >= 6000);
}

TEST_CASE("decimated: a mesh that is small enough gives nullopt") {
  CHECK_FALSE(decimated(shapes::cube(), {12, {}}).has_value());
  CHECK_FALSE(decimated(shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), {1, {}}).has_value());
}

TEST_CASE("decimated: the result always has an area to show") {
  for (const std::size_t most : {1U, 2U, 3U, 7U, 11U}) {
    CHECK(count_degenerate(checked(shapes::cube(), most).mesh) == 0);
    CHECK(count_degenerate(checked(shapes::sphere(20), most).mesh) == 0);
  }
  // One large triangle among many that are smaller than a cell.
  Mesh mesh = shapes::scaled(shapes::sphere(30), 1e-9);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const Decimated made = checked(mesh, 10);
  CHECK(diagonal(made.mesh) == doctest::Approx(diagonal(mesh)));
}

TEST_CASE("decimated: meshes without area, slivers, offsets and extents at their limits") {
  Mesh point{std::vector<Vec3>(30, Vec3(1, 2, 3)), {}};
  for (std::uint32_t t = 0; t < 10; ++t) point.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  checked(point, 4);

  Mesh line;
  for (std::uint32_t v = 0; v < 100; ++v) line.positions.emplace_back(v, 2 * v, 0);
  for (std::uint32_t t = 0; t + 2 < 100; ++t) line.triangles.push_back({t, t + 1, t + 2});
  checked(line, 10);

  std::mt19937_64 random(7);
  const Mesh soup = shapes::soup(4000, random);
  for (const double scale : {0x1p1019, 1.0, 1e-300, 5e-324}) checked(shapes::scaled(soup, scale), 100);
  for (const double offset : {1e9, 1e17, 1e300}) checked(shapes::moved(soup, Vec3::Constant(offset)), 100);
  Mesh flat = soup;
  for (Vec3& p : flat.positions) p.y() *= 1e-15;
  checked(flat, 500);
}

TEST_CASE("decimated: vertices that no triangle uses may be anything") {
  Mesh mesh = shapes::sphere(30);
  mesh.positions.insert(mesh.positions.end(), {Vec3::Constant(NAN), Vec3::Constant(INFINITY), Vec3::Constant(1e9)});
  CHECK(checked(mesh, 1000).mesh.triangles.size() >= 600);
}

TEST_CASE("decimated: the vertex of the highest rank in a cell is kept") {
  const Mesh sphere = shapes::sphere(100);
  std::vector<std::uint8_t> rank(sphere.positions.size(), 0);
  const std::vector<std::uint32_t> wanted{5050, 9000, 12345, 15000};
  for (const std::uint32_t v : wanted) rank[v] = 1;
  const Decimated made = checked(sphere, 2000, rank);
  for (const std::uint32_t v : wanted) {
    CHECK(std::find(made.source.begin(), made.source.end(), v) != made.source.end());
  }
}

namespace {

bool has(const Decimated& made, std::uint32_t vertex) {
  return std::find(made.source.begin(), made.source.end(), vertex) != made.source.end();
}

// Adds a triangle at `where` that is much smaller than any cell.
std::uint32_t add_fleck(Mesh& mesh, const Vec3& where, double size = 1e-4) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {where, where + Vec3(size, 0, 0), where + Vec3(0, size, 0)});
  mesh.triangles.push_back({first, first + 1, first + 2});
  return first;
}

}  // namespace

TEST_CASE("decimated: a loose part smaller than a cell is kept if it has a rank") {
  Mesh mesh = shapes::sphere(100);
  const std::uint32_t fleck = add_fleck(mesh, {1.3, 0, 0});
  std::vector<std::uint8_t> rank(mesh.positions.size(), 0);
  for (const std::size_t most : {20'000U, 5000U, 1000U}) CHECK_FALSE(has(checked(mesh, most, rank), fleck));
  rank[fleck] = 2;
  for (std::size_t most : {39'999U, 20'000U, 5000U, 1000U, 100U, 12U, 3U, 2U, 1U}) {
    CHECK(has(checked(mesh, most, rank), fleck));
  }
}

TEST_CASE("decimated: of many loose parts those of the highest rank are kept, within the budget") {
  Mesh mesh = shapes::sphere(60);
  std::vector<std::uint32_t> flecks;
  for (int i = 0; i < 1000; ++i) flecks.push_back(add_fleck(mesh, Vec3(1.2 + i / 100.0, i % 7, i % 11)));
  std::vector<std::uint8_t> rank(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < flecks.size(); ++i) rank[flecks[i]] = i < 40 ? 2 : 1;
  rank[flecks[777]] = 3;
  for (const std::size_t most : {5000U, 1000U, 400U}) {
    const Decimated made = checked(mesh, most, rank);
    CHECK(has(made, flecks[777]));
    for (std::size_t i = 0; i < 40; ++i) CHECK(has(made, flecks[i]));
    const auto shown = std::count_if(flecks.begin(), flecks.end(), [&](std::uint32_t f) { return has(made, f); });
    CHECK(shown >= static_cast<std::ptrdiff_t>(std::min<std::size_t>(most / 8, flecks.size())));
    CHECK(diagonal(made.mesh) > 2);
  }
}

// A fleck's vertex stands for each of its corners' cells, and these three vertices are on one line.
TEST_CASE("decimated: a vertex whose triangles become flat is kept if it has a rank") {
  Mesh mesh = shapes::grid(40);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {{0, 0.01, 1}, {0.5, 0.02, 1}, {1, 0.01, 1}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  std::vector<std::uint32_t> flecks;
  for (const double x : {0.0, 0.5, 1.0}) flecks.push_back(add_fleck(mesh, {x, 0, 1}));
  std::vector<std::uint8_t> rank(mesh.positions.size(), 0);
  for (const std::uint32_t fleck : flecks) rank[fleck] = 1;
  for (const std::size_t most : {2000U, 500U, 100U}) {
    const Decimated made = checked(mesh, most, rank);
    for (const std::uint32_t fleck : flecks) CHECK(has(made, fleck));
    CHECK(count_degenerate(made.mesh) == 0);
  }
}

TEST_CASE("decimated: the result is deterministic") {
  const Mesh sphere = shapes::sphere(60);
  const Decimated first = checked(sphere, 3000);
  const Decimated second = checked(sphere, 3000);
  CHECK(first.source == second.source);
  CHECK(first.mesh.triangles == second.mesh.triangles);
}

TEST_CASE("decimated: an interruption ends it") {
  const Mesh grid = shapes::grid(300);
  int asked = 0;
  CHECK_FALSE(decimated(grid, {1000, {}}, [&] { return ++asked > 0; }).has_value());
  CHECK(asked < 10);
  int later = 0;
  CHECK_FALSE(decimated(grid, {1000, {}}, [&] { return ++later > 6; }).has_value());
}

TEST_CASE("decimated: a million triangles") {
  const Mesh sphere = shapes::sphere(500);
  const auto start = std::chrono::steady_clock::now();
  const Decimated made = *decimated(sphere, {200'000, {}});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  MESSAGE("1,000,000 triangles to " << made.mesh.triangles.size() << " in " << took.count() << " s");
  CHECK(made.mesh.triangles.size() >= 120'000);
  CHECK(made.mesh.triangles.size() <= 200'000);
}
