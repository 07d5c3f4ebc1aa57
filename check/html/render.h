// Renders a mesh coloured by distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "api/map/colour_map.h"
#include "check/html/camera.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // rows from the top; transparent where there is no mesh
};

// The side of the triangles that is inside the part, visible where the part has a hole.
enum class Inside { unknown, front, back };  // front: corners run counterclockwise as seen

// Returns the side that the whole view shows much less of. Linear time, as rasterise().
Inside inside_of(MeshView mesh, const Camera& camera);

struct Paint {
  std::function<double(const Vec3&)> distance;  // distance of a point of the surface, in the meshes' unit; thread safe
  api::ColourScale scale;
  Inside inside = Inside::unknown;  // drawn darker
};

// Each pixel is coloured by the distance of its own point of the surface, whatever the triangles' size. Above the
// limit it is hatched too, so that colours are not needed. Light comes from behind the viewer; steps in depth are
// outlined. The points of a cloud are squares. Four samples per pixel. `cut`: see rasterise(). Deterministic for any
// size of the pool. Memory: the samples.
Image render(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool,
             double cut = std::numeric_limits<double>::infinity());

std::vector<std::byte> to_png(const Image& image);  // throws std::bad_alloc if memory is short

}  // namespace meshgauge::check
