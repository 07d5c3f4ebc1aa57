// Mesh: a triangle soup as two flat arrays. It need not be manifold, oriented or connected. A degenerate triangle is
// the segment or the point that it spans. A vertex that no triangle uses is not part of the surface. A point cloud is a
// mesh whose triangles are its points: each names one vertex three times.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "engine/control.h"
#include "engine/result.h"
#include "engine/vector.h"

namespace meshgauge {

using Triangle = std::array<std::uint32_t, 3>;  // indices into Mesh::positions

// The largest |coordinate| accepted. Distances stay below 2*sqrt(3)*2^1020 < 2^1022, so no result overflows.
inline constexpr double kMaxCoordinate = 0x1p1020;

struct Mesh {
  std::vector<Vec3> positions;  // the file's own unit
  std::vector<Triangle> triangles;
};

// A mesh in borrowed arrays, which must outlive every use of the view.
struct MeshView {
  std::span<const Vec3> positions;
  std::span<const Triangle> triangles;

  MeshView() = default;
  MeshView(std::span<const Vec3> p, std::span<const Triangle> t) : positions(p), triangles(t) {}
  // NOLINTNEXTLINE(google-explicit-constructor): a Mesh may be passed where a view is expected
  MeshView(const Mesh& mesh) : positions(mesh.positions), triangles(mesh.triangles) {}

  const Vec3& corner(std::size_t triangle, int i) const {
    return positions[triangles[triangle][static_cast<std::size_t>(i)]];
  }
};

// An axis-aligned box. By default empty.
struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void extend(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void extend(const Box& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
};

// Returns the triangles of a point cloud: (0,0,0), (1,1,1), ...
std::vector<Triangle> points_as_triangles(std::size_t count);

// Whether every triangle names one vertex three times. Constant time for a mesh whose first triangle does not.
bool is_cloud(MeshView mesh);

struct MeshLimits {
  std::size_t max_vertices = std::size_t{1} << 30;
  std::size_t max_triangles = std::size_t{1} << 30;
};

// Checks the preconditions of measure(): at least one triangle, every index in range, every coordinate that a triangle
// uses finite and at most kMaxCoordinate in magnitude, counts within `limits`. The Error names a defect and the mesh as
// `part` ("a", "b"); ErrorCode::out_of_time: interrupted. Linear time. This and the functions below poll `interrupted`
// every 131,072 elements.
Result<Done> validate(MeshView mesh, const MeshLimits& limits, std::string_view part,
                      const Interrupted& interrupted = never_interrupted);

// Returns the box of the vertices that triangles use; when interrupted, of some of them. Precondition: the mesh passes
// validate().
Box bounding_box(MeshView mesh, const Interrupted& interrupted = never_interrupted);

// The length of the diagonal of `box`, or of bounding_box(mesh), in their unit. Does not overflow.
double diagonal(const Box& box);
double diagonal(MeshView mesh);

// Whether the triangle has zero area: a repeated position, or (within rounding) collinear corners.
bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c);

// The number of triangles of zero area; too low when interrupted.
std::size_t count_degenerate(MeshView mesh, const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
