#include "engine/ordered_mesh.h"

#include <algorithm>
#include <limits>

#include "engine/curve.h"

namespace meshgauge {
namespace {

constexpr std::size_t kCheckEvery = std::size_t{1} << 15;  // triangles between two checks of the clock, about 1 ms
constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();

}  // namespace

OrderedMesh::OrderedMesh(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& original_box,
                         const Frame& frame, Control& control, ThreadPool& pool)
    : box{frame.to_frame(original_box.low), frame.to_frame(original_box.high)},
      original(curve_order(mesh, chosen, original_box, control, pool)),
      given(mesh.triangles.size()) {
  LargeArray<std::uint32_t> renumbered(mesh.positions.size(), kUnseen);
  positions.reserve(std::min(mesh.positions.size(), 3 * original.size()));
  triangles.reserve(original.size());
  for (std::size_t i = 0; i < original.size(); ++i) {
    if (i % kCheckEvery == kCheckEvery - 1 && control.check() != Interruption::none) {
      triangles.clear();
      return;
    }
    Triangle triangle = mesh.triangles[original[i]];
    for (std::uint32_t& v : triangle) {
      if (renumbered[v] == kUnseen) {
        renumbered[v] = static_cast<std::uint32_t>(positions.size());
        positions.push_back(frame.to_frame(mesh.positions[v]));
      }
      v = renumbered[v];
    }
    triangles.push_back(triangle);
  }
}

}  // namespace meshgauge
