#include "api/align.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "api/decimal.h"
#include "api/json_filter.h"
#include "api/load.h"
#include "api/refused.h"
#include "api/request.h"

namespace meshgauge::api {
namespace {

using JsonValue = nlohmann::json;
using Json = nlohmann::ordered_json;
using Numbers = std::array<double, 16>;

constexpr std::string_view kRowMajor = "row_major", kColumnMajor = "column_major";
constexpr Range kOverlapRange{0.1, 1};
constexpr Range kEntryRange{-kMaxCoordinate, kMaxCoordinate};

Error wrong(const std::string& name, const std::string& what) { return refused(name + " " + what, "options", name); }

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

Result<Numbers> read_numbers(const JsonValue& value, const std::string& name) {
  Numbers numbers{};
  if (!value.is_array() || value.size() != numbers.size()) {
    return wrong(name, "must be an array of 16 numbers, not " +
                           (value.is_array() ? "one of " + std::to_string(value.size()) : shown(value)));
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string place = name + "/" + std::to_string(i);
    if (!value[i].is_number()) return wrong(place, "must be a number, not " + shown(value[i]));
    const auto number = in_range(value[i].get<double>(), kEntryRange, place);
    if (!number) return number.error();
    numbers[i] = *number;
  }
  return numbers;
}

// `rows`: row by row.
Result<RigidMotion> motion_of(const Numbers& rows, const std::string& name) {
  if (rows[12] != 0 || rows[13] != 0 || rows[14] != 0 || rows[15] != 1) {
    const bool other = rows[3] == 0 && rows[7] == 0 && rows[11] == 0;
    return wrong(name, "must end with the row 0 0 0 1, not " + shortest(rows[12]) + " " + shortest(rows[13]) + " " +
                           shortest(rows[14]) + " " + shortest(rows[15]) +
                           (other ? "; as it is written, it has the other order of row_major and column_major" : ""));
  }
  RigidMotion motion;
  for (int i = 0; i < 3; ++i) {
    const double* const row = rows.data() + 4 * i;
    motion.rotation.row(i) = Eigen::RowVector3d(row[0], row[1], row[2]);
    motion.translation[i] = row[3];
  }
  const double off = off_orthonormal(motion.rotation);
  if (!(off <= kMostOffOrthonormal)) {
    return wrong(name, "must be rigid, but its 3x3 part R scales or shears: R^T R is off the identity by " +
                           shortest(off) + " (limit " + shortest(kMostOffOrthonormal) +
                           "; write at least six decimals)");
  }
  if (motion.rotation.determinant() < 0) return wrong(name, "must be rigid, but it mirrors: its determinant is -1");
  if (off > RigidMotion::kOrthonormal) motion.rotation = nearest_rotation(motion.rotation);
  return motion;
}

Result<RigidMotion> read_transform(const JsonValue& value, const std::string& name) {
  const bool is_one = value.is_object() && value.size() == 1;
  const std::string order = is_one ? value.begin().key() : "";
  if (order != kRowMajor && order != kColumnMajor) {
    return wrong(name, "must be an object with the 16 numbers of a 4x4 matrix as row_major or as column_major, not " +
                           (is_one ? shown_text(order) : shown(value)));
  }
  auto numbers = read_numbers(value.front(), name + "/" + order);
  if (!numbers) return numbers.error();
  if (order == kColumnMajor) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < i; ++k) std::swap((*numbers)[4 * i + k], (*numbers)[4 * k + i]);
    }
  }
  return motion_of(*numbers, name + "/" + order);
}

Result<bool> read_bool(const JsonValue& value, const std::string& name) {
  if (!value.is_boolean()) return wrong(name, "must be true or false, not " + shown(value));
  return value.get<bool>();
}

Result<std::optional<AlignOptions>> read_object(const JsonValue& value, const std::string& name) {
  AlignOptions options;
  options.fit = !value.contains("transform");
  std::string needs_fit;
  for (const auto& [key, member] : value.items()) {
    const std::string place = name + "/" + key;
    if (key == "transform") {
      const auto motion = read_transform(member, place);
      if (!motion) return motion.error();
      options.start = *motion;
    } else if (key == "fit" || key == "principal_axes") {
      const auto is = read_bool(member, place);
      if (!is) return is.error();
      (key == "fit" ? options.fit : options.principal_axes) = *is;
      if (key == "principal_axes" && *is) needs_fit = place;
    } else if (key == "overlap") {
      if (!member.is_number()) return wrong(place, "must be a number from 0.1 to 1, not " + shown(member));
      const auto overlap = in_range(member.get<double>(), kOverlapRange, place);
      if (!overlap) return overlap.error();
      options.overlap = *overlap;
      needs_fit = place;
    } else {
      return wrong(place, "is unknown; known: transform, fit, principal_axes, overlap");
    }
  }
  if (options.fit) return std::optional(options);
  if (!value.contains("transform")) return wrong(name + "/fit", "is false, so " + name + " needs a transform");
  if (!needs_fit.empty()) return wrong(needs_fit, "is for a best fit: with a transform, add \"fit\": true");
  return std::optional(options);
}

}  // namespace

Result<std::optional<AlignOptions>> read_align(const JsonValue& value, const std::string& name) {
  if (value == "none") return std::optional<AlignOptions>();
  if (value == "rigid") return std::optional(AlignOptions());
  if (value.is_object()) return read_object(value, name);
  return wrong(name,
               "must be none, rigid, or an object of transform, fit, principal_axes, overlap; not " + shown(value));
}

Json json_of(const RigidMotion& motion) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rows.push_back(motion.rotation(i, k));
    rows.push_back(motion.translation[i]);
  }
  for (const double last : {0, 0, 0, 1}) rows.push_back(last);
  return {{std::string(kRowMajor), rows}};
}

Json json_of(const AlignOptions& options) {
  Json json{{"fit", options.fit}};
  if (!options.fit || !options.start.is_identity()) json["transform"] = json_of(options.start);
  if (options.principal_axes) json["principal_axes"] = true;
  if (options.overlap < 1) json["overlap"] = options.overlap;
  return json;
}

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
  const auto motion = read_transform(JsonValue(transform), "alignment/transform");
  if (motion) return std::optional(*motion);
  return Error{ErrorCode::internal, "the result is not that of a comparison: " + motion.error().message, "", ""};
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
