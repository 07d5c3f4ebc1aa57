#include "engine/mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace meshgauge {
namespace {

Error defect(ErrorCode code, std::string_view part, std::string where, const std::string& what) {
  return Error{code, where + " of '" + std::string(part) + "' " + what, std::string(part), std::move(where)};
}

Result<Done> check_vertex(const Vec3& p, std::uint32_t index, std::string_view part) {
  const auto name = [&] { return "vertex " + std::to_string(index); };
  for (int k = 0; k < 3; ++k) {
    const double x = p[k];
    if (std::isnan(x)) return defect(ErrorCode::non_finite_vertex, part, name(), "is NaN");
    if (std::isinf(x)) return defect(ErrorCode::non_finite_vertex, part, name(), "is infinite");
    if (std::abs(x) > kMaxCoordinate) {
      return defect(ErrorCode::coordinate_too_large, part, name(), "has a coordinate beyond 2^1020 (about 1.1e307)");
    }
  }
  return Done{};
}

// One pass over each array without a branch, which the compiler vectorises: true for nearly every mesh. A vertex
// that no triangle uses may make it false for a mesh that is valid.
bool surely_valid(MeshView mesh) {
  std::uint32_t highest = 0;
  for (const Triangle& t : mesh.triangles) highest = std::max({highest, t[0], t[1], t[2]});
  if (highest >= mesh.positions.size()) return false;
  bool bad = false;
  for (const Vec3& p : mesh.positions) {
    for (int k = 0; k < 3; ++k) bad |= !(std::abs(p[k]) <= kMaxCoordinate);  // true for NaN
  }
  return !bad;
}

// Collinear within rounding: the area is at most 2^-50 of the longest edge squared.
bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 e = b - a;
  Vec3 f = c - a;
  const double scale = std::max(e.lpNorm<Eigen::Infinity>(), f.lpNorm<Eigen::Infinity>());
  if (scale == 0) return true;
  e /= scale;
  f /= scale;
  const double longest_sq = std::max({e.squaredNorm(), f.squaredNorm(), (f - e).squaredNorm()});
  const Vec3 cross(e.y() * f.z() - e.z() * f.y(), e.z() * f.x() - e.x() * f.z(), e.x() * f.y() - e.y() * f.x());
  return cross.norm() <= 0x1p-50 * longest_sq;
}

}  // namespace

Result<Done> validate(MeshView mesh, const MeshLimits& limits, std::string_view part) {
  const std::string quoted = "'" + std::string(part) + "'";
  if (mesh.triangles.empty()) {
    return Error{ErrorCode::empty_mesh, quoted + " has no triangles", std::string(part), ""};
  }
  if (mesh.positions.size() > limits.max_vertices) {
    return Error{ErrorCode::too_large,
                 quoted + " has " + std::to_string(mesh.positions.size()) + " vertices, more than the limit of " +
                     std::to_string(limits.max_vertices),
                 std::string(part), ""};
  }
  if (mesh.triangles.size() > limits.max_triangles) {
    return Error{ErrorCode::too_large,
                 quoted + " has " + std::to_string(mesh.triangles.size()) + " triangles, more than the limit of " +
                     std::to_string(limits.max_triangles),
                 std::string(part), ""};
  }
  if (surely_valid(mesh)) return Done{};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t index : mesh.triangles[t]) {
      if (index >= mesh.positions.size()) {
        return defect(ErrorCode::index_out_of_range, part, "triangle " + std::to_string(t),
                      "uses vertex " + std::to_string(index) + " of " + std::to_string(mesh.positions.size()));
      }
      if (auto ok = check_vertex(mesh.positions[index], index, part); !ok) return ok;
    }
  }
  return Done{};
}

Box bounding_box(MeshView mesh) {
  Box box;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t index : t) box.extend(mesh.positions[index]);
  }
  return box;
}

double diagonal(MeshView mesh) { return diagonal(bounding_box(mesh)); }

double diagonal(const Box& box) {
  const Vec3 size = box.high - box.low;
  return std::hypot(size.x(), size.y(), size.z());
}

std::size_t count_degenerate(MeshView mesh) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    count += is_degenerate(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
  }
  return count;
}

}  // namespace meshgauge
