#include "api/compare/align.h"

#include <utility>

#include "api/compare/load.h"
#include "api/options/parts.h"

namespace meshgauge::api {
namespace {

// A point of the mesh anywhere in its box is moved into the range.
bool keeps_range(const Box& box, const RigidMotion& motion) {
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = (corner >> k & 1) != 0 ? box.high[k] : box.low[k];
    if (!(motion(p).cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kMaxCoordinate)) return false;
  }
  return true;
}

Error too_far(const std::string& part) {
  return {ErrorCode::coordinate_too_large, "'" + part + "' has coordinates too large after its alignment", part, ""};
}

}  // namespace

Json json_of(const Aligned& aligned, const AlignOptions& asked) {
  const Alignment& found = aligned.found;
  Json json{{"moved", "a"},
            {"method", asked.fit ? "best_fit" : "given"},
            {"transform", json_of(found.motion)},
            {"angle_degrees", aligned.moved.angle},
            {"shift", aligned.moved.shift},
            {"largest_displacement", aligned.moved.largest},
            {"residual", found.residual},
            {"residual_before", found.before},
            {"samples", found.samples},
            {"principal_axes", asked.principal_axes},
            {"overlap", asked.overlap},
            {"converged", found.converged},
            {"steps", found.steps},
            {"starts", found.starts}};
  if (asked.fit && !asked.start.is_identity()) json["start"] = json_of(asked.start);
  return json;
}

bool is_alignment_by(const Json& alignment, const AlignOptions& asked) {
  const Json wanted = json_of(Aligned{{asked.start}, {}}, asked);
  const auto same = [&](const char* name) { return alignment.value(name, Json()) == wanted.value(name, Json()); };
  return alignment.is_object() && same("moved") && same("method") && same("principal_axes") && same("overlap") &&
         (same("start") || !alignment.contains("start")) && (asked.fit || same("transform"));
}

Result<std::optional<RigidMotion>> motion_of(const Json& document) {
  const auto alignment = document.find("alignment");
  if (alignment == document.end() || alignment->is_null()) return std::optional<RigidMotion>();
  const Json transform = alignment->is_object() ? alignment->value("transform", Json()) : Json();
  Reading reading(kHttp);
  const auto motion = read_transform(JsonValue(transform), "/alignment/transform", reading);
  if (motion) return motion;
  return Error{ErrorCode::internal, "the result is not that of a comparison: " + reading.mistakes.front().message, "",
               ""};
}

Result<std::shared_ptr<const Prepared>> moved(const std::shared_ptr<const Prepared>& mesh, const RigidMotion& motion,
                                              const std::string& part, Control& control) {
  if (motion.is_identity()) return mesh;
  const auto stop = [&control] { return control.check() != Interruption::none; };
  auto image = meshgauge::moved(mesh->mesh(), motion, mesh->error(), stop);
  if (auto ok = in_time(control, "'" + part + "' was moved"); !ok) return ok.error();
  if (!image) return too_far(part);
  struct Held {
    std::shared_ptr<const Prepared> mesh;  // owns the triangles
    std::vector<Vec3> positions;
  };
  const auto held = std::make_shared<const Held>(Held{mesh, std::move(image->positions)});
  const MeshView view(held->positions, mesh->mesh().triangles);
  return std::make_shared<const Prepared>(view, Prepared::Use::once, held, std::nullopt, image->error);
}

Result<Aligned> aligned(const Prepared& candidate, const Prepared& baseline, const AlignOptions& asked,
                        const Options& options, const std::string& part, Control& control) {
  if (!keeps_range(candidate.box(), asked.start) || !keeps_range(baseline.box(), asked.start.inverse()))
    return too_far(part);
  const auto stop = [&control] { return control.check() != Interruption::none; };
  const auto found = align(candidate, baseline, asked, options.threads, options.simd, control);
  const auto distance = found ? displacement(candidate.mesh(), candidate.box(), found->motion, stop) : std::nullopt;
  if (!distance) return not_in_time(control.check(), "'" + part + "' was aligned");
  return Aligned{*found, *distance};
}

}  // namespace meshgauge::api
