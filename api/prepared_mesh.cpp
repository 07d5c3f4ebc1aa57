#include "api/prepared_mesh.h"

#include <utility>

namespace meshgauge::api {
namespace {

MeshFacts facts_of(const Prepared& mesh, const LoadedMesh& loaded, std::size_t file_bytes) {
  MeshFacts facts;
  facts.format = loaded.format;
  facts.bytes = file_bytes;
  facts.sha256 = loaded.sha256;
  facts.vertices = loaded.mesh.positions.size();
  facts.triangles = loaded.mesh.triangles.size();
  facts.degenerate = count_degenerate(loaded.mesh);
  facts.bbox = mesh.box();
  facts.diagonal = diagonal(facts.bbox);
  facts.notes = loaded.notes;
  return facts;
}

}  // namespace

PreparedMesh::PreparedMesh(LoadedMesh loaded, std::size_t file_bytes, Prepared::Use use)
    : mesh(loaded.mesh, use, std::move(loaded.arrays)), facts(facts_of(mesh, loaded, file_bytes)) {}

GetMesh loading(const Load& load, const MeshInput& input, const ReadLimits& limits, Prepared::Use use) {
  return [&load, &input, &limits, use](Control& control) -> Result<std::shared_ptr<const PreparedMesh>> {
    auto loaded = load(input, limits, control);
    if (!loaded) return std::move(loaded).error();
    return std::make_shared<const PreparedMesh>(std::move(*loaded), input.bytes.size(), use);
  };
}

}  // namespace meshgauge::api
