#include "api/area_json.h"

#include <nlohmann/json.hpp>

#include "api/names.h"

namespace meshgauge::api {
namespace {

Json of_interval(const AreaInterval& found) { return interval(found.lower, found.upper); }

Json of_direction(const std::optional<AreaBounds>& found, const AreaOptions& asked) {
  if (!found) return nullptr;
  Json json{{"status", name_of(kAreaStops, found->stop)}, {"pieces", found->pieces}};
  Json beyond = Json::array(), quantiles = Json::array();
  for (std::size_t k = 0; k < found->beyond.size(); ++k) {
    beyond.push_back({{"distance", asked.beyond[k].distance}, {"share", of_interval(found->beyond[k])}});
  }
  for (std::size_t q = 0; q < found->quantiles.size(); ++q) {
    quantiles.push_back({{"share", asked.quantiles[q]}, {"distance", of_interval(found->quantiles[q])}});
  }
  json["beyond"] = std::move(beyond);
  json["quantiles"] = std::move(quantiles);
  json["mean"] = found->mean ? of_interval(*found->mean) : Json(nullptr);
  json["rms"] = found->rms ? of_interval(*found->rms) : Json(nullptr);
  return json;
}

}  // namespace

Json json_of(const AreaOutcome& areas) {
  return {{"certified", true},
          {"share_tolerance", areas.options.share_tolerance},
          {"length_tolerance", areas.options.length_tolerance},
          {"a_to_b", of_direction(areas.a_to_b, areas.options)},
          {"b_to_a", of_direction(areas.b_to_a, areas.options)}};
}

}  // namespace meshgauge::api
