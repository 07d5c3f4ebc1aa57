#include "fuzz/kinds.h"

#include <algorithm>
#include <limits>

namespace meshgauge::fuzz {
namespace {

// Mostly few triangles: a small pair is cheap and still has all kinds of geometry.
std::uint32_t some(Dice& dice) { return 1 + dice.below(dice.chance(0.7) ? 3 : 10); }

Mesh soup(Dice& dice, std::uint32_t n) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3 a = dice.point(), b = dice.point(), c = dice.point();
    add_triangle(mesh, a, b, c);
  }
  return mesh;
}

Mesh lattice_soup(Dice& dice, std::uint32_t n, int size) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3 a = dice.lattice(size), b = dice.lattice(size), c = dice.lattice(size);
    add_triangle(mesh, a, b, c);
  }
  return mesh;
}

// A sheet of w*h squares over [0,1]^2, each cut along one of its diagonals, with heights.
Mesh sheet(Dice& dice, int w, int h, double height) {
  Mesh mesh;
  for (int j = 0; j <= h; ++j) {
    for (int i = 0; i <= w; ++i)
      mesh.positions.emplace_back(double(i) / w, double(j) / h, height * dice.uniform(-1, 1));
  }
  for (int j = 0; j < h; ++j) {
    for (int i = 0; i < w; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (w + 1) + i), b = a + 1, c = a + static_cast<std::uint32_t>(w) + 1,
                 d = c + 1;
      if (dice.chance(0.5)) {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {b, d, c}});
      } else {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
      }
    }
  }
  return mesh;
}

Mesh small_sheet(Dice& dice, double height) { return sheet(dice, dice.between(1, 3), dice.between(1, 2), height); }

Mesh box(const Vec3& low, const Vec3& high) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Mesh slivers(Dice& dice, std::uint32_t n) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3 a = dice.point(), along = dice.point(), across = dice.point() * dice.power(-17, -3);
    const double t = dice.chance(0.3) ? dice.power(-16, 0) : dice.uniform(-0.2, 1.2);
    add_triangle(mesh, a, a + along, a + t * along + across);
  }
  return mesh;
}

void make_soup(Dice& dice, Pair& pair) {
  pair.a = soup(dice, some(dice));
  pair.b = soup(dice, some(dice));
}

void make_lattice(Dice& dice, Pair& pair) {
  const int size = dice.between(1, 5);
  pair.a = lattice_soup(dice, some(dice), size);
  pair.b = lattice_soup(dice, some(dice), size);
}

void make_slivers(Dice& dice, Pair& pair) {
  pair.a = dice.chance(0.5) ? slivers(dice, some(dice)) : soup(dice, some(dice));
  pair.b = slivers(dice, some(dice));
}

// Both meshes in one plane, with lattice corners: overlaps, common edges, corners on edges.
void make_coplanar(Dice& dice, Pair& pair) {
  const int size = dice.between(2, 5), axis = dice.between(0, 2);
  pair.a = lattice_soup(dice, some(dice), size);
  pair.b = lattice_soup(dice, some(dice), size);
  for (Mesh* mesh : {&pair.a, &pair.b}) {
    for (Vec3& p : mesh->positions) p[axis] = dice.chance(0.02) ? p[axis] * 1e-9 : 0;
  }
}

void make_identical(Dice& dice, Pair& pair) {
  pair.a = dice.chance(0.5) ? soup(dice, some(dice)) : small_sheet(dice, dice.power(-3, 0));
  pair.b = pair.a;
  std::reverse(pair.b.triangles.begin(), pair.b.triangles.end());
  for (Triangle& t : pair.b.triangles) std::rotate(t.begin(), t.begin() + dice.below(3), t.end());
}

void make_subset(Dice& dice, Pair& pair) {
  pair.b = dice.chance(0.5) ? soup(dice, 2 + some(dice)) : small_sheet(dice, dice.power(-3, 0));
  pair.a = pair.b;
  pair.a.triangles.resize(1 + dice.below(static_cast<std::uint32_t>(pair.b.triangles.size())));
  if (dice.chance(0.3)) std::swap(pair.a, pair.b);
}

void make_ulp(Dice& dice, Pair& pair) {
  pair.a = dice.chance(0.5) ? soup(dice, some(dice)) : small_sheet(dice, dice.power(-3, 0));
  pair.b = pair.a;
  for (Vec3& p : pair.b.positions) p = one_ulp_away(dice, p);
}

// The same plane or the same folded sheet, or nearly the same, cut into other triangles.
void make_recut(Dice& dice, Pair& pair) {
  const double height = dice.chance(0.5) ? 0 : dice.power(-14, -1);
  const int w = dice.between(1, 3), h = dice.between(1, 2);
  pair.a = sheet(dice, w, h, height);
  pair.b = dice.chance(0.5) ? sheet(dice, w, h, 0) : sheet(dice, dice.between(1, 3), dice.between(1, 2), height);
  if (dice.chance(0.2)) {
    for (Vec3& p : pair.b.positions) p.x() += 1e-9 * dice.uniform(-1, 1);
  }
}

