#include "engine/mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace meshgauge {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 17;  // elements; a few ms even if each access misses the cache

// Calls each(first, end) for one block after another and polls `interrupted` between them. False: interrupted.
template <class Each>
bool in_blocks(std::size_t count, const Interrupted& interrupted, Each each) {
  for (std::size_t first = 0; first < count; first += kBlock) {
    if (first > 0 && interrupted()) return false;
    each(first, std::min(first + kBlock, count));
  }
  return true;
}

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

// A fast sufficient test: one pass over each array without branches, which the compiler vectorises. False for an
// invalid mesh, when interrupted, and for a valid mesh with a bad vertex that no triangle uses.
bool surely_valid(MeshView mesh, const Interrupted& interrupted) {
  std::uint32_t highest = 0;
  const bool all_indices = in_blocks(mesh.triangles.size(), interrupted, [&](std::size_t first, std::size_t end) {
    std::uint32_t high = 0;
    for (const Triangle& t : mesh.triangles.subspan(first, end - first)) high = std::max({high, t[0], t[1], t[2]});
    highest = std::max(highest, high);
  });
  if (!all_indices || highest >= mesh.positions.size()) return false;
  bool bad = false;
  const bool all_positions = in_blocks(mesh.positions.size(), interrupted, [&](std::size_t first, std::size_t end) {
    bool bad_here = false;
    for (const Vec3& p : mesh.positions.subspan(first, end - first)) {
      for (int k = 0; k < 3; ++k) bad_here |= !(std::abs(p[k]) <= kMaxCoordinate);  // true for NaN
    }
    bad |= bad_here;
  });
  return all_positions && !bad;
}

Vec3 cross_of(const Vec3& e, const Vec3& f) {
  return {e.y() * f.z() - e.z() * f.y(), e.z() * f.x() - e.x() * f.z(), e.x() * f.y() - e.y() * f.x()};
}

// A fast sufficient test, without divisions and roots: whether the computed area is above 2^-47 of the longest edge
// squared. The roundings here and in is_degenerate() together are below 2^-48 of it, so that is_degenerate() would find
// more than its 2^-50. False where a power of the edges could overflow or underflow.
bool surely_not_degenerate(const Vec3& e, const Vec3& f) {
  const double longest_sq = 2 * (squared_norm(e) + squared_norm(f));  // at least, also of the third edge
  const bool in_range = longest_sq > 0x1p-200 && longest_sq < 0x1p200;
  return in_range && squared_norm(cross_of(e, f)) > 0x1p-94 * longest_sq * longest_sq;
}

Result<Done> check_triangle(MeshView mesh, std::size_t triangle, std::string_view part) {
  for (const std::uint32_t index : mesh.triangles[triangle]) {
    if (index >= mesh.positions.size()) {
      return defect(ErrorCode::index_out_of_range, part, "triangle " + std::to_string(triangle),
                    "uses vertex " + std::to_string(index) + " of " + std::to_string(mesh.positions.size()));
    }
    if (auto ok = check_vertex(mesh.positions[index], index, part); !ok) return ok;
  }
  return Done{};
}

}  // namespace

std::vector<Triangle> points_as_triangles(std::size_t count) {
  std::vector<Triangle> points(count);
  for (std::size_t i = 0; i < count; ++i) points[i].fill(static_cast<std::uint32_t>(i));
  return points;
}

bool is_cloud(MeshView mesh) {
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [](const Triangle& t) { return t[0] == t[1] && t[1] == t[2]; });
}

Result<Done> validate(MeshView mesh, const MeshLimits& limits, std::string_view part, const Interrupted& interrupted) {
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
  if (surely_valid(mesh, interrupted)) return Done{};
  Result<Done> valid = Done{};
  const bool all = in_blocks(mesh.triangles.size(), interrupted, [&](std::size_t first, std::size_t end) {
    for (std::size_t t = first; t < end && valid.ok(); ++t) valid = check_triangle(mesh, t, part);
  });
  if (valid.ok() && !all) return Error{ErrorCode::out_of_time, "interrupted before " + quoted + " was checked", "", ""};
  return valid;
}

// Marks the used vertices, then goes through all of them in the order of memory: where triangles share vertices, that
// takes a third of the time of looking up each corner.
Box bounding_box(MeshView mesh, const Interrupted& interrupted) {
  Box box;
  box.extend(mesh.corner(0, 0));  // not empty when interrupted
  const bool shared = mesh.positions.size() < 2 * mesh.triangles.size();
  std::vector<std::uint8_t> used(shared ? mesh.positions.size() : 0);
  in_blocks(mesh.triangles.size(), interrupted, [&, marks = used.data()](std::size_t first, std::size_t end) {
    for (const Triangle& t : mesh.triangles.subspan(first, end - first)) {
      for (const std::uint32_t index : t) {
        if (shared) {
          marks[index] = 1;
        } else {
          box.extend(mesh.positions[index]);
        }
      }
    }
  });
  in_blocks(used.size(), interrupted, [&](std::size_t first, std::size_t end) {
    const Box before = box;
    Box even = before, odd = before;  // two, since a minimum waits for the one before it
    const auto position = [&](std::size_t v) -> const Vec3& { return used[v] ? mesh.positions[v] : before.low; };
    std::size_t v = first;
    for (; v + 1 < end; v += 2) even.extend(position(v)), odd.extend(position(v + 1));
    if (v < end) even.extend(position(v));
    even.extend(odd);
    box = even;
  });
  return box;
}

double diagonal(MeshView mesh) { return diagonal(bounding_box(mesh)); }

double diagonal(const Box& box) { return scaled_norm(box.high - box.low); }

// Collinear within rounding: the area is at most 2^-50 of the longest edge squared.
bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 e = b - a;
  Vec3 f = c - a;
  if (surely_not_degenerate(e, f)) return false;
  const double scale = std::max(e.lpNorm<Eigen::Infinity>(), f.lpNorm<Eigen::Infinity>());
  if (scale == 0) return true;
  e /= scale;
  f /= scale;
  const double longest_sq = std::max({squared_norm(e), squared_norm(f), squared_norm(f - e)});
  return norm(cross_of(e, f)) <= 0x1p-50 * longest_sq;
}

std::size_t count_degenerate(MeshView mesh, const Interrupted& interrupted) {
  std::size_t count = 0;
  in_blocks(mesh.triangles.size(), interrupted, [&](std::size_t first, std::size_t end) {
    for (std::size_t t = first; t < end; ++t) {
      count += is_degenerate(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    }
  });
  return count;
}

}  // namespace meshgauge
