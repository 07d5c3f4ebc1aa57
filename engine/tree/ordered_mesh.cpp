#include "engine/tree/ordered_mesh.h"

#include <algorithm>
#include <limits>

#include "engine/mesh/mesh_index.h"
#include "engine/tree/curve.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();

}  // namespace

OrderedMesh::OrderedMesh(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& original_box,
                         const Frame& frame, Control& control, ThreadPool& pool)
    : box{frame.to_frame(original_box.low), frame.to_frame(original_box.high)},
      original(curve_order(mesh, chosen, original_box, control, pool)),
      given(mesh.triangles.size()) {
  LargeArray<std::uint32_t> renumbered(mesh.positions.size());
  const auto interrupted = [&] { return control.check() != Interruption::none; };
  const auto forget = [numbers = renumbered.data()](std::uint32_t v) { numbers[v] = kUnseen; };
  if (!each_unless(interrupted, renumbered.size(), forget)) return;
  positions.resize(std::min(mesh.positions.size(), 3 * original.size()));
  triangles.resize(original.size());
  std::uint32_t used = 0;
  const auto take = [&used, mesh, frame, from = original.data(), numbers = renumbered.data(), points = positions.data(),
                     to = triangles.data()](std::uint32_t i) {
    Triangle triangle = mesh.triangles[from[i]];
    for (std::uint32_t& v : triangle) {
      if (numbers[v] == kUnseen) {
        points[used] = frame.to_frame(mesh.positions[v]);
        numbers[v] = used++;
      }
      v = numbers[v];
    }
    to[i] = triangle;
  };
  const bool done = each_unless(interrupted, original.size(), take);
  positions.resize(used);
  if (!done) triangles.clear();
}

}  // namespace meshgauge
