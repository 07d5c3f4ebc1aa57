#include "check/reports/history.h"

#include <cmath>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

#include "check/criteria.h"
#include "check/html/diagrams.h"
#include "check/reports/reports.h"
#include "check/reports/sample_reports.h"
#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Report runs_after(const std::filesystem::path& file, int count) {
  Report report;
  for (int i = 0; i < count; ++i) {
    report = samples::report_of({samples::passed("lid"), samples::failed("pin"), samples::broken("nut")});
    auto history = History::open(file);
    REQUIRE(history);
    REQUIRE(history->keep("2026-11-25T12:00:00Z", "c" + std::to_string(i), report));
  }
  return report;
}

}  // namespace

TEST_CASE("history: a line a gate and run, of which each outcome gets the last 30") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  const Report first = runs_after(file, 1);
  CHECK(folder.read("history.jsonl") ==
        "{\"time\":\"2026-11-25T12:00:00Z\",\"commit\":\"c0\",\"gate\":\"lid\",\"verdict\":\"pass\",\"lower\":0.001,"
        "\"upper\":0.0123,\"limit\":0.05,\"unit\":\"mm\",\"criteria\":[{\"name\":\"distance\",\"lower\":0.001,"
        "\"upper\":0.0123,\"limit\":0.05}]}\n"
        "{\"time\":\"2026-11-25T12:00:00Z\",\"commit\":\"c0\",\"gate\":\"pin\",\"verdict\":\"fail\",\"lower\":0.0968,"
        "\"upper\":0.0977,\"limit\":0.05,\"unit\":\"mm\",\"criteria\":[{\"name\":\"distance\",\"lower\":0.0968,"
        "\"upper\":0.0977,\"limit\":0.05}]}\n"
        "{\"time\":\"2026-11-25T12:00:00Z\",\"commit\":\"c0\",\"gate\":\"nut\",\"verdict\":\"error\",\"lower\":null,"
        "\"upper\":null,\"limit\":null,\"unit\":\"mm\",\"criteria\":[]}\n");
  CHECK(first.outcomes[0].history.size() == 1);

  const Report last = runs_after(file, 40);
  for (const GateOutcome& outcome : last.outcomes) {
    REQUIRE(outcome.history.size() == 30);
    CHECK(outcome.history.front().commit == "c10");
    CHECK(outcome.history.back().commit == "c39");
    CHECK(outcome.history.back().verdict == outcome.verdict());
  }
  CHECK(last.outcomes[1].history[3].upper == 0.0977);
  CHECK(!last.outcomes[2].history[3].upper);
}

TEST_CASE("history: a line that is no result is named, and nothing is lost") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  runs_after(file, 1);
  const std::string good = folder.read("history.jsonl");
  for (const char* bad : {"<<<<<<< HEAD", "{}", "[1]", "{\"gate\":\"a\",\"verdict\":\"maybe\"}"}) {
    std::ofstream(file) << good << bad << "\n";
    const auto history = History::open(file);
    REQUIRE(!history);
    CHECK(history.error().where == "--history");
    CHECK(history.error().message.find("line 4 is no result of a gate") != std::string::npos);
    CHECK(folder.read("history.jsonl") == good + bad + "\n");
  }
}

TEST_CASE("history: drawn as letters and as bars, from two runs on") {
  CHECK(sparkline({}).empty());
  CHECK(sparkline({PastRun{}}).empty());
  const auto run = [](Verdict verdict, double upper) { return PastRun{"", verdict, 0.0, upper, 1.0, "mm"}; };
  CHECK(sparkline({run(Verdict::pass, 0), run(Verdict::pass, 0.99), run(Verdict::pass, 1), run(Verdict::fail, 90),
                   PastRun{"", Verdict::fail, 2.0, {}, 1.0, ""}, PastRun{"", Verdict::error, {}, {}, {}, ""}}) ==
        "▁▅▅██·");
  CHECK(history_drawing({"the distance", "mm", {run(Verdict::pass, 1)}}).empty());
  const std::string drawn = history_drawing({"the distance", "mm", {run(Verdict::pass, 0.5), run(Verdict::fail, 2)}});
  CHECK(drawn.find("Last 2 runs") != std::string::npos);
  CHECK(drawn.find("the limit is 1 mm") != std::string::npos);
  CHECK(drawn.find("class=\"bar pass\"") != std::string::npos);
  CHECK(drawn.find("class=\"bar fail\"") != std::string::npos);
}

