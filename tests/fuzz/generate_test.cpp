#include "fuzz/generate.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <set>
#include <sstream>

#include "fuzz/kinds.h"
#include "fuzz/shrink.h"
#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

// Reads what to_obj() writes.
Mesh from_obj(const std::string& text) {
  Mesh mesh;
  std::istringstream lines(text);
  for (std::string kind, x, y, z; lines >> kind >> x >> y >> z;) {
    const auto index = [](const std::string& s) { return static_cast<std::uint32_t>(std::stoul(s)) - 1; };
    if (kind == "v")
      mesh.positions.emplace_back(std::strtod(x.c_str(), nullptr), std::strtod(y.c_str(), nullptr),
                                  std::strtod(z.c_str(), nullptr));
    if (kind == "f") mesh.triangles.push_back({index(x), index(y), index(z)});
  }
  return mesh;
}

}  // namespace

TEST_CASE("every generated pair is valid, small, and the same for the same seed") {
  std::set<std::string> seen;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const Pair pair = generate(seed), again = generate(seed);
    CAPTURE(pair.what);
    for (const Mesh* mesh : {&pair.a, &pair.b}) {
      REQUIRE(validate(*mesh, {}, "a").ok());
      CHECK(mesh->triangles.size() <= 400);
    }
    CHECK(to_obj(pair.a) == to_obj(again.a));
    CHECK(to_obj(pair.b) == to_obj(again.b));
    seen.insert(pair.what.substr(0, pair.what.find(',')));
  }
  for (const Kind& kind : kinds()) CHECK(seen.count(kind.name) == 1);
}

TEST_CASE("a pair written as OBJ reads back bit for bit") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Mesh mesh = generate(seed).a;
    const Mesh back = from_obj(to_obj(mesh));
    REQUIRE(back.positions.size() == mesh.positions.size());
    CHECK(back.triangles == mesh.triangles);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      CHECK((back.positions[i] == mesh.positions[i] || !mesh.positions[i].allFinite()));
    }
  }
}

TEST_CASE("a failing pair shrinks to the part that fails") {
  Pair pair{shapes::cube(), shapes::cube(), "two cubes"};
  pair.a.positions.emplace_back(0.1, 0.2, 0.3);
  add_triangle(pair.b, {0.123456789, 7.5, 3}, {1, 2, 3}, {4, 5, 6});
  const auto has_tall_corner = [](const Pair& p) {
    for (const Triangle& t : p.b.triangles) {
      for (const std::uint32_t i : t) {
        if (p.b.positions[i].y() > 7) return true;
      }
    }
    return false;
  };
  const Pair small = shrink(pair, has_tall_corner, std::chrono::seconds(20));
  CHECK(has_tall_corner(small));
  CHECK(small.a.triangles.size() == 1);
  CHECK(small.b.triangles.size() == 1);
  CHECK(small.b.positions.size() == 3);
  CHECK(small.a.positions == std::vector<Vec3>(small.a.positions.size(), Vec3::Zero()));
  CHECK(small.b.positions[small.b.triangles[0][0]] == Vec3(0, 8, 0));
}
