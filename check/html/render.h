// Renders a mesh coloured by distance.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "api/map/colour_map.h"
#include "check/html/camera.h"
#include "check/html/image.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

// The side of the triangles that is inside the part, visible where the part has a hole.
enum class Inside { unknown, front, back };  // front: corners run counterclockwise as seen

// Returns the side that the whole view shows much less of. Linear time, as rasterise().
Inside inside_of(MeshView mesh, const Camera& camera);

struct Paint {
  // The distance of a point of the surface, in the meshes' unit; thread safe. Empty: the surface is grey.
  std::function<double(const Vec3&)> distance;
  api::ColourScale scale;
  Inside inside = Inside::unknown;  // drawn darker
};

// Each pixel is coloured by the distance of its own point of the surface, whatever the triangles' size. Above the
// limit it is hatched too, so that colours are not needed. Light comes from behind the viewer; steps in depth are
// outlined. The points of a cloud are squares. Four samples per pixel. `cut`: see rasterise(). Deterministic for any
// size of the pool. Memory: the samples.
Image render(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool,
             double cut = std::numeric_limits<double>::infinity());

// The same, with the depth (Seen::depth) of what is visible at each pixel; -infinity where nothing is.
struct Rendered {
  Image image;
  std::vector<float> depth;
};
Rendered render_with_depth(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool,
                           double cut = std::numeric_limits<double>::infinity());

}  // namespace meshgauge::check
