#include "engine/tree/bvh.h"

#include <doctest/doctest.h>

#include <cstring>

#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

bool holds(const Box& box, const Vec3& p) {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

void check_block(const Bvh& tree, std::uint32_t block, const std::vector<Box>& boxes, std::vector<int>& seen) {
  for (std::uint32_t t = Bvh::block_begin(block); t < tree.block_end(block); ++t) {
    ++seen[t];
    for (const Box& box : boxes) {
      for (int k = 0; k < 3; ++k) CHECK(holds(box, tree.mesh().corner(t, k)));
    }
  }
}

// Checks that every triangle is in exactly one leaf and within every box on its path, and that no path is too long.
void check_tree(const Mesh& mesh) {
  const Bvh tree = tree_of(mesh);
  REQUIRE(tree.complete());
  std::vector<int> seen(mesh.triangles.size());
  struct Entry {
    std::uint32_t node;
    std::vector<Box> boxes;  // on the path
  };
  std::vector<Entry> stack{{Bvh::kRoot, {}}};
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    REQUIRE(entry.boxes.size() < kMaxTreeDepth);
    const WideNode& node = tree.nodes()[entry.node];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t child = node.child[lane];
      if (child == WideNode::kNone) continue;
      std::vector<Box> boxes = entry.boxes;
      boxes.push_back(Bvh::child_box(node, lane));
      if (child & WideNode::kLeaf) {
        check_block(tree, child & ~WideNode::kLeaf, boxes, seen);
      } else {
        REQUIRE(child > entry.node);
        stack.push_back({child, boxes});
      }
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
  check_tree(shapes::moved(shapes::scaled(shapes::soup(300, random), 1e-9), {1, 1, 1}));
  check_tree(shapes::scaled(shapes::soup(300, random), 1e-300));
}

TEST_CASE("a thousand equal triangles, and sizes in geometric progression, give a tree of bounded depth") {
  Mesh equal, shrinking;
  for (std::uint32_t i = 0; i < 8000; ++i) {
    for (Mesh* mesh : {&equal, &shrinking}) mesh->triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    equal.positions.insert(equal.positions.end(), {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)});
    const double s = std::pow(0.9, i);
    shrinking.positions.insert(shrinking.positions.end(), {Vec3(s, 0, 0), Vec3(s, s, 0), Vec3(s, 0, s)});
  }
  check_tree(equal);
  check_tree(shrinking);
}

TEST_CASE("a tree does not depend on threads or instruction sets") {
  const Mesh mesh = shapes::sphere(100);
  const Bvh tree = tree_of(mesh);
  for (const Kernels& kernels : supported_kernels()) {
    Control control;
    ThreadPool pool(3);
    const Bvh other(mesh, kernels, control, pool);
    REQUIRE(other.nodes().size() == tree.nodes().size());
    CHECK(std::memcmp(other.nodes().data(), tree.nodes().data(), tree.nodes().size() * sizeof(WideNode)) == 0);
    CHECK(other.residual() == tree.residual());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const PreparedTriangle a = tree.prepared(t), b = other.prepared(t);
      REQUIRE(std::memcmp(&a, &b, sizeof a) == 0);
    }
  }
}

TEST_CASE("building a tree stops when it is interrupted") {
  Control control;
  control.cancel();
  const Mesh mesh = shapes::sphere(150);
  ThreadPool pool(1);
  CHECK_FALSE(Bvh(mesh, *find_kernels("auto"), control, pool).complete());
}
