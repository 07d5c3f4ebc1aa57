// One picture of a gate, for places that show no more: before, after and the difference, side by side.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "api/map/colour_map.h"
#include "check/html/camera.h"
#include "check/html/image.h"
#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

constexpr int kStripViewWidth = 320, kStripViewHeight = 240;  // of each view
constexpr std::size_t kStripBytes = 200'000;                  // of a PNG

// A mesh, and the distance of its points to the other one; empty: the gate does not measure it.
struct StripMesh {
  MeshView mesh;
  std::function<double(const Vec3&)> distance;  // as Paint::distance
};

struct StripScene {
  StripMesh candidate;
  StripMesh baseline;
  Camera camera;  // of all views, kStripViewWidth x kStripViewHeight
  api::ColourScale scale;
  std::optional<Seen> mark;  // what the difference points at
};

// Draws the baseline and the candidate in grey, then both in one view: the candidate coloured by its distance, and the
// baseline translucent where it is not the same surface, coloured too if its distance is known. Where the gate measures
// the baseline alone, the two change places there. Opaque, so that it looks the same in a dark and in a light page.
// Deterministic for any size of the pool.
Image strip_of(const StripScene& scene, ThreadPool& pool);

}  // namespace meshgauge::check