// Splits triangles at the edges' midpoints or at a point inside: the surface is the same within rounding.
void make_split(Dice& dice, Pair& pair) {
  pair.a = dice.chance(0.5) ? soup(dice, some(dice)) : small_sheet(dice, dice.power(-3, 0));
  const double noise = dice.chance(0.6) ? 0 : dice.power(-16, -2);
  for (std::size_t t = 0; t < pair.a.triangles.size() && t < 5; ++t) {
    const auto [i, j, k] = pair.a.triangles[t];
    const Vec3 a = pair.a.positions[i], b = pair.a.positions[j], c = pair.a.positions[k];
    const double s = dice.unit(), r = dice.unit() * (1 - s);
    const Vec3 inside = a + s * (b - a) + r * (c - a) + noise * dice.point();
    add_triangle(pair.b, a, b, inside);
    add_triangle(pair.b, b, c, inside);
    if (dice.chance(0.95)) add_triangle(pair.b, c, a, inside);
  }
  if (dice.chance(0.3)) std::swap(pair.a, pair.b);
}

void make_duplicates(Dice& dice, Pair& pair) {
  pair.a = soup(dice, some(dice));
  pair.b = soup(dice, some(dice));
  for (Mesh* mesh : {&pair.a, &pair.b}) {
    const std::size_t n = mesh->triangles.size();
    for (std::uint32_t k = dice.below(10); k > 0; --k) mesh->triangles.push_back(mesh->triangles[k % n]);
  }
}

void degenerate(Dice& dice, Mesh& mesh) {
  for (Triangle& t : mesh.triangles) {
    Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    switch (dice.below(7)) {
      case 0:
        t[dice.below(3)] = t[dice.below(3)];
        break;
      case 1:
        t = {t[1], t[1], t[1]};
        break;
      case 2:
        c = a;
        break;
      case 3:
        b = a, c = a;
        break;
      case 4:
        c = (a + b) * 0.5;
        break;
      case 5:
        c = a + dice.uniform(-2, 2) * (b - a);
        break;
      default:
        break;
    }
  }
}

void make_degenerate(Dice& dice, Pair& pair) {
  pair.a = dice.chance(0.5) ? soup(dice, some(dice)) : lattice_soup(dice, some(dice), 4);
  pair.b = dice.chance(0.5) ? soup(dice, some(dice)) : lattice_soup(dice, some(dice), 4);
  if (dice.chance(0.6)) degenerate(dice, pair.a);
  degenerate(dice, pair.b);
}

// A across the middle between two walls of slices, which may lean or be of different slices: a line of farthest points.
void make_walls(Dice& dice, Pair& pair) {
  const double lean = dice.chance(0.5) ? 0 : dice.sign() * dice.power(-12, -1);
  for (const double x : {0.0, 1.0}) {
    const int slices = dice.between(1, 4);
    for (int i = 0; i < slices; ++i) {
      const double low = -0.2 + 1.4 * i / slices, high = -0.2 + 1.4 * (i + 1) / slices;
      add_triangle(pair.b, {x, low, 0}, {x, high, 0}, {x + lean, high, 1});
      if (dice.chance(0.7)) add_triangle(pair.b, {x, low, 0}, {x + lean, high, 1}, {x + lean, low, 1});
    }
  }
  const double z = dice.uniform(0.2, 0.8), tilt = dice.chance(0.5) ? 0 : dice.power(-16, -1);
  add_triangle(pair.a, {0.05, 0, z}, {0.9, 0, z + tilt}, {0.95, 1, z});
  if (dice.chance(0.5)) add_triangle(pair.a, {0.05, 0, z}, {0.95, 1, z}, {0.1, 0.9, z - tilt});
}

// A across the middle of a box, or between two plates: a continuum of farthest points.
void make_medial(Dice& dice, Pair& pair) {
  if (dice.chance(0.4)) return make_walls(dice, pair);
  const Vec3 low(0, 0, 0), high(double(dice.between(1, 3)), double(dice.between(1, 3)), 1);
  pair.b = box(low, high);
  if (dice.chance(0.3)) pair.b.triangles.resize(4);  // floor and lid only
  const double z = 0.5 + (dice.chance(0.5) ? 0 : dice.sign() * dice.power(-16, -2));
  const double tilt = dice.chance(0.5) ? 0 : dice.power(-16, -1);
  const Vec3 up(0, 0, tilt);
  add_triangle(pair.a, {0, 0, z}, {high.x(), 0, z}, Vec3(high.x(), high.y(), z) + up);
  if (dice.chance(0.5)) add_triangle(pair.a, {0, 0, z}, Vec3(high.x(), high.y(), z) + up, {0, high.y(), z});
}

