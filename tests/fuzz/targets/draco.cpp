// KHR_draco_mesh_compression: a stream, as a primitive names it. Asserted: a mesh that is given has its corners in
// range and a value for each point; a refusal names the part; the same stream gives the same answer again.
#include <map>

#include "api/formats/gltf/gltf_draco.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace {

using namespace meshgauge;

void require_whole(const api::GltfDracoMesh& mesh, const api::ReadLimits& limits) {
  fuzz::require(mesh.corners.size() % 3 == 0, "whole triangles");
  fuzz::require(mesh.corners.size() / 3 <= limits.max_triangles && mesh.points <= limits.max_vertices,
                "counts are within the limits");
  for (const std::uint32_t corner : mesh.corners) fuzz::require(corner < mesh.points, "corners are in range");
  for (const auto& [name, column] : mesh.columns) {
    fuzz::require(column.count == mesh.points, "a value for each point");
    fuzz::require(column.count == 0 || column.bytes.size() % column.count == 0, "values of one size");
  }
}

}  // namespace

FUZZ_TARGET(draco) {
  const std::vector<std::uint8_t> exact(data, data + size);
  const auto bytes = std::as_bytes(std::span(exact));
  api::ReadLimits limits;
  limits.max_vertices = 100'000;
  limits.max_triangles = 100'000;
  limits.max_expanded_bytes = std::size_t{4} << 20;
  const api::Source source{bytes, "a", limits};
  const auto read = [&] {
    api::GltfBudget budget(source);
    return api::decode_draco(source, "meshes[0]", bytes, {{"POSITION", 0}}, budget);
  };
  const auto first = read();
  const auto again = read();
  fuzz::require(first.ok() == again.ok(), "the same stream gives the same answer");
  if (first) {
    require_whole(*first, limits);
    fuzz::require(first->corners == again->corners, "the same triangles");
  } else {
    fuzz::require(first.error().part == "a" && first.error().message == again.error().message,
                  "a refusal names the part", first.error().message);
  }
  return 0;
}
