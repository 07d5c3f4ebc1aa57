#include "api/result/response.h"

#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include <nlohmann/json.hpp>

#include "api/options/names.h"
#include "api/result/criteria.h"
#include "api/result/examination.h"
#include "api/result/json_of.h"
#include "api/result/notes.h"
#include "engine/hausdorff.h"

namespace meshgauge::api {
namespace {

// Returns width / of. 0/0 is 0, since an interval without width satisfies every rule; x/0 is infinite, null in JSON.
double ratio(double width, double of) { return width == 0 ? 0 : width / of; }

Json json_of(const Tolerance& tolerance, const Outcome& outcome) {
  const double width = outcome.upper - outcome.lower;
  return {{"asked", api::json_of(tolerance)},
          {"reached",
           {{"absolute", width},
            {"diagonal", ratio(width, outcome.diagonal_a)},
            {"relative", ratio(width, outcome.lower)}}},
          {"met_by", outcome.met_by ? Json(name_of(kRules, *outcome.met_by)) : Json(nullptr)}};
}

Json timings(const std::vector<Stage>& stages) {
  Json json;
  for (const Stage& stage : stages) json[stage.name] = stage.ms;
  return json;
}

Json engine(const Options& options, const Outcome& outcome) {
  return {{"version", version()},
          {"strategy", name_of(kStrategies, options.strategy)},
          {"points", options.strategy == Strategy::n_point ? Json(options.points) : Json(nullptr)},
          {"simd", outcome.simd},
          {"threads", outcome.threads}};
}

Json json_of(const Estimate& estimate) {
  return {{"value", estimate.value}, {"standard_error", estimate.standard_error}};
}

Json json_of(const std::optional<Distribution>& found) {
  if (!found) return nullptr;
  Json shares = Json::array(), errors = Json::array();
  for (const Estimate& bin : found->histogram) {
    shares.push_back(bin.value);
    errors.push_back(bin.standard_error);
  }
  return {{"weight", name_of(kWeights, found->weight)},
          {"samples", found->samples},
          {"mean", json_of(found->mean)},
          {"rms", json_of(found->rms)},
          {"p50", json_of(found->p50)},
          {"p95", json_of(found->p95)},
          {"p99", json_of(found->p99)},
          {"max_seen", found->max_seen},
          {"histogram", {{"high", found->max_seen}, {"shares", shares}, {"standard_errors", errors}}}};
}

Json json_of(const std::optional<Statistics>& statistics) {
  if (!statistics) return nullptr;
  return {{"sampled", true},
          {"status", name_of(kStatisticsStatuses, statistics->status)},
          {"seed", statistics->sampling.seed},
          {"a_to_b", json_of(statistics->a_to_b)},
          {"b_to_a", json_of(statistics->b_to_a)}};
}

// Adds the criteria, and the verdicts that the members of the sides, the area and the regions have of their own.
void add_limits(const std::vector<Criterion>& criteria, const std::optional<LengthUnit>& unit, Json& json) {
  std::optional<Verdict> of_sides;
  for (const Criterion& one : criteria) {
    if (!one.side.empty()) of_sides = worst(of_sides.value_or(one.verdict), one.verdict);
    if (!one.region.empty()) {
      for (Json& region : json["regions"]) {
        if (region["name"] == one.region) region["verdict"] = to_string(one.verdict);
      }
    }
    if (one.of == Criterion::Of::share)
      json["share_beyond"] = {
          {"distance", *one.beyond}, {"share", interval(one.lower, one.upper)}, {"verdict", to_string(one.verdict)}};
  }
  if (of_sides) json["sides"]["verdict"] = to_string(*of_sides);
  json["foremost"] = criteria.empty() ? Json(nullptr) : Json(foremost(criteria).name);
  Json& all = json["criteria"] = Json::array();
  for (const Criterion& one : criteria) all.push_back(api::json_of(one, to_string(unit)));
}

// JSON has no infinity and no NaN: they become null.
void make_finite(Json& json) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) json = nullptr;
  if (!json.is_structured()) return;
  for (Json& one : json) make_finite(one);
}

}  // namespace

std::vector<Stage> stages(const Comparison& comparison) {
  const StageTimes& times = comparison.times;
  const Outcome& outcome = comparison.outcome;
  const Timings& engine = outcome.timings;
  const auto asked = [](bool is_asked, double ms) { return is_asked ? std::optional(ms) : std::nullopt; };
  const std::optional<double> ms[] = {times.queue,
                                      times.read_a,
                                      times.read_b,
                                      asked(comparison.alignment.has_value(), times.align),
                                      engine.build,
                                      engine.traverse,
                                      engine.reduce,
                                      engine.certify,
                                      asked(outcome.areas || outcome.sides, engine.areas),
                                      asked(outcome.statistics.has_value(), engine.statistics),
                                      times.total};
  static_assert(std::size(ms) == std::size(kStageNames));
  std::vector<Stage> all;
  for (std::size_t i = 0; i < std::size(ms); ++i) {
    if (ms[i]) all.push_back({kStageNames[i], *ms[i]});
  }
  return all;
}

std::string to_server_timing(const std::vector<Stage>& stages) {
  std::string header;
  for (const Stage& stage : stages) {
    char entry[64];
    std::snprintf(entry, sizeof entry, "%s%s;dur=%.3f", header.empty() ? "" : ", ", stage.name, stage.ms);
    header += entry;
  }
  return header;
}

Json document_of(const Comparison& comparison) {
  const ComparisonOptions& options = comparison.options;
  const Outcome& outcome = comparison.outcome;
  const auto& unit = comparison.units.result;
  const auto expectations = expectations_of(comparison);
  const auto criteria = criteria_of(comparison, expectations);
  const auto verdict = worst(criteria);
  Json json{{"id", comparison.id},
            {"status", name_of(kStops, outcome.stop)},
            {"verdict", verdict ? Json(to_string(*verdict)) : Json(nullptr)},
            {"gate", gate_of(options)},
            {"unit", json_of(unit)},
            {"notes", notes_of(comparison)},
            {"direction", name_of(kDirections, options.direction)},
            {"distance", interval(outcome.lower, outcome.upper)},
            {"a_to_b", json_of(outcome.a_to_b)},
            {"b_to_a", json_of(outcome.b_to_a)},
            {"tolerance", json_of(options.tolerance, outcome)},
            {"precision_floor", outcome.precision_floor},
            {"timings_ms", timings(stages(comparison))},
            {"meshes", meshes_of(comparison)},
            {"engine", engine(options, outcome)},
            {"statistics", json_of(outcome.statistics)}};
  if (comparison.alignment) json["alignment"] = json_of(*comparison.alignment, *options.align);
  if (options.expect.any()) {
    json["expect"] = api::json_of(options.expect);
    json["expectations"] = expectations_json(expectations);
  }
  if (!outcome.regions.empty()) json["regions"] = regions_of(outcome, options);
  if (outcome.areas) json["areas"] = json_of(*outcome.areas);
  if (outcome.sides) json["sides"] = json_of(*outcome.sides, unit.unit);
  add_limits(criteria, unit.unit, json);
  make_finite(json);
  return json;
}

std::string to_json(const Comparison& comparison) {
  return document_of(comparison).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace meshgauge::api
