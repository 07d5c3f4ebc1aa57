#include "check/run/json_report.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "check/run/gates.h"

using namespace meshgauge;
using namespace meshgauge::check;
using Json = nlohmann::ordered_json;

namespace {

Report one_of_each() {
  Report report;
  report.version = "1.2.3";
  for (const auto& found : {measured(0.1, 0.2, 0.3), measured(1.0 / 3, 0.5, 0.3), measured(0.1, 0.5, 0.3, "timeout")}) {
    GateOutcome outcome;
    outcome.gate = gate("a.stl", "b.stl", found.criteria.front().limit);
    outcome.gate.manifest = "gates.yaml";
    outcome.gate.line = 7;
    outcome.measured = found;
    report.outcomes.push_back(outcome);
  }
  report.outcomes[1].measured->witness = check::Witness{false, Vec3(1, 2, 3), 4, Vec3(5, 6, 7), 8};
  GateOutcome missing;
  missing.gate = gate("none.stl", "b.stl", 1);
  missing.error = Error{ErrorCode::invalid_request, "'none.stl' cannot be read", "a", "line 3"};
  report.outcomes.push_back(missing);
  return report;
}

std::vector<std::string> names_of(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

}  // namespace

TEST_CASE("the report as JSON: members in their order, counts, the exit code") {
  const std::string text = to_json(one_of_each());
  const Json json = Json::parse(text);
  CHECK(names_of(json) ==
        std::vector<std::string>{"version", "exit_code", "interrupted", "counts", "batches", "gates"});
  CHECK(json["version"] == "1.2.3");
  CHECK(json["exit_code"] == 3);
  CHECK(json["counts"] == Json{{"pass", 1}, {"fail", 1}, {"undecided", 1}, {"error", 1}});
  CHECK(names_of(json["gates"][0]) ==
        std::vector<std::string>{"name",    "verdict",  "level",       "candidate",  "baseline",     "direction",
                                 "limit",   "distance", "criteria",    "witness",    "expectations", "notes",
                                 "advice",  "error",    "interrupted", "timeout_ms", "wall_ms",      "manifest",
                                 "history", "link",     "comparison"});
  CHECK(text == to_json(one_of_each()));
  CHECK(text.back() == '\n');
}

TEST_CASE("the report as JSON: links to a service's pages") {
  Report report = one_of_each();
  report.outcomes[0].measured->link = "https://ci.example/c/0d67c9a2d1b307386f8fc157855c4351";
  const Json gates = Json::parse(to_json(report))["gates"];
  CHECK(gates[0]["link"] == "https://ci.example/c/0d67c9a2d1b307386f8fc157855c4351");
  CHECK(gates[1]["link"].is_null());
  CHECK(gates[3]["link"].is_null());
}

TEST_CASE("numbers of the report are those of the measurement, bit by bit") {
  const Json gates = Json::parse(to_json(one_of_each()))["gates"];
  CHECK(gates[1]["distance"]["lower"].get<double>() == 1.0 / 3);
  CHECK(gates[1]["limit"]["max_distance"].get<double>() == 0.3);
  CHECK(gates[1]["witness"] == Json{{"on", "baseline"},
                                    {"point", {1.0, 2.0, 3.0}},
                                    {"triangle", 4},
                                    {"nearest_point", {5.0, 6.0, 7.0}},
                                    {"nearest_triangle", 8}});
  CHECK(gates[2]["comparison"] == Json{{"status", "timeout"}});
}

TEST_CASE("an error has a message and nothing measured, a gate by flags has no manifest") {
  const Json gate = Json::parse(to_json(one_of_each()))["gates"][3];
  CHECK(gate["error"] == Json{{"message", "'none.stl' cannot be read"}, {"where", "line 3"}});
  for (const char* name : {"distance", "witness", "manifest", "comparison"}) CHECK(gate[name].is_null());
  CHECK(gate["limit"]["max_distance"] == 1.0);
}

TEST_CASE("a name of any bytes gives valid JSON") {
  Report report = one_of_each();
  report.outcomes[0].gate.name = "part \xff \"quoted\"";
  CHECK(Json::parse(to_json(report))["gates"][0]["name"] == "part \xef\xbf\xbd \"quoted\"");
}
