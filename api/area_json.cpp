#include "api/area_json.h"

#include <nlohmann/json.hpp>

#include "api/figures.h"
#include "api/names.h"
#include "api/with_unit.h"

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

Json of_side(const SideBounds& found) {
  Json json = of_interval({found.lower, found.upper});
  json["point_a"] = found.at ? json_of(*found.at) : Json(nullptr);
  json["triangle_a"] = found.at ? Json(found.triangle) : Json(nullptr);
  return json;
}

}  // namespace

std::string in_words(const NoSides& refused, const std::optional<LengthUnit>& unit) {
  using Why = NoSides::Why;
  std::string at;
  if (const auto& p = refused.at) at = with_unit(in_words(*p), unit);
  switch (refused.why) {
    case Why::open:
      return "mesh b is open: an edge at " + at + " has one triangle";
    case Why::non_manifold:
      return "mesh b is not manifold: an edge at " + at + " has more than two triangles";
    case Why::flipped:
      return "mesh b is not oriented: two triangles at " + at + " face different ways";
    case Why::inside_out:
      return "mesh b is inside out: its triangles face inwards";
    case Why::no_volume:
      return "mesh b encloses no volume";
    default:
      return "mesh b has a part that is inside out: it faces inwards around " + at;
  }
}

Json json_of(const SideOutcome& sides, const std::optional<LengthUnit>& unit) {
  const auto& refused = sides.refused;
  Json why = nullptr;
  if (refused)
    why = {{"reason", name_of(kNoSides, refused->why)},
           {"detail", in_words(*refused, unit)},
           {"at", refused->at ? json_of(*refused->at) : Json(nullptr)}};
  return {{"certified", true},
          {"status", name_of(kAreaStops, sides.stop)},
          {"length_tolerance", sides.options.length_tolerance},
          {"pieces", sides.pieces},
          {"refused", std::move(why)},
          {"outside", refused ? Json(nullptr) : of_side(sides.outside)},
          {"inside", refused ? Json(nullptr) : of_side(sides.inside)}};
}

Json json_of(const AreaOutcome& areas) {
  return {{"certified", true},
          {"share_tolerance", areas.options.share_tolerance},
          {"length_tolerance", areas.options.length_tolerance},
          {"a_to_b", of_direction(areas.a_to_b, areas.options)},
          {"b_to_a", of_direction(areas.b_to_a, areas.options)}};
}

}  // namespace meshgauge::api
