#include "check/reports/reports.h"

#include <cmath>
#include <filesystem>

#include "api/options/names.h"
#include "check/reports/finding.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

Json rule_json(const Rule& rule) {
  return {{"id", rule.id},
          {"name", rule.name},
          {"shortDescription", {{"text", rule.what}}},
          {"fullDescription", {{"text", rule.help}}},
          {"help", {{"text", rule.help}, {"markdown", rule.help}}},
          {"defaultConfiguration", {{"level", "error"}}},
          {"properties", {{"tags", {"mesh", "geometry"}}}}};
}

Json artifact(const std::filesystem::path& path) {
  if (path.is_absolute()) return {{"uri", "file://" + uri_path(path)}};
  return {{"uri", uri_path(path)}, {"uriBaseId", "%SRCROOT%"}};
}

// Escapes text for SARIF's messages, where [words](target) is a link and {0} a placeholder.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == '\\') out += '\\';
    if (c == '{' || c == '}') out += c;
    out += c;
  }
  return out;
}

Json location_json(const Gate& gate) {
  const Location place = location_of(gate);
  return {{"physicalLocation", {{"artifactLocation", artifact(place.file)}, {"region", {{"startLine", place.line}}}}}};
}

Json related(int id, const char* role, const std::filesystem::path& file) {
  return {{"id", id}, {"physicalLocation", {{"artifactLocation", artifact(file)}}}, {"message", {{"text", role}}}};
}

// JSON has no infinity: an unknown upper bound is null.
Json finite_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json witness_json(const Witness& witness) {
  return {{"on", witness.from_mesh()},
          {"from", {witness.from.x(), witness.from.y(), witness.from.z()}},
          {"fromTriangle", witness.from_triangle},
          {"to", {witness.to.x(), witness.to.y(), witness.to.z()}},
          {"toTriangle", witness.to_triangle}};
}

Json properties_of(const GateOutcome& outcome) {
  const Gate& gate = outcome.gate;
  Json properties{{"gate", shown_name(gate.name)},
                  {"verdict", to_string(outcome.verdict())},
                  {"direction", api::name_of(api::kDirections, gate.request.options.direction)},
                  {"wallMs", finite_or_null(outcome.wall_ms)}};
  if (!gate.candidate.empty()) properties["candidate"] = shown_name(gate.candidate.string());
  if (!gate.baseline.empty()) properties["baseline"] = shown_name(gate.baseline.string());
  if (const std::string unit = outcome.unit(); !unit.empty()) properties["units"] = unit;
  if (const auto notes = notes_of(outcome); !notes.empty()) properties["notes"] = notes;
  if (!outcome.measured) return properties;
  const Measured& measured = *outcome.measured;
  if (const Criterion* distance = measured.distance()) properties["limit"] = distance->limit;
  properties["lower"] = finite_or_null(measured.lower);
  properties["upper"] = finite_or_null(measured.upper);
  properties.update(api::terms_json(measured.criteria.front()));
  std::vector<Criterion> criteria = outcome.criteria();
  properties["foremost"] = shown_name(api::foremost(criteria).name);
  for (Criterion& shown : criteria) {
    for (std::string* text :
         {&shown.name, &shown.region, &shown.status, &shown.refused, &shown.found, &shown.expected}) {
      if (!text->empty()) *text = shown_name(*text);
    }
    properties["criteria"].push_back(api::json_of(shown, outcome.unit()));
  }
  properties["status"] = shown_name(measured.status);
  if (measured.witness) properties["witness"] = witness_json(*measured.witness);
  return properties;
}

const char* level_of(const GateOutcome& outcome, Undecided rule) {
  if (outcome.level(rule) == Level::failure) return "error";
  return outcome.verdict() == Verdict::fail ? "warning" : "note";
}

Json result_of(const GateOutcome& outcome, Undecided undecided) {
  const std::size_t rule = rule_of(outcome);
  const std::string fingerprint = fingerprint_of(outcome.gate);
  Json meshes = Json::array();
  if (!outcome.gate.candidate.empty()) meshes.push_back(related(1, "The candidate", outcome.gate.candidate));
  const bool is_file = !outcome.gate.baseline.empty() && !outcome.gate.copies;  // else of a revision
  if (is_file) meshes.push_back(related(2, "The baseline", outcome.gate.baseline));
  Json result{{"ruleId", rules()[rule].id},
              {"ruleIndex", rule},
              {"level", level_of(outcome, undecided)},
              {"message", {{"text", plain(description_of(outcome))}}},
              {"locations", Json::array({location_json(outcome.gate)})},
              {"relatedLocations", std::move(meshes)},
              // GitHub reads the first one. Its own would be made of the line, which the gates of a glob share.
              {"partialFingerprints", {{"primaryLocationLineHash", fingerprint + ":1"}, {"gate/v1", fingerprint}}},
              {"properties", properties_of(outcome)}};
  if (outcome.measured && !outcome.measured->link.empty()) result["hostedViewerUri"] = outcome.measured->link;
  return result;
}

// What was not measured of the gates that pass, which have no result.
Json notifications_of(const Report& report) {
  Json notifications = Json::array();
  for (const GateOutcome& outcome : report.outcomes) {
    if (outcome.verdict() != Verdict::pass) continue;
    for (const std::string& note : unmeasured_of(outcome))
      notifications.push_back(
          {{"level", "warning"},
           {"message", {{"text", plain("Gate '" + shown_name(outcome.gate.name) + "': " + note + ".")}}},
           {"locations", Json::array({location_json(outcome.gate)})}});
  }
  return notifications;
}

Json invocation_of(const Report& report) {
  const int code = report.exit_code();
  Json invocation{{"exitCode", code}, {"executionSuccessful", code != 3 && !report.interrupted}};
  Json notifications = notifications_of(report);
  if (!notifications.empty()) invocation["toolExecutionNotifications"] = std::move(notifications);
  return invocation;
}

Json counts_of(const Report& report) {
  Json counts{{"gates", report.outcomes.size()}};
  for (const auto& [verdict, name] : kVerdicts) counts[std::string(name)] = report.count(verdict);
  if (report.against) counts["against"] = shown_name(report.against->in_words());
  return counts;
}

Json driver_of(const Report& report) {
  Json all = Json::array();
  for (const Rule& rule : rules()) all.push_back(rule_json(rule));
  Json driver{{"name", "meshgauge"}};
  if (!report.version.empty()) driver["version"] = report.version;
  driver["rules"] = std::move(all);
  return driver;
}

}  // namespace

std::string to_sarif(const Report& report) {
  Json results = Json::array();
  for (const GateOutcome& outcome : report.outcomes) {
    if (outcome.verdict() != Verdict::pass) results.push_back(result_of(outcome, report.undecided));
  }
  const Json run{{"tool", {{"driver", driver_of(report)}}},
                 {"invocations", Json::array({invocation_of(report)})},
                 {"results", std::move(results)},
                 {"properties", counts_of(report)}};
  const Json log{
      {"$schema", "https://json.schemastore.org/sarif-2.1.0.json"}, {"version", "2.1.0"}, {"runs", Json::array({run})}};
  return log.dump(2) + "\n";
}

}  // namespace meshgauge::check
