// An orthographic camera: lengths can be measured in its pictures.
#pragma once

#include <optional>
#include <span>

#include "engine/mesh.h"
#include "engine/mesh/frame.h"

namespace meshgauge::check {

// A point as the camera sees it: pixels from the upper left corner, and its depth towards the viewer, in pixels.
struct Seen {
  double x = 0;
  double y = 0;
  double depth = 0;
};

// The axes of the picture, orthonormal.
struct View {
  Vec3 right = Vec3::UnitX();
  Vec3 up = Vec3::UnitY();
  Vec3 toward = Vec3::UnitZ();  // towards the viewer
};

// Works in the frame of the meshes (engine/mesh/frame.h), so that precision does not depend on a mesh's position or
// size.
struct Camera {
  Frame frame;
  View view;
  Vec3 centre = Vec3::Zero();  // middle of the picture, in the frame
  double pixels_per_unit = 1;  // pixels per unit of the frame
  int width = 1;
  int height = 1;

  Seen see(const Vec3& p) const {
    const Vec3 q = frame.to_frame(p) - centre;
    return {0.5 * width + pixels_per_unit * q.dot(view.right), 0.5 * height - pixels_per_unit * q.dot(view.up),
            pixels_per_unit * q.dot(view.toward)};
  }
  // Size of one pixel, in the meshes' unit.
  double pixel_size() const;
};

// A point that should be visible.
struct Sight {
  MeshView mesh;
  Vec3 point = Vec3::Zero();  // on the mesh or near it
};

struct ChosenView {
  View view;
  bool hidden = false;  // hidden in every view: the first point lies inside its mesh
};

// Chooses among about sixty views all around. In the chosen view nothing of the mesh covers the first point and,
// where possible, the second; it faces the surface and shows much of the first mesh. `normal`: normal of the surface
// at the first point, of either sign; zero if there is none. `up`: the vertical axis, 1 (y) or 2 (z). Linear time.
ChosenView choose_view(const Sight& first, const std::optional<Sight>& second, const Frame& frame, const Vec3& normal,
                       int up);

// Whether the mesh covers the point in this view. Linear time.
bool covered(MeshView mesh, const Frame& frame, const View& view, const Vec3& point);

// Returns a camera that shows the whole mesh and the points, with a margin. Linear time.
Camera whole_view(MeshView mesh, const Frame& frame, const View& view, std::span<const Vec3> points, int width,
                  int height);
// The same of several meshes.
Camera common_view(std::span<const MeshView> meshes, const Frame& frame, const View& view, std::span<const Vec3> points,
                   int width, int height);

// Returns a camera centred on `centre` that shows `reach` (in the meshes' unit) to the nearer edges.
Camera close_view(const Camera& whole, const Vec3& centre, double reach, int width, int height);

}  // namespace meshgauge::check
