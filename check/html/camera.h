// From where a mesh is looked at: an orthographic camera, so that lengths can be taken from the picture.
#pragma once

#include <optional>
#include <span>

#include "engine/frame.h"
#include "engine/mesh.h"

namespace meshgauge::check {

// A point as the camera sees it: pixels from the upper left corner, and how far towards the viewer it lies, in pixels.
struct Seen {
  double x = 0;
  double y = 0;
  double depth = 0;
};

// The axes of the picture, orthonormal.
struct View {
  Vec3 right = Vec3::UnitX();
  Vec3 up = Vec3::UnitY();
  Vec3 toward = Vec3::UnitZ();  // the viewer
};

// Works in the frame of the meshes (engine/frame.h), so that a part far from the origin, or a tiny or a huge one, is
// drawn as exactly as any.
struct Camera {
  Frame frame;
  View view;
  Vec3 centre = Vec3::Zero();  // of the picture, in the frame
  double pixels_per_unit = 1;  // of the frame
  int width = 1;
  int height = 1;

  Seen see(const Vec3& p) const {
    const Vec3 q = frame.to_frame(p) - centre;
    return {0.5 * width + pixels_per_unit * q.dot(view.right), 0.5 * height - pixels_per_unit * q.dot(view.up),
            pixels_per_unit * q.dot(view.toward)};
  }
  // Of one pixel, in the meshes' unit.
  double pixel_size() const;
};

// A place that is to be seen.
struct Sight {
  MeshView mesh;
  Vec3 point = Vec3::Zero();  // on the mesh or near to it
};

struct ChosenView {
  View view;
  bool hidden = false;  // from everywhere: the first point lies inside of its mesh
};

// Of some sixty views all around, the one that has nothing of its mesh between the viewer and the first point, where
// possible neither before the second one, looks onto the surface rather than along it, and shows much of the first
// mesh. `normal`: of the surface at the first point, of either side; zero if it has none. `up` is the axis that people
// stand the part on: 1 (y) or 2 (z). Linear time.
ChosenView choose_view(const Sight& first, const std::optional<Sight>& second, const Frame& frame, const Vec3& normal,
                       int up);

// Whether something of the mesh lies between the point and the viewer. O(n).
bool covered(MeshView mesh, const Frame& frame, const View& view, const Vec3& point);

// The whole mesh and the points, with a margin. Linear time.
Camera whole_view(MeshView mesh, const Frame& frame, const View& view, std::span<const Vec3> points, int width,
                  int height);

// Looks at `centre` with `reach` (in the meshes' unit) to each side of it that is the nearer.
Camera close_view(const Camera& whole, const Vec3& centre, double reach, int width, int height);

}  // namespace meshgauge::check