void make_needles(Dice& dice, Pair& pair) {
  for (std::uint32_t i = some(dice); i > 0; --i) {
    const Vec3 at = dice.point(), tip = at + dice.point() * dice.power(-1, 2);
    add_triangle(pair.b, at, at + dice.point() * dice.power(-10, -2), tip);
  }
  const Vec3 a = dice.point(10), b = dice.point(10), c = dice.point(10);
  add_triangle(pair.a, a, b, c);
  if (dice.chance(0.5)) std::swap(pair.a, pair.b);
}

void make_near_parallel(Dice& dice, Pair& pair) {
  pair.a = small_sheet(dice, 0);
  pair.b = small_sheet(dice, 0);
  const double lift = dice.chance(0.5) ? 0 : dice.power(-16, 0);
  const Vec3 slope = dice.point(dice.power(-16, -1));
  for (Vec3& p : pair.b.positions) p.z() += lift + slope.x() * p.x() + slope.y() * p.y();
}

// Corners of A exactly on corners and edges' midpoints of B.
void make_touching(Dice& dice, Pair& pair) {
  pair.b = lattice_soup(dice, some(dice), 8);
  const auto on_b = [&]() -> Vec3 {
    const Triangle& t = pair.b.triangles[dice.below(static_cast<std::uint32_t>(pair.b.triangles.size()))];
    const Vec3 &a = pair.b.positions[t[0]], &b = pair.b.positions[t[1]], &c = pair.b.positions[t[2]];
    switch (dice.below(4)) {
      case 0:
        return a;
      case 1:
        return (a + b) * 0.5;
      case 2:
        return a * 0.5 + b * 0.25 + c * 0.25;
      default:
        return dice.lattice(8);
    }
  };
  for (std::uint32_t i = some(dice); i > 0; --i) {
    const Vec3 a = on_b(), b = on_b(), c = on_b();
    add_triangle(pair.a, a, b, c);
  }
}

// Connected surfaces over the same square; folds where the heights or the steps in the plane are large.
void make_sheets(Dice& dice, Pair& pair) {
  pair.a = small_sheet(dice, dice.power(-6, 0));
  pair.b = small_sheet(dice, dice.power(-6, 0));
  if (dice.chance(0.5)) {
    const double fold = dice.power(-2, 0);
    for (Vec3& p : pair.b.positions) p += Vec3(dice.uniform(-fold, fold), dice.uniform(-fold, fold), 0);
  }
  if (dice.chance(0.3)) pair.a = sheet(dice, 1, 1, 0);
}

// A fan around a spike, over or under a triangle: folded, with holes, turned inside out.
void make_fan(Dice& dice, Pair& pair) {
  const int n = dice.between(3, 9);
  const Vec3 top(dice.uniform(-0.5, 0.5), dice.uniform(-0.5, 0.5), dice.sign() * dice.power(-12, 0));
  const auto rim = [&](int i) {
    const double angle = 6.283185307179586 * i / n + dice.uniform(-0.3, 0.3);
    return Vec3(std::cos(angle), std::sin(angle), dice.chance(0.5) ? 0 : 0.1 * dice.uniform(-1, 1));
  };
  pair.b.positions.push_back(top);
  for (int i = 0; i < n; ++i) pair.b.positions.push_back(rim(i));
  for (int i = 0; i < n; ++i) {
    if (dice.chance(0.05)) continue;
    const auto j = static_cast<std::uint32_t>(1 + i), k = static_cast<std::uint32_t>(1 + (i + 1) % n);
    pair.b.triangles.push_back(dice.chance(0.8) ? Triangle{0, j, k} : Triangle{0, k, j});
  }
  if (pair.b.triangles.empty()) pair.b.triangles.push_back({0, 1, 2});
  const Vec3 a = dice.point(), b = dice.point(), c = dice.point();
  const double flat = dice.chance(0.6) ? dice.power(-12, 0) : 0;
  const auto flatten = [&](const Vec3& p) { return Vec3(p.x(), p.y(), flat * p.z()); };
  add_triangle(pair.a, flatten(a), flatten(b), flatten(c));
}

// Enough triangles that there are several blocks, leaves and levels of a tree.
void make_many(Dice& dice, Pair& pair) {
  const auto many = [&] {
    if (dice.chance(0.5)) return sheet(dice, dice.between(4, 14), dice.between(4, 12), dice.power(-6, 0));
    return soup(dice, 40 + dice.below(160));
  };
  const std::uint32_t which = dice.below(4);
  pair.a = which == 0 ? small_sheet(dice, 0.1) : many();
  pair.b = which == 1 || which == 2 ? soup(dice, some(dice)) : many();
  if (dice.chance(0.2)) pair.b = pair.a;
}

