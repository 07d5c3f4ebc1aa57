#include "fuzz/closed.h"

#include <algorithm>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "fuzz/dice.h"
#include "fuzz/kinds.h"
#include "shapes.h"

namespace meshgauge::fuzz {
namespace {

Mesh tetrahedron(Dice& dice, bool lattice) {
  Mesh mesh;
  const auto corner = [&] { return lattice ? dice.lattice(3) : dice.point(); };
  for (int i = 0; i < 4; ++i) mesh.positions.push_back(corner());
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Vec3 p = mesh.positions[0];
  const double volume = (mesh.positions[1] - p).dot((mesh.positions[2] - p).cross(mesh.positions[3] - p));
  return volume < 0 ? shapes::turned(mesh) : mesh;
}

void bend(Dice& dice, double most, Mesh& mesh) {
  for (Vec3& p : mesh.positions) p += dice.point(most);
}

// Splits an edge of the mesh in the middle of one triangle only, and closes the gap by a triangle of no area, where the
// middle is exact.
void add_flat_triangle(Dice& dice, Mesh& mesh) {
  const std::size_t at = dice.below(static_cast<std::uint32_t>(mesh.triangles.size()));
  const Triangle t = mesh.triangles[at];
  const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back((mesh.positions[t[0]] + mesh.positions[t[1]]) / 2);
  mesh.triangles[at] = {t[0], middle, t[2]};
  mesh.triangles.push_back({middle, t[1], t[2]});
  mesh.triangles.push_back({t[0], t[1], middle});
}

Mesh solid(Dice& dice) {
  Mesh mesh;
  switch (dice.below(4)) {
    case 0:
      mesh = tetrahedron(dice, dice.chance(0.5));
      break;
    case 1:
      mesh = shapes::cube(2, {-1, -1, -1});
      break;
    case 2:
      mesh = shapes::cube(1 + dice.between(0, 2), dice.lattice(2));
      break;
    default:
      mesh = shapes::closed_sphere(2 + dice.below(2), dice.uniform(0.3, 1.2));
      break;
  }
  if (dice.chance(0.15)) {
    for (Vec3& p : mesh.positions) p.z() *= dice.chance(0.5) ? 0.015625 : 1;
  }
  return mesh;
}

// As closed as before: equal positions stay equal.
template <class Change>
void each_position(Mesh& mesh, const Change& change) {
  std::vector<std::pair<Vec3, Vec3>> known;
  for (Vec3& p : mesh.positions) {
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto& pair) { return pair.first == p; });
    if (found != known.end()) {
      p = found->second;
    } else {
      known.emplace_back(p, change(p));
      p = known.back().second;
    }
  }
}

Mesh closed(Dice& dice, std::string& what) {
  Mesh mesh = solid(dice);
  switch (dice.below(7)) {
    case 0:
      what = "union";
      mesh = shapes::joined(mesh, dice.chance(0.5) ? shapes::moved(solid(dice), dice.point()) : solid(dice));
      break;
    case 1:
      what = "cavity";
      mesh = shapes::joined(shapes::cube(4, {-2, -2, -2}), shapes::turned(mesh));
      break;
    case 2:
      what = "part inside out";
      mesh = shapes::joined(shapes::cube(4, {-2, -2, -2}),
                            shapes::turned(shapes::moved(mesh, {dice.uniform(0, 5), 0, 0})));
      break;
    case 3: {
      what = "bent";
      const double most = dice.uniform(0, 1.5);
      each_position(mesh, [&](const Vec3& p) -> Vec3 { return p + dice.point(most); });
      break;
    }
    default:
      what = "solid";
      break;
  }
  if (dice.chance(0.2)) add_flat_triangle(dice, mesh), what += " with a flat triangle";
  if (dice.chance(0.05)) mesh = shapes::turned(mesh), what += " reversed";
  return dice.chance(0.2) ? shapes::unwelded(mesh) : mesh;
}

Mesh cloud(Dice& dice, const Mesh& near) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 12; ++i) {
    const Vec3& p = near.positions[dice.below(static_cast<std::uint32_t>(near.positions.size()))];
    mesh.positions.push_back(dice.chance(0.2) ? p : Vec3(p + dice.point(dice.power(-3, 0))));
  }
  mesh.triangles = points_as_triangles(mesh.positions.size());
  return mesh;
}

Mesh soup(Dice& dice, const Mesh& near) {
  Mesh mesh;
  const bool lattice = dice.chance(0.4);
  const auto corner = [&]() -> Vec3 {
    if (lattice) return dice.lattice(4) - Vec3(1, 1, 1);
    if (dice.chance(0.3)) return near.positions[dice.below(static_cast<std::uint32_t>(near.positions.size()))];
    return dice.point(2);
  };
  for (int i = dice.between(1, 5); i > 0; --i) {
    const Vec3 a = corner(), b = corner(), c = corner();
    add_triangle(mesh, a, b, c);
  }
  return mesh;
}

Mesh candidate(Dice& dice, const Mesh& b, std::string& what) {
  switch (dice.below(7)) {
    case 0:
      what += ", a soup";
      return soup(dice, b);
    case 1:
      what += ", a cloud";
      return cloud(dice, b);
    case 2:
      what += ", another solid";
      return shapes::moved(solid(dice), dice.point());
    case 3:
      what += ", scaled";
      return shapes::scaled(b, dice.chance(0.5) ? 1 + dice.uniform(-0.2, 0.2) : 1 + dice.power(-15, -3));
    case 4: {
      what += ", shaken";
      Mesh mesh = b;
      bend(dice, dice.power(-12, -0.5), mesh);
      return mesh;
    }
    case 5: {
      what += ", partly moved";
      Mesh mesh = b;
      mesh.positions[dice.below(static_cast<std::uint32_t>(mesh.positions.size()))] += dice.point(1);
      return mesh;
    }
    default:
      what += ", equal";
      return b;
  }
}

}  // namespace

Pair generate_closed(std::uint64_t seed) {
  Dice dice(seed);
  Pair pair;
  pair.b = closed(dice, pair.what);
  pair.a = candidate(dice, pair.b, pair.what);
  const double factor = dice.chance(0.2) ? dice.power(-30, 30) : 1;
  const Vec3 offset = dice.chance(0.2) ? Vec3(factor * dice.power(0, 9) * dice.point()) : Vec3(Vec3::Zero());
  for (Mesh* mesh : {&pair.a, &pair.b}) {
    for (Vec3& p : mesh->positions) p = p * factor + offset;
  }
  return pair;
}

}  // namespace meshgauge::fuzz
