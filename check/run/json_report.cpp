#include "check/run/json_report.h"

#include <nlohmann/json.hpp>

#include "api/names.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

Json json_of(const Limit& limit, const GateOutcome& outcome) {
  return {{"max_distance", outcome.measured ? Json(outcome.measured->limit) : or_null(limit.max_distance)},
          {"diagonal_share", or_null(limit.max_diagonal_share)},
          {"units", or_null(outcome.unit())}};
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
  for (const PastRun& run : runs)
    json.push_back({{"commit", or_null(run.commit)},
                    {"verdict", to_string(run.verdict)},
                    {"lower", or_null(run.lower)},
                    {"upper", or_null(run.upper)},
                    {"limit", or_null(run.limit)},
                    {"unit", or_null(run.unit)}});
  return json;
}

Json json_of(const std::vector<Expectation>& expectations) {
  Json json = Json::array();
  for (const Expectation& one : expectations)
    json.push_back(
        {{"name", one.name}, {"verdict", to_string(one.verdict)}, {"found", one.found}, {"expected", one.expected}});
  return json;
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
          {"direction", api::name_of(api::kDirections, gate.options.direction)},
          {"limit", json_of(gate.limit, outcome)},
          {"distance", distance(measured)},
          {"witness", measured ? json_of(measured->witness) : Json(nullptr)},
          {"expectations", json_of(outcome.expectations)},
          {"notes", measured ? Json(measured->notes) : Json::array()},
          {"advice", or_null(outcome.advice())},
          {"error", json_of(outcome.error)},
          {"interrupted", outcome.interrupted},
          {"timeout_ms", gate.timeout.count()},
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
