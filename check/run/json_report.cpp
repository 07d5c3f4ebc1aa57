#include "check/run/json_report.h"

#include <nlohmann/json.hpp>

#include "api/options/names.h"
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
Json limits_of(const GateOutcome& outcome) {
  const api::ComparisonOptions& asked = outcome.gate.request.options;
  const bool of_diagonal = is_of_diagonal(outcome.gate);
  const auto found = [&](Criterion::Of of, const char* side = "") {
    return outcome.measured ? outcome.measured->find(of, "", side) : nullptr;
  };
  const auto length = [&](const Criterion* measured, double limit) {
    return measured ? Json(measured->limit) : of_diagonal ? Json(nullptr) : Json(limit);
  };
  const auto in_diagonals = [&](double limit) { return of_diagonal ? Json(limit) : Json(nullptr); };
  using enum Criterion::Of;
  const auto& most = asked.max_distance;
  Json json{{"max_distance", most ? length(found(distance), *most) : Json(nullptr)},
            {"diagonal_share", most ? in_diagonals(*most) : Json(nullptr)},
            {"units", or_null(outcome.unit())}};
  if (asked.uncertainty > 0)
    json["uncertainty"] =
        outcome.measured ? Json(outcome.measured->criteria.front().uncertainty) : length(nullptr, asked.uncertainty);
  if (const auto& zone = asked.zone) {
    const Json inside = length(found(distance, "inside"), zone->inside);
    json["zone"] = {inside.is_null() ? inside : Json(0 - inside.get<double>()),
                    length(found(distance, "outside"), zone->outside)};
  }
  if (const auto& area = asked.max_share_beyond) {
    const Criterion* measured = found(Criterion::Of::share);
    json["max_share_beyond"] = {{"distance", measured ? Json(*measured->beyond) : length(nullptr, area->distance)},
                                {"diagonal_share", in_diagonals(area->distance)},
                                {"share", area->share}};
  }
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

Json json_of(const std::vector<PastRun>& runs) {
  Json json = Json::array();
  for (const PastRun& run : runs) {
    json.push_back({{"commit", or_null(run.commit)},
                    {"verdict", to_string(run.verdict)},
                    {"lower", or_null(run.lower)},
                    {"upper", or_null(run.upper)},
                    {"limit", or_null(run.limit)},
                    {"unit", or_null(run.unit)},
                    {"criteria", json_of(run.criteria)}});
    if (run.uncertainty > 0) json.back()["uncertainty"] = run.uncertainty;
  }
  return json;
}

Json criteria_json(const GateOutcome& outcome) {
  Json all = Json::array();
  if (!outcome.measured) return all;
  for (const Criterion& criterion : outcome.measured->criteria) all.push_back(api::json_of(criterion, outcome.unit()));
  for (const Expectation& one : outcome.expectations)
    all.push_back(api::json_of(api::criterion_of(one), outcome.unit()));
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
          {"expectations", api::json_of(outcome.expectations)},
          {"notes", notes_json(outcome)},
          {"advice", or_null(outcome.advice())},
          {"error", json_of(outcome.error)},
          {"interrupted", outcome.interrupted},
          {"timeout_ms", gate.request.timeout.count()},
          {"wall_ms", outcome.wall_ms},
          {"manifest", place(gate)},
          {"history", json_of(outcome.history)},
          {"link", measured ? or_null(measured->link) : Json(nullptr)},
          {"comparison", measured ? measured->document : Json(nullptr)}};
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
