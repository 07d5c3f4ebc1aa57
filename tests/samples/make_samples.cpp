// Writes the two sample meshes of ./dev run and the README: a sphere, and the same sphere coarser and with a dent.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace {

using Point = std::array<double, 3>;
using Face = std::array<std::uint32_t, 3>;

struct Sphere {
  std::vector<Point> points;
  std::vector<Face> faces;
};

Point on_sphere(Point p) {
  const double length = std::hypot(p[0], p[1], p[2]);
  return {p[0] / length, p[1] / length, p[2] / length};
}

Sphere octahedron() {
  return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

// Splits every triangle in four and moves the new points onto the sphere.
Sphere refined(const Sphere& coarse) {
  Sphere fine{coarse.points, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t i, std::uint32_t j) {
    const auto [entry, is_new] = middles.try_emplace(std::minmax(i, j), static_cast<std::uint32_t>(fine.points.size()));
    if (is_new) {
      const Point &p = fine.points[i], &q = fine.points[j];
      fine.points.push_back(on_sphere({p[0] + q[0], p[1] + q[1], p[2] + q[2]}));
    }
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.faces) {
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Face& face : {Face{a, ab, ca}, Face{ab, b, bc}, Face{ca, bc, c}, Face{ab, bc, ca}})
      fine.faces.push_back(face);
  }
  return fine;
}

Sphere sphere(int levels) {
  Sphere result = octahedron();
  for (int level = 0; level < levels; ++level) result = refined(result);
  return result;
}

// Makes a smooth dent, 0.1 deep, around the direction (1, 2, 2) / 3.
void dent(Sphere& mesh) {
  for (Point& p : mesh.points) {
    const double away = 1 - (p[0] + 2 * p[1] + 2 * p[2]) / 3;
    const double scale = 1 - 0.1 * std::exp(-20 * away);
    for (double& x : p) x *= scale;
  }
}

bool write_obj(const Sphere& mesh, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (!file) return std::perror(path.c_str()), false;
  for (const Point& p : mesh.points) std::fprintf(file, "v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
  for (const Face& f : mesh.faces) std::fprintf(file, "f %u %u %u\n", f[0] + 1, f[1] + 1, f[2] + 1);
  const bool written = !std::ferror(file);
  return (std::fclose(file) == 0 && written) || (std::perror(path.c_str()), false);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: make_samples FOLDER\n"), 2;
  const std::string folder = argv[1];
  Sphere dented = sphere(4);
  dent(dented);
  return write_obj(sphere(5), folder + "/sphere.obj") && write_obj(dented, folder + "/dented.obj") ? 0 : 1;
}
