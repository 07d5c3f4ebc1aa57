#include "api/request.h"

#include "api/align.h"
#include "api/json_filter.h"
#include "api/json_of.h"
#include "api/names.h"
#include "api/refused.h"
#include "api/region_json.h"

namespace meshgauge::api {
namespace {

Json gate_of(const ComparisonOptions& options) {
  Json json = Json::object();
  if (options.max_distance) json["max_distance"] = *options.max_distance;
  if (const auto& limit = options.max_share_beyond) json["max_share_beyond"] = json_of(*limit);
  if (options.zone) json["zone"] = json_of(*options.zone);
  if (options.uncertainty > 0) json["uncertainty"] = options.uncertainty;
  const std::string_view unit = limit_unit_name(options.units);
  if (!unit.empty()) json["units"] = unit;
  json["narrow"] = options.narrow;
  return json;
}

Json units_of(const AskedUnits& declared) {
  Json json = Json::object();
  if (declared.a) json["a"] = to_string(*declared.a);
  if (declared.b) json["b"] = to_string(*declared.b);
  return json;
}

// Writes only what differs from the engine's defaults: the service may have a smaller limit.
Json budget_of(const Options& options) {
  const Options usual;
  Json json = Json::object();
  if (options.max_work_items != usual.max_work_items) json["work_items"] = options.max_work_items;
  if (options.max_memory_bytes != usual.max_memory_bytes) json["memory_bytes"] = options.max_memory_bytes;
  return json;
}

Json areas_of(const AreaOptions& areas) {
  Json json = Json::object();
  for (const AreaOptions::Beyond& beyond : areas.beyond) json["beyond"].push_back(beyond.distance);
  if (!areas.quantiles.empty()) json["quantiles"] = areas.quantiles;
  if (areas.mean) json["mean"] = true;
  json["share_tolerance"] = areas.share_tolerance;
  json["length_tolerance"] = areas.length_tolerance;
  return json;
}

// `true`: asked for as usual.
Json statistics_of(const Sampling& sampling) {
  const Sampling usual;
  if (sampling.samples == usual.samples && sampling.seed == usual.seed) return true;
  return {{"samples", sampling.samples}, {"seed", sampling.seed}};
}

}  // namespace

Json json_of(const Request& request) {
  const ComparisonOptions& options = request.options;
  Json json{{"direction", name_of(kDirections, options.direction)},
            {"strategy", name_of(kStrategies, options.strategy)},
            {"timeout_ms", request.timeout.count()}};
  if (has_limit(options)) json["gate"] = gate_of(options);
  if (Json rules = json_of(options.tolerance); !rules.empty()) json["tolerance"] = std::move(rules);
  if (options.strategy == Strategy::n_point) json["points"] = options.points;
  if (request.threads_given) json["threads"] = options.threads;
  if (options.statistics) json["statistics"] = statistics_of(*options.statistics);
  if (options.areas) json["areas"] = areas_of(*options.areas);
  if (options.sides) json["sides"] = {{"length_tolerance", options.sides->length_tolerance}};
  if (options.topology) json["topology"] = true;
  if (options.expect.any()) json["expect"] = json_of(options.expect);
  if (options.align) json["align"] = json_of(*options.align);
  if (Json declared = units_of(options.units); !declared.empty()) json["units"] = std::move(declared);
  for (const Region& region : options.regions) json["regions"].push_back(json_of(region));
  if (Json most = budget_of(options); !most.empty()) json["budget"] = std::move(most);
  return json;
}

Result<std::string_view> as_simd(std::string_view value, std::string_view name) {
  const auto all = supported_simd();
  if (value == "auto") return all.front();
  for (const std::string_view supported : all) {
    if (value == supported) return supported;
  }
  return refused(std::string(name) + " must be one of " + simd_names() + " on this processor, not " + shown_text(value),
                 "options", std::string(name));
}

std::string simd_names() {
  std::string list = "auto";
  for (const std::string_view name : supported_simd()) list.append(", ").append(name);
  return list;
}

}  // namespace meshgauge::api
