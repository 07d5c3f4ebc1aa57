// Sizes from which strategy `auto` and the area search try what pays for large meshes alone.
//
// They decide how fast a measurement is, never whether its interval holds. Only tests change them, so that small
// meshes, for which an exact oracle is quick, reach every bound.
#pragma once

#include <cstddef>

namespace meshgauge {

struct Thresholds {
  std::size_t block = 64;             // triangles of A in a block of the sweep: some 0.1 ms at most
  std::size_t adjacency = 64;         // failed certificates in the sweep below which no adjacency is made
  std::size_t patches = 1000;         // triangles expected to fail below which no patch certificate is tried
  std::size_t triangles_a_patch = 8;  // triangles of a block below which no patch is projected
  std::size_t patch_group = 4;        // triangles of A of similar normals: a smaller group is not worth its projection
  std::size_t area_sample = 2048;     // triangles of the sample that an area search begins with
  std::size_t area_samples = 16;      // so many times as many triangles as the sample: of fewer none is taken
};

}  // namespace meshgauge