TEST_CASE("history: each side of a zone has a chart, and the uncertainty is kept") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  Report report;
  for (int i = 0; i < 2; ++i) {
    report = samples::report_of({samples::zone("lid"), samples::zone("open")});
    for (GateOutcome& outcome : report.outcomes) change(*outcome.measured, [](Criterion& c) { c.uncertainty = 0.01; });
    change(*report.outcomes[0].measured, [](Criterion& c) { c.upper = c.side == "outside" ? INFINITY : c.upper; });
    change(*report.outcomes[1].measured, [](Criterion& c) {
      c.upper = INFINITY;
      c.refused = "the baseline is open";
    });
    auto history = History::open(file);
    REQUIRE(history);
    REQUIRE(history->keep("2026-11-25T12:00:00Z", "", report));
  }
  const std::string lines = folder.read("history.jsonl");
  CHECK(lines.find("\"uncertainty\":0.01,\"criteria\":[{\"name\":\"distance inside\",\"lower\":0.06,\"upper\":0.07,"
                   "\"limit\":0.05},{\"name\":\"distance outside\",\"lower\":0.01,\"upper\":null,\"limit\":0.1}]}") !=
        std::string::npos);
  CHECK(lines.find("{\"name\":\"distance inside\",\"lower\":null,\"upper\":null,\"limit\":0.05") != std::string::npos);
  const auto charts = charts_of(report.outcomes[0]);
  REQUIRE(charts.size() == 2);
  CHECK(charts[0].what == "the distance inside");
  CHECK(charts[0].runs[0].upper == 0.07);
  CHECK(charts[0].runs[0].limit == 0.05);
  CHECK(charts[1].what == "the distance outside");
  CHECK(!charts[1].runs[0].upper);
  CHECK(sparkline(charts_of(report.outcomes[1])[0].runs) == "··");
  const std::string drawn = history_drawing(charts[0]);
  CHECK(drawn.find("the limit is 0.05 mm \xC2\xB1 0.01 mm") != std::string::npos);
  CHECK(drawn.find("class=\"uncertain-step\"") != std::string::npos);
}

TEST_CASE("history: each region has a chart, from the run on that has it") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  Report report;
  for (int i = 0; i < 3; ++i) {
    report = samples::report_of({samples::passed("lid")});
    Measured& lid = *report.outcomes[0].measured;
    if (i > 0)
      set_criteria(
          lid, {in_region("rest", lid.criteria[0]), in_region("bore", distance(0.03, i == 1 ? INFINITY : 0.04, 0.02))});
    auto history = History::open(file);
    REQUIRE(history);
    REQUIRE(history->keep("2026-11-25T12:00:00Z", "", report));
  }
  const std::string lines = folder.read("history.jsonl");
  const auto bore = lines.find("{\"name\":\"distance in bore\",\"lower\":0.03,\"upper\":null,\"limit\":0.02}");
  REQUIRE(bore != std::string::npos);
  CHECK(bore > lines.find('\n'));  // the first run has none
  const auto charts = charts_of(report.outcomes[0]);
  REQUIRE(charts.size() == 2);
  CHECK(charts[0].what == "the distance outside of all regions");
  CHECK(!charts[0].runs[0].limit);  // the limit of the whole was another one
  CHECK(charts[0].runs[2].upper == 0.0123);
  CHECK(charts[1].what == "the distance in bore");
  REQUIRE(charts[1].runs.size() == 3);
  CHECK(!charts[1].runs[0].limit);
  CHECK(!charts[1].runs[1].upper);
  CHECK(charts[1].runs[2].limit == 0.02);
  CHECK(charts[1].runs[2].verdict == Verdict::fail);
  CHECK(sparkline(charts[1].runs) == "\u00b7\u2588\u2588");
}

