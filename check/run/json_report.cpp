#include "check/run/json_report.h"

#include <nlohmann/json.hpp>

#include "api/names.h"
#include "check/reports/history.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

// In `.limit`: the limit as measured or, without a measurement, as far as the manifest says it.
Json json_of(const AreaLimit& area, const GateOutcome& outcome) {
  const auto distance =
      outcome.measured ? std::optional(outcome.measured->share_beyond->limit.distance) : area.distance.max_distance;
  return {{"distance", or_null(distance)},
          {"diagonal_share", or_null(area.distance.max_diagonal_share)},
          {"share", area.share}};
}

// [-inside, outside], as measured or as far as the manifest says it.
Json json_of(const ZoneLimit& zone, const GateOutcome& outcome) {
  if (outcome.measured) return {0 - outcome.measured->zone->inside.limit, outcome.measured->zone->outside.limit};
  const auto& inside = zone.inside.max_distance;
  return {inside ? Json(0 - *inside) : Json(nullptr), or_null(zone.outside.max_distance)};
}

Json limits_of(const GateOutcome& outcome) {
  const Gate& gate = outcome.gate;
  const bool is_known = outcome.measured && outcome.measured->has_max_distance;
  Json json{{"max_distance", is_known ? Json(outcome.measured->limit) : or_null(gate.limit.max_distance)},
            {"diagonal_share", or_null(gate.limit.max_diagonal_share)},
            {"units", or_null(outcome.unit())}};
  if (gate.uncertainty.is_given())
    json["uncertainty"] =
        outcome.measured ? Json(outcome.measured->uncertainty) : or_null(gate.uncertainty.max_distance);
  if (gate.zone) json["zone"] = json_of(*gate.zone, outcome);
  if (gate.area_limit) json["max_share_beyond"] = json_of(*gate.area_limit, outcome);
  return json;
}

Json json_of(const std::optional<Witness>& witness) {
  if (!witness) return nullptr;
  return {{"on", witness->on_candidate ? "candidate" : "baseline"},
          {"point", json_of(witness->from)},
          {"triangle", witness->from_triangle},
          {"nearest_point", json_of(witness->to)},
          {"nearest_triangle", witness->to_triangle}};
}

Json json_of(const std::optional<Error>& error) {
  if (!error) return nullptr;
  return {{"message", error->message}, {"where", or_null(error->where)}};
}

Json distance(const std::optional<Measured>& measured) {
  if (!measured) return nullptr;
  return {{"lower", measured->lower}, {"upper", measured->upper}};
}

// Nothing for a gate without such a limit.
void add_share(const std::optional<ShareBeyond>& share, Json& json) {
  if (share) json["share_beyond"] = {{"lower", share->lower}, {"upper", share->upper}, {"limit", share->limit.share}};
}

void add_zone(const ZoneReached& zone, Json& json) {
  const auto side = [&](const ZoneReached::Side& found) -> Json {
    if (!zone.refused.empty()) return nullptr;
    return {{"lower", found.lower}, {"upper", found.upper}, {"point", found.at ? json_of(*found.at) : Json(nullptr)}};
  };
  json["zone"] = {{"inside", side(zone.inside)}, {"outside", side(zone.outside)}, {"refused", or_null(zone.refused)}};
}

Json json_of(const std::vector<PastRun>& runs) {
  Json json = Json::array();
  for (const PastRun& run : runs) {
    json.push_back({{"commit", or_null(run.commit)},
                    {"verdict", to_string(run.verdict)},
                    {"lower", or_null(run.lower)},
                    {"upper", or_null(run.upper)},
                    {"limit", or_null(run.limit)},
                    {"unit", or_null(run.unit)}});
    add_share(run.share_beyond, json.back());
    if (run.inside && run.outside)
      json.back()["zone"] = {{"inside", json_of(*run.inside)}, {"outside", json_of(*run.outside)}};
    if (run.uncertainty > 0) json.back()["uncertainty"] = run.uncertainty;
    if (!run.regions.empty()) json.back()["regions"] = json_of(run.regions);
  }
  return json;
}

Json regions_json(const Measured& measured) {
  Json json = Json::array();
  for (const Criterion& region : measured.regions)
    json.push_back({{"name", region.region},
                    {"verdict", to_string(region.verdict)},
                    {"lower", region.lower},
                    {"upper", region.upper},
                    {"limit", region.limit},
                    {"status", region.status}});
  return json;
}

Json notes_json(const GateOutcome& outcome) {
  Json notes = Json::array();
  const auto add = [&](const std::vector<std::string>& more) {
    for (const std::string& note : more) notes.push_back(note);
  };
  if (outcome.measured) add(outcome.measured->unread);
  add(outcome.gate.notes);
  if (outcome.measured) add(outcome.measured->notes);
  return notes;
}

Json place(const Gate& gate) {
  if (gate.manifest.empty()) return nullptr;
  return {{"file", gate.manifest}, {"line", gate.line}};
}

Json json_of(const GateOutcome& outcome, Undecided rule) {
  const Gate& gate = outcome.gate;
  const auto& measured = outcome.measured;
  Json json{{"name", gate.name},
            {"verdict", to_string(outcome.verdict())},
            {"level", to_string(outcome.level(rule))},
            {"candidate", gate.candidate.string()},
            {"baseline", gate.baseline.string()},
            {"direction", api::name_of(api::kDirections, gate.options.direction)},
            {"limit", limits_of(outcome)},
            {"distance", distance(measured)},
            {"witness", measured ? json_of(measured->witness) : Json(nullptr)},
            {"expectations", api::json_of(outcome.expectations)},
            {"notes", notes_json(outcome)},
            {"advice", or_null(outcome.advice())},
            {"error", json_of(outcome.error)},
            {"interrupted", outcome.interrupted},
            {"timeout_ms", gate.timeout.count()},
            {"wall_ms", outcome.wall_ms},
            {"manifest", place(gate)},
            {"history", json_of(outcome.history)},
            {"link", measured ? or_null(measured->link) : Json(nullptr)},
            {"comparison", measured ? measured->document : Json(nullptr)}};
  if (measured) add_share(measured->share_beyond, json);
  if (measured && !measured->regions.empty()) json["regions"] = regions_json(*measured);
  if (measured && measured->zone) add_zone(*measured->zone, json);
  return json;
}

Json counts(const Report& report) {
  Json json;
  for (const auto verdict : {Verdict::pass, Verdict::fail, Verdict::undecided, Verdict::error}) {
    json[std::string(to_string(verdict))] = report.count(verdict);
  }
  return json;
}

}  // namespace

std::string to_json(const Report& report) {
  Json gates = Json::array();
  for (const GateOutcome& outcome : report.outcomes) gates.push_back(json_of(outcome, report.undecided));
  const Json json{{"version", report.version}, {"exit_code", report.exit_code()}, {"interrupted", report.interrupted},
                  {"counts", counts(report)},  {"batches", report.batches},       {"gates", std::move(gates)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace meshgauge::check
