#include "api/region_json.h"

#include <variant>

#include "api/gate.h"
#include "api/names.h"

namespace meshgauge::api {
namespace {

void put(const Box& box, Json& json) {
  json["box"] = {{"min", api::json_of(box.low)}, {"max", api::json_of(box.high)}};
}
void put(const Sphere& sphere, Json& json) {
  json["sphere"] = {{"centre", api::json_of(sphere.centre)}, {"radius", sphere.radius}};
}
void put(const Group& group, Json& json) { json["group"] = group.name; }

Json measured(const RegionOutcome& found, const std::optional<double>& limit, double uncertainty) {
  const auto directed = [](const std::optional<Bounds>& bounds) {
    return bounds ? api::json_of(*bounds) : Json(nullptr);
  };
  Json json{{"distance", interval(found.lower, found.upper)},
            {"status", name_of(kStops, found.stop)},
            {"empty", found.empty},
            {"precision_floor", found.precision_floor},
            {"a_to_b", directed(found.a_to_b)},
            {"b_to_a", directed(found.b_to_a)},
            {"verdict", nullptr}};
  if (limit) json["verdict"] = to_string(verdict_within(found.lower, found.upper, *limit, uncertainty));
  return json;
}

}  // namespace

Json json_of(const Region& region) {
  Json json{{"name", region.name}};
  std::visit([&](const auto& shape) { put(shape, json); }, region.shape);
  if (region.max_distance) json["max_distance"] = *region.max_distance;
  return json;
}

Json regions_of(const Outcome& outcome, const ComparisonOptions& options) {
  Json all = Json::array();
  for (std::size_t i = 0; i < outcome.regions.size(); ++i) {
    Json json = i < options.regions.size() ? json_of(options.regions[i]) : Json{{"name", kRest}};
    const auto limit = limit_of_region(options, i);
    if (limit) json["max_distance"] = *limit;
    json.update(measured(outcome.regions[i], limit, options.uncertainty));
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace meshgauge::api
