#include "api/formats/weld.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace meshgauge::api::test {
namespace {

Mesh soup(std::size_t triangles, int values, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> any(-values, values);
  Mesh mesh;
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) {
    mesh.positions.emplace_back(any(random) * 0.1, any(random) * 0.0, any(random) * 1e-300);
    if (i % 3 == 2) mesh.triangles.push_back({i - 2, i - 1, i});
  }
  return mesh;
}

using Key = std::array<double, 3>;

}  // namespace

TEST_CASE("weld: equal positions become one, in the order of first occurrence") {
  Mesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 1, 0}, {-0.0, -0.0, 0}, {2, 0, 0}, {1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 0, 0}};
  CHECK(weld(mesh) == 3);
  CHECK(mesh.positions == std::vector<Vec3>{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {2, 0, 0}});
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {0, 0, 0}});
  CHECK(weld(mesh) == 0);
}

TEST_CASE("weld: minus zero becomes zero, and close positions stay apart") {
  Mesh mesh;
  mesh.positions = {{-0.0, 0, 0}, {std::nextafter(0.0, 1.0), 0, 0}, {0.0, -0.0, 0}, {1, 1, std::nextafter(1.0, 2.0)}};
  mesh.triangles = {{0, 1, 2}, {1, 2, 3}};
  CHECK(weld(mesh) == 1);
  CHECK(!std::signbit(mesh.positions[0].x()));
  CHECK(mesh.positions.size() == 3);
}

TEST_CASE("weld: the same result as with a map, on random soups") {
  for (const int values : {1, 5, 100}) {
    const Mesh before = soup(2000, values, 11);
    Mesh mesh = before;
    const std::size_t gone = weld(mesh);
    std::map<Key, std::uint32_t> known;
    for (std::size_t t = 0; t < before.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = before.positions[before.triangles[t][k]];
        const auto next = static_cast<std::uint32_t>(known.size());
        const auto [entry, is_new] = known.try_emplace(Key{p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, next);
        CHECK(mesh.triangles[t][k] == entry->second);
      }
    }
    CHECK(mesh.positions.size() == known.size());
    CHECK(gone == before.positions.size() - known.size());
  }
}

TEST_CASE("weld: a welder gives the same by pieces of any size, whatever number it expects") {
  for (const int values : {1, 5, 100}) {
    Mesh mesh = soup(2000, values, 12);
    const std::vector<Vec3> given = mesh.positions;
    weld(mesh);
    for (const std::size_t expected : {0U, 7U, 6000U, 50000U}) {
      for (const std::size_t piece : {1U, 63U, 64U, 65U, 6000U}) {
        std::vector<Vec3> kept(given.size());
        std::vector<std::uint32_t> indices(given.size());
        Welder welder(kept.data(), expected);
        for (std::size_t first = 0; first < given.size(); first += piece) {
          welder.add(std::span(given).subspan(first, std::min(piece, given.size() - first)), indices.data() + first);
        }
        kept.resize(welder.count());
        CHECK(kept == mesh.positions);
        bool same = true;
        for (std::size_t i = 0; i < indices.size(); ++i) same &= indices[i] == mesh.triangles[i / 3][i % 3];
        CHECK(same);
      }
    }
  }
}

TEST_CASE("weld: an empty mesh stays empty") {
  Mesh mesh;
  CHECK(weld(mesh) == 0);
}

}  // namespace meshgauge::api::test
