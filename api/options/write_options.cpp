#include "api/options/write_options.h"

#include <cstdint>
#include <utility>
#include <variant>

#include <nlohmann/json.hpp>

#include "api/options/table.h"

namespace meshgauge::api {
namespace {

void put(const Box& box, Json& json) {
  json["box"] = {{"min", api::json_of(box.low)}, {"max", api::json_of(box.high)}};
}
void put(const Sphere& sphere, Json& json) {
  json["sphere"] = {{"centre", api::json_of(sphere.centre)}, {"radius", sphere.radius}};
}
void put(const Group& group, Json& json) { json["group"] = group.name; }

Json span_of(const Span& span) {
  auto json = Json::object();
  if (span.min) json["min"] = *span.min;
  if (span.max) json["max"] = *span.max;
  return json;
}

Json count_of(const Span& span) {
  auto json = span.min && span.min == span.max ? Json(*span.min) : span_of(span);
  for (auto& end : json) end = static_cast<std::uint64_t>(end.get<double>());  // in kCountRange, of whole numbers
  return json;
}

}  // namespace

Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

Json number_or_null(const std::optional<double>& number) { return number ? Json(*number) : Json(nullptr); }

Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

Json json_of(const Tolerance& asked) {
  Json json = Json::object();
  if (asked.absolute) json["absolute"] = *asked.absolute;
  if (asked.diagonal) json["diagonal"] = *asked.diagonal;
  if (asked.relative) json["relative"] = *asked.relative;
  return json;
}

Json json_of(const Region& region) {
  Json json{{"name", region.name}};
  std::visit([&](const auto& shape) { put(shape, json); }, region.shape);
  if (region.max_distance) json["max_distance"] = *region.max_distance;
  return json;
}

Json json_of(const Expectations& expect) {
  auto json = Json::object();
  if (expect.watertight) json["watertight"] = *expect.watertight;
  if (expect.oriented) json["oriented"] = *expect.oriented;
  if (expect.triangles) json["triangles"] = count_of(*expect.triangles);
  if (expect.degenerate) json["degenerate"] = count_of(*expect.degenerate);
  if (expect.components) json["components"] = count_of(*expect.components);
  if (expect.volume) json["volume"] = span_of(*expect.volume);
  if (expect.volume_within) json["volume"]["within"] = *expect.volume_within;
  return json;
}

Json json_of(const RigidMotion& motion) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rows.push_back(motion.rotation(i, k));
    rows.push_back(motion.translation[i]);
  }
  for (const double last : {0, 0, 0, 1}) rows.push_back(last);
  return {{"row_major", rows}};
}

Json json_of(const AlignOptions& options) {
  Json json{{"fit", options.fit}};
  if (!options.fit || !options.start.is_identity()) json["transform"] = json_of(options.start);
  if (options.principal_axes) json["principal_axes"] = true;
  if (options.overlap < 1) json["overlap"] = options.overlap;
  return json;
}

Json gate_of(const ComparisonOptions& options) {
  if (!has_limit(options)) return nullptr;
  Json json{{"max_distance", nullptr}};
  for (const LimitOption& one : limit_options()) {
    if (Json value = one.write(options); !value.is_null()) json[std::string(one.key)] = std::move(value);
  }
  json["units"] = text_or_null(limit_unit_name(options.units));
  return json;
}

}  // namespace meshgauge::api
