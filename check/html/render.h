// A mesh as a picture, coloured by distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "api/colour_map.h"
#include "check/html/camera.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // rows from above; transparent where nothing is
};

// Which side of its triangles a mesh shows when something of it is missing.
enum class Inside { unknown, front, back };  // front: corners run counterclockwise as they are seen

// The side that is seen much less than the other one, from where the whole mesh is seen. Linear, as rasterise().
Inside inside_of(MeshView mesh, const Camera& camera);

struct Paint {
  std::function<double(const Vec3&)> distance;  // of a point of the surface, in the meshes' unit; thread safe
  api::ColourScale scale;
  Inside inside = Inside::unknown;  // drawn darker
};

// Every pixel has the distance of its own piece of surface, whatever the triangles' size; what is above the limit is
// hatched as well as coloured, so that it can be told without colours. Lit from over the viewer's shoulder;
// steps in depth are outlined. Four samples a pixel. `cut`: see
// rasterise(). Deterministic, whatever the size of the pool; memory for the samples alone.
Image render(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool,
             double cut = std::numeric_limits<double>::infinity());

std::vector<std::byte> to_png(const Image& image);  // throws std::bad_alloc where memory is short

}  // namespace meshgauge::check
