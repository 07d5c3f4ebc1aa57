#include "engine/twins.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "shapes.h"

using namespace meshgauge;

namespace {

OrderedMesh ordered(const Mesh& mesh) {
  Control control;
  Crew crew(1);
  return {mesh, bounding_box(mesh), Frame{}, control, crew};
}

// The same triangles, in another order and each beginning at another corner, some turned over.
Mesh stirred(Mesh mesh, std::mt19937_64& random) {
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  for (Triangle& t : mesh.triangles) std::shuffle(t.begin(), t.end(), random);
  return mesh;
}

}  // namespace

TEST_CASE("twins by number follow the numbers, whatever the order in memory") {
  std::mt19937_64 random(71);
  const Mesh mesh = shapes::sphere(20);
  const OrderedMesh a = ordered(mesh), b = ordered(shapes::moved(shapes::scaled(mesh, 0.4), {0.2, 0, 0.1}));
  const auto twins = twins_by_number(a, b);
  REQUIRE(twins.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < twins.size(); ++t) CHECK(b.original[twins[t]] == a.original[t]);
}

TEST_CASE("twins by number: fewer on the other side, and far fewer") {
  Mesh mesh = shapes::sphere(20);
  const OrderedMesh a = ordered(mesh);
  mesh.triangles.resize(mesh.triangles.size() - 100);
  const auto twins = twins_by_number(a, ordered(mesh));
  CHECK(std::count(twins.begin(), twins.end(), kNoTwin) == 100);
  mesh.triangles.resize(50);
  CHECK(twins_by_number(a, ordered(mesh)).empty());
  CHECK(twins_by_number(ordered(mesh), a).empty());
}

TEST_CASE("twins by position are the same triangles, stirred and in part, and nothing else") {
  std::mt19937_64 random(72);
  for (const Mesh& mesh : {shapes::sphere(20), shapes::soup(400, random), shapes::grid(10)}) {
    Mesh part = stirred(mesh, random);
    part.triangles.resize(part.triangles.size() / 2);
    const OrderedMesh a = ordered(mesh), b = ordered(part);
    const auto twins = twins_by_position(a, b);
    std::size_t found = 0;
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
      if (twins[t] == kNoTwin) continue;
      ++found;
      std::array<Vec3, 3> p, q;
      for (std::size_t i = 0; i < 3; ++i)
        p[i] = a.positions[a.triangles[t][i]], q[i] = b.positions[b.triangles[twins[t]][i]];
      CHECK(std::is_permutation(p.begin(), p.end(), q.begin()));
    }
    CHECK(found == part.triangles.size());
  }
}

TEST_CASE("no twins: equal corners are counted, not just met") {
  const Mesh a = shapes::triangle({0, 0, 0}, {1, 0, 0}, {1, 0, 0}),
             b = shapes::triangle({0, 0, 0}, {0, 0, 0}, {1, 0, 0});
  CHECK(twins_by_position(ordered(a), ordered(b))[0] == kNoTwin);
  CHECK(twins_by_position(ordered(a), ordered(a))[0] == 0);
}