// A copy with the same indices: moved as a whole, bent, dented in one place, or with noise.
void make_deformed(Dice& dice, Pair& pair) {
  pair.a = dice.chance(0.7) ? sheet(dice, dice.between(3, 12), dice.between(2, 10), dice.power(-6, 0))
                            : soup(dice, 10 + dice.below(60));
  pair.b = pair.a;
  const double size = dice.power(-12, 0.3), noise = dice.chance(0.3) ? dice.power(-16, -2) : 0;
  const Vec3 way = dice.point(size), dent = dice.point();
  const std::uint32_t how = dice.below(4);
  for (Vec3& p : pair.b.positions) {
    if (how == 0) p += way;
    if (how == 1) p += (p - dent).squaredNorm() * way;
    if (how == 2 && (p - dent).norm() < 0.4) p += way;
    if (how == 3) p += dice.point(size);
    if (noise > 0) p += dice.point(noise);
  }
  if (dice.chance(0.2)) add_triangle(pair.a, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  if (dice.chance(0.1)) pair.b.positions.push_back(dice.point(100));
}

// Removes, turns, repeats and folds triangles of a sheet.
void damage(Dice& dice, Mesh& mesh) {
  const auto any = [&] { return dice.below(static_cast<std::uint32_t>(mesh.triangles.size())); };
  const auto some_times = [&](double chance, auto&& change) {
    for (std::uint32_t k = dice.chance(chance) ? 1 + dice.below(6) : 0; k > 0; --k) change();
  };
  some_times(0.4, [&] { mesh.triangles.erase(mesh.triangles.begin() + any()); });
  some_times(0.3, [&] { std::swap(mesh.triangles[any()][0], mesh.triangles[any()][1]); });
  some_times(0.2, [&] { std::reverse(mesh.triangles[any()].begin(), mesh.triangles[any()].end()); });
  some_times(0.1, [&] { mesh.triangles.push_back(mesh.triangles[any()]); });
  const double fold = dice.power(-2, -0.5);
  some_times(0.2, [&] {
    mesh.positions[mesh.triangles[any()][0]] += Vec3(dice.uniform(-fold, fold), dice.uniform(-fold, fold), 0);
  });
}

// Two connected surfaces near each other, one finer than the other: some of a surface is missing, folded or double.
void make_layers(Dice& dice, Pair& pair) {
  const double height = dice.power(-6, -0.5);
  pair.a = sheet(dice, dice.between(2, 5), dice.between(2, 4), dice.chance(0.3) ? 0 : height);
  pair.b = sheet(dice, dice.between(3, 7), dice.between(3, 6), height);
  if (dice.chance(0.8))
    pair.a.positions[dice.below(static_cast<std::uint32_t>(pair.a.positions.size()))].z() += dice.power(-3, 0);
  if (dice.chance(0.3)) {
    const Mesh second = sheet(dice, dice.between(2, 4), dice.between(2, 4), height);
    const Vec3 lift(0, 0, dice.sign() * dice.power(-4, 0));
    const auto lifted = [&](std::uint32_t v) { return Vec3(second.positions[v] + lift); };
    for (const auto& [i, j, k] : second.triangles) add_triangle(pair.b, lifted(i), lifted(j), lifted(k));
  }
  damage(dice, pair.b);
  if (dice.chance(0.2)) damage(dice, pair.a);
  if (dice.chance(0.3)) std::swap(pair.a, pair.b);
}

constexpr Kind kKinds[] = {
    {"soup", make_soup},
    {"lattice", make_lattice},
    {"slivers", make_slivers},
    {"coplanar", make_coplanar},
    {"identical", make_identical},
    {"subset", make_subset},
    {"one ulp apart", make_ulp},
    {"recut", make_recut},
    {"split", make_split},
    {"duplicates", make_duplicates},
    {"degenerate", make_degenerate},
    {"medial", make_medial},
    {"needles", make_needles},
    {"near-parallel", make_near_parallel},
    {"touching", make_touching},
    {"sheets", make_sheets},
    {"fan", make_fan},
    {"deformed", make_deformed},
    {"layers", make_layers},
    {"many", make_many},
};

}  // namespace

std::span<const Kind> kinds() { return kKinds; }

void add_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({n, n + 1, n + 2});
}

Vec3 one_ulp_away(Dice& dice, const Vec3& p) {
  Vec3 q = p;
  for (int k = 0; k < 3; ++k) {
    const int way = dice.between(-1, 1);
    if (way != 0) q[k] = std::nextafter(q[k], way * std::numeric_limits<double>::infinity());
  }
  return q;
}

}  // namespace meshgauge::fuzz
