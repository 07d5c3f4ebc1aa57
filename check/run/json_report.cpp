#include "check/run/json_report.h"

#include <nlohmann/json.hpp>

#include "api/options/names.h"
#include "api/options/write_options.h"
#include "api/result/examination.h"
#include "check/reports/history.h"

namespace meshgauge::check {
namespace {

using api::Json;
using api::text_or_null;

// In `.limit`: the limits as measured or, without a measurement, as far as the manifest says them: a length that is a
// share of a diagonal is null. After max_distance they are in the reverse order of a request.
Json limits_of(const GateOutcome& outcome) {
  const Gate& gate = outcome.gate;
  const Json asked = api::gate_of(gate.request.options),
             found = api::gate_of(options_in(gate, outcome.measured ? outcome.measured->document : Json()));
  const auto in_diagonals = [&](const Json& length) { return is_of_diagonal(gate) ? length : Json(nullptr); };
  Json json{{"max_distance", nullptr}, {"diagonal_share", nullptr}, {"units", text_or_null(outcome.unit())}};
  if (asked.is_null()) return json;
  json["max_distance"] = found["max_distance"];
  json["diagonal_share"] = in_diagonals(asked["max_distance"]);
  for (auto limit = found.rbegin(); limit != found.rend(); ++limit) {
    if (json.contains(limit.key())) continue;
    json[limit.key()] = *limit;
    if (limit->is_object())
      json[limit.key()] = {{"distance", limit->at("distance")},
                           {"diagonal_share", in_diagonals(asked[limit.key()]["distance"])},
                           {"share", limit->at("share")}};
  }
  return json;
}

Json json_of(const std::optional<Witness>& witness) {
  if (!witness) return nullptr;
  return {{"on", witness->from_mesh()},
          {"point", api::json_of(witness->from)},
          {"triangle", witness->from_triangle},
          {"nearest_point", api::json_of(witness->to)},
          {"nearest_triangle", witness->to_triangle}};
}

Json json_of(const std::optional<Error>& error) {
  if (!error) return nullptr;
  return {{"message", error->message}, {"where", text_or_null(error->where)}};
}

Json distance(const std::optional<Measured>& measured) {
  if (!measured) return nullptr;
  return {{"lower", measured->lower}, {"upper", measured->upper}};
}

Json json_of(const std::vector<PastRun>& runs) {
  Json json = Json::array();
  for (const PastRun& run : runs) {
    Json& one = json.emplace_back(json_of(run));
    one["criteria"] = json_of(run.criteria);
    one.update(api::terms_json(run.terms));
  }
  return json;
}

Json criteria_json(const GateOutcome& outcome) {
  Json all = Json::array();
  for (const Criterion& criterion : outcome.criteria()) all.push_back(api::json_of(criterion, outcome.unit()));
  return all;
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
  return {{"name", gate.name},
          {"verdict", to_string(outcome.verdict())},
          {"level", to_string(outcome.level(rule))},
          {"candidate", gate.candidate.string()},
          {"baseline", gate.baseline.string()},
          {"direction", api::name_of(api::kDirections, gate.request.options.direction)},
          {"limit", limits_of(outcome)},
          {"distance", distance(measured)},
          {"criteria", criteria_json(outcome)},
          {"witness", measured ? json_of(measured->witness) : Json(nullptr)},
          {"expectations", api::expectations_json(outcome.expectations)},
          {"notes", notes_json(outcome)},
          {"advice", text_or_null(outcome.advice())},
          {"error", json_of(outcome.error)},
          {"interrupted", outcome.interrupted},
          {"timeout_ms", gate.request.timeout.count()},
          {"wall_ms", outcome.wall_ms},
          {"manifest", place(gate)},
          {"history", json_of(outcome.history)},
          {"link", measured ? text_or_null(measured->link) : Json(nullptr)},
          {"comparison", measured ? measured->document : Json(nullptr)}};
}

Json counts(const Report& report) {
  Json json;
  for (const auto& [verdict, name] : kVerdicts) json[std::string(name)] = report.count(verdict);
  return json;
}

}  // namespace

std::string to_json(const Report& report) {
  Json gates = Json::array();
  for (const GateOutcome& outcome : report.outcomes) gates.push_back(json_of(outcome, report.undecided));
  Json json{{"version", report.version},
            {"exit_code", report.exit_code()},
            {"interrupted", report.interrupted},
            {"counts", counts(report)},
            {"batches", report.batches}};
  if (report.against) json["against"] = {{"ref", report.against->ref}, {"commit", report.against->commit}};
  json["gates"] = std::move(gates);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace meshgauge::check
