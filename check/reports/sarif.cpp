#include "check/reports/reports.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "api/options/names.h"
#include "check/reports/finding.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

struct Rule {
  Verdict verdict;
  const char* id;
  const char* name;
  const char* what;
  const char* help;
};

constexpr Rule kRules[] = {
    {Verdict::fail, "MG0001", "DistanceAboveLimit", "The distance between two meshes is above its limit.",
     "The largest distance between the candidate and its baseline is certainly above the limit of the gate: at the "
     "witness, a point of one surface, the other surface is at least that far away. Look at the witness. If the change "
     "is wanted, take the candidate for the new baseline (meshgauge check --update-baselines) or raise the limit."},
    {Verdict::undecided, "MG0002", "DistanceUndecided", "Whether a distance is within its limit was not decided.",
     "The limit of the gate lies inside the interval that was proved when the work stopped: the distance may be within "
     "the limit or above it. Give the gate more time (timeout), or a limit that is not so close to the distance."},
    {Verdict::error, "MG0003", "NotMeasured", "Two meshes could not be compared.",
     "There is no interval: a file is missing or is not a mesh that can be read, or the service was not reached. The "
     "message names the defect. A gate that was not measured never passes."},
    {Verdict::fail, "MG0004", "AreaAboveLimit", "Too much of the area is farther than a distance from the other mesh.",
     "The share of the area that is farther than the gate's distance is certainly above its limit (max_share_beyond). "
     "The witness is where it is farthest. If the change is wanted, take the candidate for the new baseline (meshgauge "
     "check --update-baselines) or raise the limit."},
    {Verdict::fail, "MG0005", "ExpectationNotMet", "A mesh is not as its gate expects.",
     "The candidate has open edges, too many triangles, another volume or the like: the message names what the gate "
     "expects (expect) and what was found. Repair the candidate, or change what the gate expects."},
    {Verdict::fail, "MG0006", "ZoneExceeded", "A mesh reaches farther inside or outside of the other than its zone.",
     "The candidate is certainly farther inside of its baseline, or farther outside, than the limit of that side "
     "(zone). "
     "The message names the side and a point there. If the change is wanted, take the candidate for the new baseline "
     "(meshgauge check --update-baselines) or widen the zone."}};

std::size_t rule_index(const GateOutcome& outcome) {
  const std::string_view id = fails_by_expectation(outcome) ? "MG0005"
                              : fails_by_area(outcome)      ? "MG0004"
                              : fails_by_zone(outcome)      ? "MG0006"
                                                            : "";
  const auto* rule = std::find_if(std::begin(kRules), std::end(kRules), [&](const Rule& r) {
    return id.empty() ? r.verdict == outcome.verdict() : r.id == id;
  });
  return static_cast<std::size_t>(rule - std::begin(kRules));
}

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
  return {{"on", witness.on_candidate ? "candidate" : "baseline"},
          {"from", {witness.from.x(), witness.from.y(), witness.from.z()}},
          {"fromTriangle", witness.from_triangle},
          {"to", {witness.to.x(), witness.to.y(), witness.to.z()}},
          {"toTriangle", witness.to_triangle}};
}

Json properties_of(const GateOutcome& outcome) {
  const Gate& gate = outcome.gate;
  Json properties{{"gate", shown_name(gate.name)},
                  {"verdict", to_string(outcome.verdict())},
                  {"candidate", shown_name(gate.candidate.string())},
                  {"baseline", shown_name(gate.baseline.string())},
                  {"direction", api::name_of(api::kDirections, gate.request.options.direction)},
                  {"wallMs", finite_or_null(outcome.wall_ms)}};
  if (const std::string unit = outcome.unit(); !unit.empty()) properties["units"] = unit;
  if (const auto notes = notes_of(outcome); !notes.empty()) properties["notes"] = notes;
  if (!outcome.measured) return properties;
  const Measured& measured = *outcome.measured;
  if (const Criterion* distance = measured.find(Criterion::Of::distance)) properties["limit"] = distance->limit;
  properties["lower"] = finite_or_null(measured.lower);
  properties["upper"] = finite_or_null(measured.upper);
  if (const double u = measured.criteria.front().uncertainty; u > 0) properties["uncertainty"] = u;
  std::vector<Criterion> criteria = measured.criteria;
  for (const Expectation& one : outcome.expectations) criteria.push_back(api::criterion_of(one));
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
  const std::size_t rule = rule_index(outcome);
  const std::string fingerprint = fingerprint_of(outcome.gate);
  Json meshes = Json::array();
  if (!outcome.gate.candidate.empty()) meshes.push_back(related(1, "The candidate", outcome.gate.candidate));
  if (!outcome.gate.baseline.empty()) meshes.push_back(related(2, "The baseline", outcome.gate.baseline));
  Json result{{"ruleId", kRules[rule].id},
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
  for (const Verdict verdict : {Verdict::pass, Verdict::fail, Verdict::undecided, Verdict::error}) {
    counts[std::string(to_string(verdict))] = report.count(verdict);
  }
  return counts;
}

Json driver_of(const Report& report) {
  Json rules = Json::array();
  for (const Rule& rule : kRules) rules.push_back(rule_json(rule));
  Json driver{{"name", "meshgauge"}};
  if (!report.version.empty()) driver["version"] = report.version;
  driver["rules"] = std::move(rules);
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
