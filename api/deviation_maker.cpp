#include "api/deviation_maker.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/load.h"
#include "api/unit_document.h"
#include "engine/decimation.h"
#include "engine/deviation.h"
#include "engine/refinement.h"

namespace meshgauge::api {
namespace {

using Json = nlohmann::json;

constexpr double kLongestEdge = 1.0 / 64;  // of the diagonal
constexpr const char* kWhat = "the deviation map was made";

// By at(): what is missing or of another type throws, and is caught in deviation_facts().
Vec3 point(const Json& json) { return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()}; }

std::optional<DeviationWitness> witness_of(const Json& directed, bool from_candidate) {
  const Json& json = directed.at("witness");
  if (json.is_null()) return std::nullopt;
  return DeviationWitness{from_candidate, point(json.at("point_a")), json.at("triangle_a").get<std::uint32_t>(),
                          point(json.at("point_b")), json.at("triangle_b").get<std::uint32_t>()};
}

double upper_of(const Json& interval) {
  const Json& upper = interval.at("upper");  // null: ended before there was one
  return upper.is_null() ? std::numeric_limits<double>::infinity() : upper.get<double>();
}

// Whoever measured: what is no interval bounds nothing.
std::optional<DeviationDirection> direction_of(const Json& directed, bool from_candidate) {
  if (directed.is_null()) return std::nullopt;
  const DeviationDirection direction{directed.at("lower").get<double>(), upper_of(directed),
                                     witness_of(directed, from_candidate)};
  const bool bounds = direction.lower >= 0 && direction.lower <= direction.upper;
  return bounds ? std::optional(direction) : std::nullopt;
}

DeviationFacts facts_of(const Json& document, Side candidate) {
  const bool of_a = candidate == Side::a;
  DeviationFacts facts;
  if (const Json& gate = document.at("gate"); !gate.is_null()) {
    facts.limit = gate.at("max_distance").get<double>();
  }
  (void)document.at("unit");  // a result of before 0.2.0 does not say what its lengths are in
  facts.plan = unit_plan_of(document);
  if (facts.plan.result.unit) facts.units = to_string(*facts.plan.result.unit);
  facts.lower = document.at("distance").at("lower").get<double>();
  facts.upper = upper_of(document.at("distance"));
  facts.direction = direction_of(document.at(of_a ? "a_to_b" : "b_to_a"), true);
  const auto other = direction_of(document.at(of_a ? "b_to_a" : "a_to_b"), false);
  // Of the direction that attains `lower`: in a symmetric measurement the one that reaches further.
  double reached = -1;
  for (const std::optional<DeviationDirection>* direction : {&std::as_const(facts.direction), &other}) {
    if (!*direction || !(*direction)->witness || (*direction)->lower <= reached) continue;
    reached = (*direction)->lower;
    facts.witness = (*direction)->witness;
  }
  return facts;
}

// What must be seen: the farthest vertex, and then all that are beyond the limit, the farther the sooner.
std::vector<std::uint8_t> ranks(const Deviation& deviations, const ColourScale& scale) {
  constexpr double kLevels = 253;
  const double farthest = deviations.distances[deviations.farthest];
  std::vector<std::uint8_t> rank(deviations.distances.size());
  std::transform(deviations.distances.begin(), deviations.distances.end(), rank.begin(), [&](double distance) {
    if (!scale.limited || distance <= scale.top) return std::uint8_t{0};
    return static_cast<std::uint8_t>(1 + kLevels * ((distance - scale.top) / (farthest - scale.top)));
  });
  rank[deviations.farthest] = std::numeric_limits<std::uint8_t>::max();
  return rank;
}

ColourScale scale_of(const DeviationFacts& facts, const Deviation& deviations) {
  if (facts.limit) return {*facts.limit, true};
  return {deviations.distances[deviations.farthest], false};
}

}  // namespace

Result<DeviationFacts> deviation_facts(std::string_view document, Side candidate) try {
  return facts_of(Json::parse(document), candidate);
} catch (const Json::exception& error) {
  return Error{ErrorCode::internal, std::string("the result is not that of a comparison: ") + error.what(), "", ""};
}

Result<MadeMap> make_deviation(const Prepared& candidate, const Prepared& baseline, const DeviationFacts& facts,
                               const MapOptions& options, Control& control) {
  const auto stopped = [&control] { return control.check() != Interruption::none; };
  const std::size_t triangles = candidate.mesh().triangles.size();
  MadeMap made;
  MapForm form = triangles > options.max_triangles ? MapForm::decimated : MapForm::as_is;
  if (options.refine && form == MapForm::as_is) {
    const std::size_t most = std::min(MapOptions::kMostRefined, options.max_triangles);
    if (auto more = refined(candidate.mesh(), {kLongestEdge * diagonal(candidate.box()), most}, stopped)) {
      made.shown_ = std::move(*more);
      form = MapForm::refined;
    }
  }
  const double upper = facts.direction ? facts.direction->upper : std::numeric_limits<double>::infinity();
  std::optional<Prepared> display;
  if (form == MapForm::refined) display.emplace(made.shown_);
  auto deviations =
      deviation(display ? *display : candidate, baseline, {options.threads, options.simd, upper}, control);
  if (!deviations) return not_in_time(control.check(), kWhat);
  const ColourScale scale = scale_of(facts, *deviations);
  if (form == MapForm::decimated) {
    auto fewer = decimated(candidate.mesh(), {options.max_triangles, ranks(*deviations, scale)}, stopped);
    if (!fewer) return not_in_time(control.check(), kWhat);
    made.shown_ = std::move(fewer->mesh);
    for (const std::uint32_t vertex : fewer->source) made.distances_.push_back(deviations->distances[vertex]);
  } else {
    made.distances_ = std::move(deviations->distances);
  }
  made.map_ = {form == MapForm::as_is ? candidate.mesh() : MeshView(made.shown_),
               form,
               candidate.mesh().positions.size(),
               triangles,
               made.distances_,
               scale,
               facts.units,
               facts.lower,
               facts.upper,
               facts.witness,
               facts.direction};
  return made;
}

}  // namespace meshgauge::api
