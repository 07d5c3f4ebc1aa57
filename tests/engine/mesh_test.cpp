#include "engine/mesh.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Error refusal(const Mesh& mesh, const MeshLimits& limits = {}) {
  const auto result = validate(mesh, limits, "a");
  REQUIRE_FALSE(result.ok());
  return result.error();
}

}  // namespace

TEST_CASE("validate names the part, the place and the defect") {
  Mesh mesh = shapes::cube();
  CHECK(validate(mesh, {}, "a").ok());

  mesh.positions[5].y() = kNan;
  CHECK(refusal(mesh).code == ErrorCode::non_finite_vertex);
  CHECK(refusal(mesh).message == "vertex 5 of 'a' is NaN");
  CHECK(refusal(mesh).where == "vertex 5");
  mesh.positions[5].y() = -kInf;
  CHECK(refusal(mesh).message == "vertex 5 of 'a' is infinite");
  mesh.positions[5].y() = 1e308;
  CHECK(refusal(mesh).code == ErrorCode::coordinate_too_large);
  mesh.positions[5].y() = 0;

  mesh.triangles[3][1] = 8;
  CHECK(refusal(mesh).code == ErrorCode::index_out_of_range);
  CHECK(refusal(mesh).message == "triangle 3 of 'a' uses vertex 8 of 8");
  mesh.triangles.clear();
  CHECK(refusal(mesh).code == ErrorCode::empty_mesh);
}

TEST_CASE("validate enforces the limits") {
  CHECK(refusal(shapes::cube(), {7, 100}).code == ErrorCode::too_large);
  CHECK(refusal(shapes::cube(), {100, 11}).code == ErrorCode::too_large);
  CHECK(validate(shapes::cube(), {8, 12}, "a").ok());
}

TEST_CASE("a vertex that no triangle uses is not part of the surface") {
  Mesh mesh = shapes::cube();
  mesh.positions.emplace_back(kNan, 1e300, kInf);
  CHECK(validate(mesh, {}, "a").ok());
  CHECK(diagonal(mesh) == doctest::Approx(std::sqrt(3.0)));
}

TEST_CASE("degenerate triangles are counted") {
  Mesh mesh = shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  CHECK(count_degenerate(mesh) == 0);
  mesh.positions.emplace_back(3, 0, 0);
  mesh.triangles.push_back({0, 1, 3});  // collinear
  mesh.triangles.push_back({0, 0, 2});  // repeated index
  CHECK(count_degenerate(mesh) == 2);
  CHECK(count_degenerate(shapes::scaled(mesh, 1e-200)) == 2);
  CHECK(count_degenerate(shapes::scaled(mesh, 1e200)) == 2);
}

// Edges of a length near 2^300 are beyond the fast test, and a power of two as a factor changes no bit.
TEST_CASE("the fast test of a degenerate triangle never contradicts the full one") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  std::size_t degenerate = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Vec3 a(coordinate(random), coordinate(random), coordinate(random));
    const Vec3 edge(coordinate(random), coordinate(random), coordinate(random));
    const Vec3 off(coordinate(random), coordinate(random), coordinate(random));
    const Vec3 b = a + edge, c = a + coordinate(random) * edge + std::ldexp(1.0, -static_cast<int>(i % 64)) * off;
    const bool found = is_degenerate(a, b, c);
    degenerate += found;
    CHECK(found == is_degenerate(0x1p300 * a, 0x1p300 * b, 0x1p300 * c));
  }
  CHECK(degenerate > 20'000);
  CHECK(degenerate < 100'000);
}

TEST_CASE("the diagonal does not overflow") {
  CHECK(diagonal(shapes::triangle({-1e300, 0, 0}, {1e300, 0, 0}, {0, 0, 0})) == 2e300);
}

// 300,000 triangles and vertices are three blocks, between which `interrupted` is polled twice.
TEST_CASE("a long pass over a mesh ends when it is interrupted") {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 300'000; ++i) {
    mesh.positions.emplace_back(i % 2, i % 3, 0);
    mesh.triangles.push_back({i, 0, 0});
  }
  const std::size_t questions = 2;
  std::size_t asked = 0;
  const Interrupted patient = [&asked] { return ++asked == 0; };
  const Interrupted impatient = [&asked] { return ++asked > 0; };
  CHECK(validate(mesh, {}, "a", patient).ok());
  CHECK(asked == 2 * questions);
  CHECK(count_degenerate(mesh, patient) == 300'000);
  CHECK(asked == 3 * questions);
  CHECK(bounding_box(mesh, patient).high == Vec3(1, 2, 0));  // it goes over the triangles and over the vertices
  CHECK(asked == 5 * questions);

  const auto stopped = validate(mesh, {}, "a", impatient);
  REQUIRE(!stopped.ok());
  CHECK(stopped.error().code == ErrorCode::out_of_time);
  CHECK(stopped.error().message == "interrupted before 'a' was checked");
  const std::size_t counted = count_degenerate(mesh, impatient);
  CHECK(counted > 0);
  CHECK(counted < 300'000);
  mesh.positions.front().z() = -1;  // used by the first block
  mesh.positions.back().z() = 1;    // used by the last block only
  CHECK(bounding_box(mesh, impatient).high.z() == 0);

  mesh.positions.back().z() = kNan;
  asked = 0;
  CHECK(validate(mesh, {}, "a", patient).error().message == "vertex 299999 of 'a' is NaN");
  CHECK(asked == 3 * questions);
}
