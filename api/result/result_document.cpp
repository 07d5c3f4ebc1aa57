#include "api/result/result_document.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/compare/align.h"

namespace meshgauge::api {
namespace {

using Json = nlohmann::ordered_json;

// Uses at(), which throws for a missing member or a wrong type; result_facts() catches that.
std::optional<ResultWitness> witness_of(const Json& json, bool on_candidate) {
  if (json.is_null()) return std::nullopt;
  return ResultWitness{on_candidate, point_of(json.at("point_a")), json.at("triangle_a").get<std::uint32_t>(),
                       point_of(json.at("point_b")), json.at("triangle_b").get<std::uint32_t>()};
}

// Returns false also for NaN. Documents may come from another service, and verdicts need valid bounds.
bool is_interval(double lower, double upper) { return std::isfinite(lower) && lower >= 0 && lower <= upper; }

std::optional<ResultDirection> direction_of(const Json& document, const char* name, bool on_candidate) {
  const auto directed = document.find(name);
  if (directed == document.end() || directed->is_null()) return std::nullopt;
  const ResultDirection direction{directed->at("lower").get<double>(), upper_of(*directed),
                                  witness_of(directed->at("witness"), on_candidate)};
  return is_interval(direction.lower, direction.upper) ? std::optional(direction) : std::nullopt;
}

// Results without criteria have one limit.
std::optional<DistanceLimit> limit_of(const Json& document) {
  const std::vector<Criterion> criteria = read_criteria(document);
  const Json::json_pointer old("/gate/max_distance");
  const bool is_old = criteria.empty() && document.contains(old) && document.at(old).is_number();
  return is_old ? DistanceLimit{document.at(old).get<double>()} : shown_limit(criteria);
}

// Returns why mesh b, in words the baseline, has no sides; empty: it has, or nothing is known of it.
std::string sides_refused(const Json& sides) {
  const auto refused = sides.find("refused");
  if (refused == sides.end() || refused->is_null()) return "";
  auto why = refused->at("detail").get<std::string>();
  if (why.starts_with("mesh b")) why.replace(0, 6, "the baseline");
  return why;
}

ResultFacts facts_of(const Json& document, Side candidate) {
  const bool of_a = candidate == Side::a;
  ResultFacts facts;
  facts.limit = limit_of(document);
  facts.lower = document.at("distance").at("lower").get<double>();
  facts.upper = upper_of(document.at("distance"));
  facts.units = unit_plan_of(document);
  facts.sides = of_a && document.contains("sides");
  if (facts.sides && document.at("sides").is_object()) facts.no_sides = sides_refused(document.at("sides"));
  facts.has_units = document.contains("unit");
  facts.direction = direction_of(document, of_a ? "a_to_b" : "b_to_a", true);
  const auto other = direction_of(document, of_a ? "b_to_a" : "a_to_b", false);
  // In a symmetric measurement the direction with the larger lower bound attains `lower`.
  double reached = -1;
  for (const std::optional<ResultDirection>* direction : {&std::as_const(facts.direction), &other}) {
    if (!*direction || !(*direction)->witness || (*direction)->lower <= reached) continue;
    reached = (*direction)->lower;
    facts.witness = (*direction)->witness;
  }
  return facts;
}

Error no_comparison(const std::string& why) {
  return {ErrorCode::internal, "the result is not that of a comparison: " + why, "", ""};
}

KnownUnit known_unit(const Json& document, const char* pointer) {
  KnownUnit known;
  const Json::json_pointer at(pointer);
  if (!document.contains(at) || !document.at(at).is_object()) return known;
  const Json& json = document.at(at);
  const auto named = [&](const char* key, const auto& all, auto& out) {
    const auto value = json.find(key);
    if (value == json.end() || !value->is_string()) return;
    const auto& text = value->template get_ref<const std::string&>();
    const auto found = std::find_if(std::begin(all), std::end(all), [&](auto one) { return to_string(one) == text; });
    if (found != std::end(all)) out = *found;
  };
  static constexpr UnitSource kSources[] = {UnitSource::file, UnitSource::declared, UnitSource::assumed};
  named("name", kLengthUnits, known.unit);
  named("source", kSources, known.source);
  return known;
}

}  // namespace

Result<ResultFacts> result_facts(const Json& document, Side candidate) try {
  ResultFacts facts = facts_of(document, candidate);
  if (!is_interval(facts.lower, facts.upper)) return no_comparison("its distance is not an interval");
  const auto motion = motion_of(document);
  if (!motion) return motion.error();
  facts.motion = *motion;
  return facts;
} catch (const Json::exception& error) {
  return no_comparison(error.what());
}

Vec3 point_of(const Json& point) {
  return {point.at(0).get<double>(), point.at(1).get<double>(), point.at(2).get<double>()};
}

double upper_of(const Json& interval) {
  const Json& upper = interval.at("upper");
  return upper.is_null() ? std::numeric_limits<double>::infinity() : upper.get<double>();
}

UnitPlan unit_plan_of(const Json& document) {
  return {known_unit(document, "/meshes/a/unit"), known_unit(document, "/meshes/b/unit"),
          known_unit(document, "/unit")};
}

}  // namespace meshgauge::api
