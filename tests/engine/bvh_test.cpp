#include "engine/bvh.h"

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;

namespace {

// Every triangle is in exactly one leaf, every box holds what is below it, and no path is too long.
void check_tree(const Mesh& mesh) {
  Control control;
  const Bvh tree(mesh, control);
  REQUIRE(tree.interruption() == Interruption::none);
  std::vector<int> seen(mesh.triangles.size());
  struct Entry {
    std::uint32_t node;
    std::size_t depth;
    Box outer;
  };
  std::vector<Entry> stack{{Bvh::kRoot, 1, tree.nodes()[Bvh::kRoot].box}};
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    const Bvh::Node& node = tree.nodes()[entry.node];
    REQUIRE(entry.depth <= Bvh::kMaxDepth);
    CHECK((node.box.low.array() >= entry.outer.low.array()).all());
    CHECK((node.box.high.array() <= entry.outer.high.array()).all());
    for (std::uint32_t slot = node.first; slot < node.first + node.count; ++slot) {
      const std::uint32_t t = tree.triangle(slot);
      ++seen[t];
      for (int k = 0; k < 3; ++k) CHECK(distance_sq(node.box, mesh.positions[mesh.triangles[t][std::size_t(k)]]) == 0);
    }
    if (!node.is_leaf()) {
      stack.push_back({node.first, entry.depth + 1, node.box});
      stack.push_back({node.first + 1, entry.depth + 1, node.box});
    }
  }
  for (const int count : seen) REQUIRE(count == 1);
}

}  // namespace

TEST_CASE("a tree holds every triangle once, within its boxes") {
  check_tree(shapes::sphere(20));
  check_tree(shapes::cube());
  std::mt19937_64 random(3);
  check_tree(shapes::soup(1000, random));
  check_tree(shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
}

TEST_CASE("a thousand equal triangles, and sizes in geometric progression, give a tree of bounded depth") {
  Mesh equal, shrinking;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    for (Mesh* mesh : {&equal, &shrinking}) mesh->triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    equal.positions.insert(equal.positions.end(), {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)});
    const double s = std::pow(0.5, i);
    shrinking.positions.insert(shrinking.positions.end(), {Vec3(s, 0, 0), Vec3(s, s, 0), Vec3(s, 0, s)});
  }
  check_tree(equal);
  check_tree(shrinking);
}

TEST_CASE("building stops when it is told to") {
  Control control;
  control.cancel();
  const Mesh mesh = shapes::sphere(150);
  CHECK(Bvh(mesh, control).interruption() == Interruption::cancelled);
}
