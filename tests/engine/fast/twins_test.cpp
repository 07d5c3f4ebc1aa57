#include "engine/fast/twins.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "engine/hausdorff.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

OrderedMesh ordered(const Mesh& mesh) {
  Control control;
  ThreadPool pool(1);
  return {mesh, {}, bounding_box(mesh), Frame{}, control, pool};
}

LargeArray<std::uint32_t> shared(const Mesh& from, const Mesh& to) {
  const auto once = shared_triangles(from, Prepared(to), never_interrupted);
  CHECK(shared_triangles(from, Prepared(to, Prepared::Use::often), never_interrupted) == once);
  return once;
}

// Returns the same triangles in another order, each beginning at another corner, some turned over.
Mesh stirred(Mesh mesh, std::mt19937_64& random) {
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  for (Triangle& t : mesh.triangles) std::shuffle(t.begin(), t.end(), random);
  return mesh;
}

}  // namespace

TEST_CASE("twins by number follow the given numbers, not the order in memory") {
  std::mt19937_64 random(71);
  const Mesh mesh = shapes::sphere(20);
  const OrderedMesh a = ordered(mesh), b = ordered(shapes::moved(shapes::scaled(mesh, 0.4), {0.2, 0, 0.1}));
  const auto twins = twins_by_number(a, b);
  REQUIRE(twins.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < twins.size(); ++t) CHECK(b.original[twins[t]] == a.original[t]);
}

TEST_CASE("twins by number: the other mesh has fewer triangles, or far fewer") {
  Mesh mesh = shapes::sphere(20);
  const OrderedMesh a = ordered(mesh);
  mesh.triangles.resize(mesh.triangles.size() - 100);
  const auto twins = twins_by_number(a, ordered(mesh));
  CHECK(std::count(twins.begin(), twins.end(), kNoTwin) == 100);
  mesh.triangles.resize(50);
  CHECK(twins_by_number(a, ordered(mesh)).empty());
  CHECK(twins_by_number(ordered(mesh), a).empty());
}

TEST_CASE("shared triangles: exactly the equal ones, in a reordered and in a partial copy") {
  std::mt19937_64 random(72);
  Mesh wall = shapes::grid(10);  // in a plane x = const
  for (Vec3& p : wall.positions) std::swap(p.x(), p.z());
  for (const Mesh& mesh : {shapes::sphere(20), shapes::soup(400, random), shapes::grid(10), wall}) {
    Mesh part = stirred(mesh, random);
    part.triangles.resize(part.triangles.size() * 3 / 4);
    const auto twins = shared(mesh, part);
    REQUIRE(twins.size() == mesh.triangles.size());
    std::size_t found = 0;
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
      if (twins[t] == kNoTwin) continue;
      ++found;
      std::array<Vec3, 3> p, q;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = mesh.positions[mesh.triangles[t][i]];
        q[i] = part.positions[part.triangles[twins[t]][i]];
      }
      CHECK(std::is_permutation(p.begin(), p.end(), q.begin()));
    }
    CHECK(found == part.triangles.size());
  }
}

TEST_CASE("shared triangles: if the numbers agree, only equal numbers are compared") {
  const Mesh mesh = shapes::sphere(20);
  Mesh longer = mesh;
  longer.triangles.push_back({0, 1, 1});
  const auto all = shared(mesh, mesh);
  const auto without_last = shared(longer, mesh);
  REQUIRE(all.size() == mesh.triangles.size());
  REQUIRE(without_last.size() == longer.triangles.size());
  for (std::uint32_t t = 0; t < all.size(); ++t) CHECK((all[t] == t && without_last[t] == t));
  CHECK(without_last.back() == kNoTwin);
}

TEST_CASE("shared triangles: a sample detects meshes with little in common") {
  const Mesh mesh = shapes::sphere(20);
  Mesh few = mesh;
  few.triangles.resize(few.triangles.size() / 3);
  few.positions.resize(few.positions.size() / 3);
  for (Triangle& t : few.triangles)
    for (std::uint32_t& v : t) v %= static_cast<std::uint32_t>(few.positions.size());
  CHECK(shared(mesh, few).empty());
  CHECK(shared(mesh, shapes::moved(mesh, {1e-9, 0, 0})).empty());
}

