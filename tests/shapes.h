// Small meshes for tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "engine/mesh.h"

namespace meshgauge::shapes {

inline Mesh triangle(const Vec3& a, const Vec3& b, const Vec3& c) { return {{a, b, c}, {{0, 1, 2}}}; }

// The square [0,size]^2 in the plane z = height, made of n*n squares; `flip` cuts them along the other diagonal.
inline Mesh grid(std::uint32_t n, double size = 1, double height = 0, bool flip = false) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) mesh.positions.emplace_back(size * i / n, size * j / n, height);
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      if (flip) {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {b, d, c}});
      } else {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
      }
    }
  }
  return mesh;
}

// A sphere of `rings` times 2*`rings` quads, poles included. Half of the triangles at the poles are degenerate.
inline Mesh sphere(std::uint32_t rings, double radius = 1, const Vec3& centre = Vec3::Zero()) {
  Mesh mesh;
  const std::uint32_t around = 2 * rings;
  const double pi = std::acos(-1.0);
  for (std::uint32_t j = 0; j <= rings; ++j) {
    for (std::uint32_t i = 0; i <= around; ++i) {
      const double theta = pi * j / rings, phi = 2 * pi * (i % around) / around;
      mesh.positions.push_back(
          centre + radius * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  }
  for (std::uint32_t j = 0; j < rings; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * (around + 1) + i, b = a + 1, c = a + around + 1, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, c, d}, {a, d, b}});
    }
  }
  return mesh;
}

inline Mesh cube(double size = 1, const Vec3& corner = Vec3::Zero()) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(corner + size * Vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// n unconnected random triangles in [-1,1]^3.
inline Mesh soup(std::uint32_t n, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Mesh mesh;
  for (std::uint32_t t = 0; t < n; ++t) {
    for (int k = 0; k < 3; ++k) mesh.positions.emplace_back(uniform(random), uniform(random), uniform(random));
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return mesh;
}

// A sphere of which each pole is one place: closed.
inline Mesh closed_sphere(std::uint32_t rings, double radius = 1) {
  Mesh mesh = sphere(rings, radius);
  for (Vec3& p : mesh.positions) p = (p.array().abs() < 1e-12).select(0, p);
  return mesh;
}

// Both meshes as one.
inline Mesh joined(Mesh a, const Mesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

// The same triangles, facing the other way.
inline Mesh turned(Mesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

inline Mesh moved(Mesh mesh, const Vec3& by) {
  for (Vec3& p : mesh.positions) p += by;
  return mesh;
}

inline Mesh scaled(Mesh mesh, double factor) {
  for (Vec3& p : mesh.positions) p *= factor;
  return mesh;
}

// The same triangles, each with vertices of its own.
inline Mesh unwelded(const Mesh& mesh) {
  Mesh out;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) out.positions.push_back(mesh.positions[v]);
    out.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return out;
}

}  // namespace meshgauge::shapes
