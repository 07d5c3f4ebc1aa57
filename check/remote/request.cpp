#include "check/remote/request.h"

#include "api/align.h"
#include "api/expectations.h"
#include "api/json_of.h"
#include "api/names.h"
#include "api/region_json.h"

namespace meshgauge::check::service {
namespace {

using Json = nlohmann::ordered_json;

Json gate_of(const api::ComparisonOptions& options) {
  Json json = Json::object();
  if (options.max_distance) json["max_distance"] = *options.max_distance;
  if (const auto& limit = options.max_share_beyond) json["max_share_beyond"] = api::json_of(*limit);
  if (options.zone) json["zone"] = api::json_of(*options.zone);
  if (options.uncertainty > 0) json["uncertainty"] = options.uncertainty;
  const std::string_view unit = api::limit_unit_name(options.units);
  if (!unit.empty()) json["units"] = unit;
  if (options.narrow) json["narrow"] = true;
  return json;
}

Json units(const api::AskedUnits& declared) {
  Json json = Json::object();
  if (declared.a) json["a"] = to_string(*declared.a);
  if (declared.b) json["b"] = to_string(*declared.b);
  return json;
}

// Writes only what differs from the engine's defaults: the service may have a smaller limit.
Json budget(const Options& options) {
  const Options usual;
  Json json = Json::object();
  if (options.max_work_items != usual.max_work_items) json["work_items"] = options.max_work_items;
  if (options.max_memory_bytes != usual.max_memory_bytes) json["memory_bytes"] = options.max_memory_bytes;
  return json;
}

Json json_of(const Gate& gate, const Limits& limits) {
  const api::ComparisonOptions options = options_of(gate, limits);
  Json json{{"direction", api::name_of(api::kDirections, options.direction)},
            {"gate", gate_of(options)},
            {"strategy", api::name_of(api::kStrategies, options.strategy)},
            {"timeout_ms", gate.timeout.count()}};
  if (Json rules = api::json_of(options.tolerance); !rules.empty()) json["tolerance"] = std::move(rules);
  if (options.strategy == Strategy::n_point) json["points"] = options.points;
  if (gate.threads_given) json["threads"] = options.threads;
  if (gate.statistics) json["statistics"] = true;
  if (options.expect.any()) json["expect"] = api::json_of(options.expect);
  if (options.align) json["align"] = api::json_of(*options.align);
  if (Json declared = units(gate.options.units); !declared.empty()) json["units"] = std::move(declared);
  for (const Region& region : options.regions) json["regions"].push_back(api::json_of(region));
  if (Json most = budget(options); !most.empty()) json["budget"] = std::move(most);
  return json;
}

}  // namespace

Json asked_of(const std::string& a, const std::string& b, const Gate& gate, const Limits& limits) {
  return {{"a", a}, {"b", b}, {"options", json_of(gate, limits)}};
}

std::string document_of(const Json& asked) { return asked.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace meshgauge::check::service
