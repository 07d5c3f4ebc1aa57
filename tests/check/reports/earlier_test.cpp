#include "check/reports/earlier.h"

#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "check/criteria.h"
#include "check/reports/reports.h"
#include "check/reports/sample_reports.h"
#include "check/reports/wording.h"
#include "check/run/json_report.h"
#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

std::string pass_in_words() { return "pass, " + interval_of(samples::passed("x")); }

// As a run reads what another one wrote.
Earlier written(const Report& report, const std::string& name = "0123abc.json") {
  const api::test::Folder folder;
  folder.write(name, to_json(report));
  return earlier_run(folder / name);
}

GateOutcome gate_at(const std::string& name, double lower, double upper, double limit) {
  GateOutcome outcome = samples::passed(name);
  set_limit(outcome.gate, limit, LengthUnit::millimeter);
  set_criteria(*outcome.measured, {distance(lower, upper, limit)});
  return outcome;
}

}  // namespace

TEST_CASE("earlier: the run is named by its file, and has verdict and limits of each gate") {
  const Earlier earlier = written(samples::ordinary());
  CHECK(earlier.name == "0123abc");
  CHECK(earlier.problem.empty());
  REQUIRE(earlier.gates.size() == 5);
  const EarlierGate& lid = earlier.gates.find("lid")->second;
  CHECK(lid.verdict == Verdict::fail);
  CHECK(lid.unit == "mm");
  REQUIRE(lid.criteria.size() == 1);
  CHECK(lid.criteria[0].lower == 0.0968);
  CHECK(earlier.gates.find("screw")->second.criteria.empty());
}

TEST_CASE("earlier: gates of another verdict, new ones and those that are gone") {
  const Report before = samples::report_of({samples::passed("lid"), samples::passed("pin"), samples::passed("gone")});
  const Earlier earlier = written(before);
  const std::vector<Change> changes = changes_since(
      earlier, samples::report_of({samples::failed("lid"), samples::passed("pin"), samples::broken("new")}));
  REQUIRE(changes.size() == 3);
  CHECK(changes[0].gate == "lid");
  CHECK(changes[0].before == pass_in_words());
  CHECK(changes[0].now == "fail, 0.0968 .. 0.0977 mm");
  CHECK(changes[1].before.empty());
  CHECK(changes[1].now == "error");
  CHECK(changes[2].gate == "gone");
  CHECK(changes[2].now.empty());
  CHECK(changes_since(earlier, before).empty());
}

TEST_CASE("earlier: a limit that keeps its verdict moved only where its interval proves it, and notably") {
  const Earlier earlier = written(samples::report_of({gate_at("a", 1, 2, 10)}));
  const auto changed = [&](GateOutcome outcome) {
    return !changes_since(earlier, samples::report_of({std::move(outcome)})).empty();
  };
  CHECK(changed(gate_at("a", 2.2, 3, 10)));
  CHECK(changed(gate_at("a", 0.1, 0.8, 10)));
  CHECK_FALSE(changed(gate_at("a", 1.9, 3, 10)));
  CHECK_FALSE(changed(gate_at("a", 2.05, 3, 10)));
  GateOutcome in_inches = gate_at("a", 25, 26, 100);
  in_inches.gate.request.options.units.limit = LengthUnit::inch;
  CHECK_FALSE(changed(in_inches));
}

TEST_CASE("earlier: what is no report says so, and changes nothing else") {
  const api::test::Folder folder;
  CHECK(earlier_run(folder / "none.json").problem.find("none.json") != std::string::npos);
  for (const char* text : {"", "{", "[]", "{\"gates\": 1}", "\xff", "{\"gates\": [1, {}, {\"name\": 1}]}"}) {
    folder.write("x.json", text);
    const Earlier earlier = earlier_run(folder / "x.json");
    CHECK(earlier.gates.empty());
  }
  folder.write("x.json", "{\"gates\": [{\"name\": \"a\", \"verdict\": \"pass\", \"criteria\": 7, \"limit\": 1}]}");
  CHECK(earlier_run(folder / "x.json").gates.size() == 1);
  CHECK(earlier_run(folder / "x.json").problem.empty());
  std::string text = to_json(samples::ordinary());
  for (std::size_t bytes = 0; bytes + 3 < text.size(); bytes += 97) {
    folder.write("cut.json", text.substr(0, bytes));
    CHECK_FALSE(earlier_run(folder / "cut.json").problem.empty());
  }
}

TEST_CASE("earlier: Markdown says what changed, and escapes it") {
  Report report = samples::report_of({samples::failed("lid")});
  report.since = written(samples::report_of({samples::passed("lid"), samples::passed("a|b `x` @octocat")}));
  for (const std::string& text : {to_markdown(report), to_comment(report)}) {
    CHECK(text.find("\nChanged since `0123abc`:\n\n| gate | before | now |\n|---|---|---|\n"
                    "| `lid` | " +
                    pass_in_words() + " | fail, 0.0968 .. 0.0977 mm |\n") != std::string::npos);
    CHECK(text.find("| ``a\\x7Cb `x` @octocat`` | " + pass_in_words() + " | gone |\n") != std::string::npos);
  }
  report.since = written(report);
  CHECK(to_markdown(report).find("\nNothing changed since `0123abc`.\n") != std::string::npos);
  report.since->problem = "'x' is *no* report";
  CHECK(to_markdown(report).find("\nWhat changed since `0123abc` is not known: 'x' is &#42;no&#42; report.\n") !=
        std::string::npos);
  std::vector<GateOutcome> many;
  for (int i = 0; i < 25; ++i) many.push_back(samples::failed(std::to_string(i)));
  report = samples::report_of(many);
  report.since = written(samples::report_of({}));
  CHECK(to_markdown(report).find("\nAnd 5 others.\n") != std::string::npos);
}