TEST_CASE("history: criteria that are none are not read") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  std::ofstream(file) << R"({"gate":"lid","verdict":"pass","criteria":[3,{},{"name":"b"},{"name":"c","limit":"1"},)"
                      << R"({"limit":1},{"name":"d","limit":1}]})"
                      << "\n";
  for (const char* none : {"[]", "{\"a\":{\"limit\":1}}", "\"x\"", "null", "3"})
    std::ofstream(file, std::ios::app) << R"({"gate":"lid","verdict":"pass","criteria":)" << none << "}\n";
  auto history = History::open(file);
  REQUIRE(history);
  Report report = samples::report_of({samples::passed("lid")});
  REQUIRE(history->keep("2026-11-25T12:00:00Z", "", report));
  const auto& runs = report.outcomes[0].history;
  REQUIRE(runs.size() == 7);
  REQUIRE(runs[0].criteria.size() == 1);
  CHECK(runs[0].criteria.at("d").limit == 1);
  for (std::size_t i = 1; i < 6; ++i) CHECK(runs[i].criteria.empty());
  CHECK(runs[6].criteria.at("distance").limit == 0.05);
}

TEST_CASE("history: each limit is drawn by its own verdict") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  Report report;
  for (int i = 0; i < 2; ++i) {
    report = samples::report_of({samples::zone("lid")});
    Measured& lid = *report.outcomes[0].measured;
    set_criteria(lid, {distance(0.06, 0.07, 1), lid.criteria[0], on_side("outside", distance(0, 0, 0))});
    CHECK(report.outcomes[0].verdict() == Verdict::fail);
    auto history = History::open(file);
    REQUIRE(history);
    REQUIRE(history->keep("2026-11-25T12:00:00Z", "", report));
  }
  const auto charts = charts_of(report.outcomes[0]);
  REQUIRE(charts.size() == 3);
  CHECK(charts[0].runs[0].verdict == Verdict::pass);
  CHECK(charts[1].runs[0].verdict == Verdict::fail);
  CHECK(charts[2].runs[0].verdict == Verdict::pass);
  CHECK(sparkline(charts[2].runs) == "\u2581\u2581");
}

TEST_CASE("history: Markdown shows the course of a gate that passes as of one that fails") {
  const api::test::Folder folder;
  Report report;
  for (int i = 0; i < 2; ++i) {
    report = samples::report_of({samples::passed("pin"), samples::failed("lid")});
    auto history = History::open(folder / "history.jsonl");
    REQUIRE(history);
    REQUIRE(history->keep("2026-11-25T12:00:00Z", "", report));
    const std::string text = to_markdown(report);
    const bool is_second = i == 1;
    CHECK((text.find("\n\n- `pin`: last 2 runs of the distance, the limit is the height of `\u2585`: `") !=
           std::string::npos) == is_second);
    CHECK((text.find("\n- last 2 runs of the distance, the limit is the height of `\u2585`: `") != std::string::npos) ==
          is_second);
  }
  const std::string small = to_markdown(report, 2000);
  CHECK(small.size() <= 2000);
}

TEST_CASE("history: a limit of the area has a chart of its own") {
  const api::test::Folder folder;
  const auto file = folder / "history.jsonl";
  Report report;
  for (int i = 0; i < 2; ++i) {
    report = samples::report_of({samples::area("lid"), samples::passed("pin")});
    auto history = History::open(file);
    REQUIRE(history);
    REQUIRE(history->keep("2026-11-25T12:00:00Z", "", report));
  }
  CHECK(folder.read("history.jsonl")
            .find("\"limit\":null,\"unit\":\"mm\",\"criteria\":[{\"name\":\"share beyond\",\"lower\":0.00201234,"
                  "\"upper\":0.00269876,\"limit\":0.01}]}") != std::string::npos);
  const auto charts = charts_of(report.outcomes[0]);
  REQUIRE(charts.size() == 1);
  CHECK(charts[0].what == "the area farther than 0.05 mm");
  CHECK(charts[0].runs[0].limit == 1.0);
  CHECK(charts[0].runs[0].upper == doctest::Approx(0.269876));
  CHECK(sparkline(charts[0].runs) == "▂▂");
  CHECK(charts_of(report.outcomes[1]).size() == 1);
  GateOutcome both = report.outcomes[0];
  set_criteria(*both.measured, {distance(0.06, 0.07, 1), both.measured->criteria.front()});
  CHECK(charts_of(both).size() == 2);
}
