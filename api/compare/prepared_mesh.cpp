#include "api/compare/prepared_mesh.h"

#include <utility>

namespace meshgauge::api {
namespace {

MeshFacts facts_of(const LoadedMesh& loaded, std::size_t file_bytes, const Interrupted& interrupted) {
  MeshFacts facts;
  facts.format = loaded.format;
  facts.bytes = file_bytes;
  facts.sha256 = loaded.sha256;
  facts.vertices = loaded.mesh.positions.size();
  if (!loaded.notes.cloud) {
    facts.triangles = loaded.mesh.triangles.size();
    facts.degenerate = count_degenerate(loaded.mesh, interrupted);
  }
  facts.bbox = bounding_box(loaded.mesh, interrupted);
  facts.diagonal = diagonal(facts.bbox);
  facts.notes = loaded.notes;
  return facts;
}

}  // namespace

PreparedMesh::PreparedMesh(LoadedMesh loaded, std::size_t file_bytes, Prepared::Use use, const Interrupted& interrupted)
    : facts(facts_of(loaded, file_bytes, interrupted)),
      groups(std::move(loaded.groups)),
      mesh(loaded.mesh, use, std::move(loaded.arrays), facts.bbox) {}

PreparedMesh::Image::Image(const Prepared& of, const Factor& its_factor, RoundedImage scaled)
    : factor(its_factor),
      positions(std::move(scaled.positions)),
      mesh({positions, of.mesh().triangles}, of.use(), nullptr, std::nullopt, scaled.error) {}

std::shared_ptr<const PreparedMesh::Image> PreparedMesh::image(const Factor& factor) const {
  const std::lock_guard lock(mutex_);
  return image_ && image_->factor == factor ? image_ : nullptr;
}

std::optional<Topology> PreparedMesh::topology(const Interrupted& interrupted) const {
  const Topology* known = topology_.get(interrupted, [&]() -> std::unique_ptr<const Topology> {
    const auto found = meshgauge::topology(mesh.mesh(), facts.bbox, interrupted);
    return found ? std::make_unique<const Topology>(*found) : nullptr;
  });
  return known ? std::optional(*known) : std::nullopt;
}

std::size_t PreparedMesh::bytes() const {
  const std::lock_guard lock(mutex_);
  const std::size_t of_image = image_ ? sizeof *image_ + image_->mesh.bytes() : 0;
  return sizeof *this - sizeof mesh + bytes_of(groups) + mesh.bytes() + of_image;
}

Result<std::shared_ptr<const Prepared>> in_unit(const SharedMesh& mesh, const std::string& part, const Factor& factor,
                                                Control& control) {
  if (factor.is_one()) return std::shared_ptr<const Prepared>(mesh, &mesh->mesh);
  auto image = mesh->image(factor);
  if (!image) {
    auto positions = scaled(mesh->mesh.mesh(), factor, [&control] { return control.check() != Interruption::none; });
    if (const auto ok = in_time(control, "'" + part + "' was converted to the unit of the result"); !ok)
      return ok.error();
    if (!positions) {
      return Error{ErrorCode::coordinate_too_large,
                   "'" + part + "' has coordinates too large for the unit of the result", part, ""};
    }
    image = std::make_shared<const PreparedMesh::Image>(mesh->mesh, factor, *std::move(positions));
    const std::lock_guard lock(mesh->mutex_);
    if (mesh->mesh.use() == Prepared::Use::often) mesh->image_ = image;
  }
  struct Held {
    SharedMesh mesh;  // owns the triangles
    std::shared_ptr<const PreparedMesh::Image> image;
  };
  const auto held = std::make_shared<const Held>(Held{mesh, std::move(image)});
  return std::shared_ptr<const Prepared>(held, &held->image->mesh);
}

Result<SharedMesh> prepare(Result<LoadedMesh> loaded, const MeshInput& input, Prepared::Use use, Control& control) {
  if (!loaded) return std::move(loaded).error();
  const auto interrupted = [&control] { return control.check() != Interruption::none; };
  auto mesh = std::make_shared<const PreparedMesh>(std::move(*loaded), input.bytes.size(), use, interrupted);
  if (const auto ok = in_time(control, "'" + input.part + "' was read"); !ok) return ok.error();
  return mesh;
}

}  // namespace meshgauge::api