TEST_CASE("shared triangles: repeated corners must be repeated in both") {
  const Mesh a = shapes::triangle({0, 0, 0}, {1, 0, 0}, {1, 0, 0}),
             b = shapes::triangle({0, 0, 0}, {0, 0, 0}, {1, 0, 0});
  CHECK(shared(a, b)[0] == kNoTwin);
  CHECK(shared(a, a)[0] == 0);
}

TEST_CASE("shared triangles: meshes with the same triangles are at distance 0, exactly, in every direction") {
  std::mt19937_64 random(73);
  for (const Mesh& mesh : {shapes::sphere(20), shapes::soup(400, random)}) {
    Mesh copy = stirred(mesh, random);
    for (const Direction direction : {Direction::a_to_b, Direction::b_to_a, Direction::symmetric}) {
      Options options;
      options.direction = direction;
      Control control;
      const Outcome outcome = measure(mesh, copy, options, control);
      CHECK(outcome.lower == 0);
      CHECK(outcome.upper == 0);
      CHECK(outcome.stop == Stop::converged);
      for (const auto* directed : {&outcome.a_to_b, &outcome.b_to_a}) {
        if (!*directed) continue;
        const MeshView from = directed == &outcome.a_to_b ? mesh : copy, to = directed == &outcome.a_to_b ? copy : mesh;
        const Witness& witness = (*directed)->bounds.witness.value();
        CHECK(witness.point_a == from.corner(witness.triangle_a, 0));
        CHECK(witness.point_b == witness.point_a);
        bool is_corner = false;
        for (int i = 0; i < 3; ++i) is_corner |= to.corner(witness.triangle_b, i) == witness.point_b;
        CHECK(is_corner);
        CHECK((*directed)->culling.rate() == 1);
      }
    }
  }
}

TEST_CASE("shared triangles: a copy with a moved part, cancelled at every check: the interval holds") {
  std::mt19937_64 random(75);
  const Mesh mesh = shapes::sphere(120);
  Mesh moved = mesh;
  for (std::size_t i = 0; i < moved.positions.size() / 8; ++i) moved.positions[i] *= 1.01;
  for (const Mesh& b : {moved, stirred(moved, random)}) {
    Options options;
    options.tolerance = {std::nullopt, 1e-3, std::nullopt};
    options.threads = 2;
    Control patient;
    const Outcome whole = measure(mesh, b, options, patient);
    CHECK(whole.stop == Stop::converged);
    for (std::uint64_t k = 1; k <= patient.checks(); k += 1 + k / 20) {
      Control control;
      control.cancel_at_check(k);
      const Outcome outcome = measure(mesh, b, options, control);
      CHECK(outcome.lower <= whole.upper);
      CHECK(whole.lower <= outcome.upper);
    }
  }
}

TEST_CASE("shared triangles: measuring the rest of a copy gives the interval of the whole") {
  std::mt19937_64 random(74);
  const Mesh mesh = shapes::sphere(30);
  Mesh moved = stirred(mesh, random);
  for (std::size_t i = 0; i < moved.positions.size() / 4; ++i) moved.positions[i] *= 1.01;
  Mesh extra = moved;
  extra.positions.push_back({0, 0, 5});
  extra.triangles.push_back({0, 1, static_cast<std::uint32_t>(extra.positions.size() - 1)});
  for (const auto& [a, b] : {std::pair(mesh, moved), std::pair(moved, mesh), std::pair(extra, moved)}) {
    for (const Direction direction : {Direction::a_to_b, Direction::symmetric}) {
      Options options;
      options.direction = direction;
      options.tolerance = {std::nullopt, 1e-6, std::nullopt};
      options.threads = direction == Direction::symmetric ? 2 : 1;
      Control control;
      const Outcome outcome = measure(a, b, options, control);
      options.strategy = Strategy::four_point;
      const Outcome paper = measure(a, b, options, control);
      CHECK(outcome.stop == Stop::converged);
      CHECK(outcome.lower <= paper.upper);
      CHECK(paper.lower <= outcome.upper);
      CHECK(outcome.lower > 0);
      const Witness& witness = outcome.a_to_b->bounds.witness.value();
      CHECK(witness.triangle_a < a.triangles.size());
      CHECK(outcome.a_to_b->culling.triangles == a.triangles.size());
    }
  }
}
