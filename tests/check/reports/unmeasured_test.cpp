// What was not measured of a gate that passes: surface that was not read, files that a glob passes over.
#include <string>

#include <doctest/doctest.h>

#include "check/html/html.h"
#include "check/reports/reports.h"
#include "check/reports/sample_reports.h"
#include "check/run/json_report.h"
#include "check/run/terminal.h"

using namespace meshgauge::check;

namespace {

bool holds(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("unmeasured: each report names it although the gate passes") {
  GateOutcome outcome = samples::passed("lid");
  outcome.measured->unread = {"the candidate: not read, surfaces: 2"};
  outcome.gate.notes = {"passes over files"};
  const Report report = samples::report_of({outcome});
  for (const bool quiet : {false, true}) {
    CHECK(holds(to_table(report, {false, quiet}), "    note: the candidate: not read, surfaces: 2\n"));
    CHECK(holds(to_table(report, {false, quiet}), "    note: passes over files\n"));
  }
  for (const std::string& text : {to_json(report), to_junit(report, {}), to_markdown(report), to_sarif(report),
                                  to_code_quality(report), to_html(report, {})}) {
    CAPTURE(text);
    CHECK(holds(text, "passes over files"));
    CHECK(holds(text, "surfaces"));
  }
  CHECK(holds(to_sarif(report), "toolExecutionNotifications"));
  CHECK(holds(to_code_quality(report), "meshgauge/part-not-measured"));
  CHECK(report.exit_code() == 0);
}

TEST_CASE("unmeasured: a gate that was measured whole has no word of it") {
  const Report report = samples::report_of({samples::passed("lid")});
  CHECK(to_table(report, {false, true}).empty());
  CHECK(to_code_quality(report) == "[]\n");
  CHECK_FALSE(holds(to_sarif(report), "toolExecutionNotifications"));
}
