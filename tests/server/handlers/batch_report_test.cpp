// Reports on a batch: its document, lines of results, its JUnit report.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "server/handlers/batch_report.h"

using namespace meshgauge::server;
using nlohmann::json;

namespace {

store::TimePoint at(std::int64_t ms) { return store::TimePoint(std::chrono::milliseconds(ms)); }

store::BatchRow row(std::uint64_t position, const std::string& name, store::JobState state = store::JobState::done,
                    const std::string& verdict = "") {
  store::Job job;
  job.key = {"ann", std::string(32, '0' + static_cast<char>(position))};
  job.state = state;
  job.options = R"({"gate":{"max_distance":0.25,"units":"mm"}})";
  job.verdict = verdict;
  job.created = at(0);
  job.started = at(1000);
  job.finished = at(2250);
  job.expires = at(9000);
  if (state == store::JobState::done) {
    job.document = R"({"id":"x","distance":{"lower":0.5,"upper":0.75},"unit":{"name":"mm","source":"assumed"}})";
  }
  return {position, name, job};
}

store::BatchRow gone(std::uint64_t position) { return {position, "", std::nullopt}; }

store::Batch batch(const std::string& name) {
  store::Batch batch;
  batch.key = {"ann", "b"};
  batch.name = name;
  batch.created = at(0);
  batch.finished = at(5000);
  batch.expires = at(9000);
  batch.counts = {6, 0, 0, 3, 1, 1, 1, 1, 1, 1};
  return batch;
}

std::string report(const store::Batch& batch, const std::vector<store::BatchRow>& rows) {
  std::string text = junit_head(batch);
  for (const store::BatchRow& row : rows) text += junit_case(batch, row);
  return text + junit_tail();
}

}  // namespace

TEST_CASE("batch report: every comparison is a test case with its defect") {
  const std::vector<store::BatchRow> rows{row(0, "good", store::JobState::done, "pass"),
                                          row(1, "bad", store::JobState::done, "fail"),
                                          row(2, "close", store::JobState::done, "undecided"),
                                          row(3, "broken", store::JobState::failed),
                                          row(4, "", store::JobState::cancelled),
                                          gone(5)};
  pugi::xml_document document;
  REQUIRE(document.load_string(report(batch("nightly.1"), rows).c_str()));
  const pugi::xml_node suite = document.child("testsuites").child("testsuite");
  CHECK(suite.attribute("name").value() == std::string("nightly.1"));
  CHECK(suite.attribute("package").value() == std::string("meshgauge.nightly_1"));
  CHECK(suite.attribute("timestamp").value() == std::string("1970-01-01T00:00:00"));
  CHECK(suite.attribute("time").value() == std::string("5.000"));
  CHECK(suite.attribute("tests").as_int() == 6);
  CHECK(suite.attribute("failures").as_int() == 2);
  CHECK(suite.attribute("errors").as_int() == 3);
  std::vector<std::string> told;
  for (const pugi::xml_node test : suite.children("testcase")) {
    const pugi::xml_node defect = test.first_child();
    told.push_back(std::string(test.attribute("name").value()) + " " + defect.name() + " " +
                   defect.attribute("type").value());
  }
  CHECK(told == std::vector<std::string>{"good  ", "bad failure fail", "close failure undecided", "broken error failed",
                                         "comparison 4 error cancelled", "comparison 5 error gone"});
  const pugi::xml_node bad = suite.child("testcase").next_sibling("testcase");
  CHECK(bad.attribute("time").value() == std::string("1.250"));
  CHECK(bad.child("failure").attribute("message").value() == std::string("distance in [0.5, 0.75] mm, limit 0.25 mm"));
}

TEST_CASE("batch report: valid XML for any names") {
  const std::string hostile = "<&>\"' ]]> \xC3\xA9 \xF0\x9F\x98\x80 \xEF\xBF\xBE\xEF\xBF\xBF";
  pugi::xml_document document;
  store::BatchRow failed = row(0, hostile, store::JobState::done, "fail");
  failed.job->options = R"({"gate":{"max_distance":1}})";
  failed.job->document = R"({"distance":{"lower":0.5,"upper":0.75},"unit":{"name":"<mm>","source":"\u0000"}})";
  const std::string text = report(batch(hostile), {failed});
  REQUIRE(document.load_string(text.c_str()));
  CHECK(text.find("distance in [0.5, 0.75], limit 1\"") != std::string::npos);  // what is no unit is not shown
  const pugi::xml_node suite = document.child("testsuites").child("testsuite");
  const std::string shown = "<&>\"' ]]> \xC3\xA9 \xF0\x9F\x98\x80 ??";
  CHECK(suite.attribute("name").value() == shown);
  CHECK(suite.child("testcase").attribute("name").value() == shown);
}

TEST_CASE("batch document: counts, times and failures") {
  store::BatchRow open = row(4, "unknown", store::JobState::done, "undecided");
  open.job->document = R"({"distance":{"lower":0,"upper":null}})";
  const json document = json::parse(
      to_json(batch(""), {row(1, "bad", store::JobState::done, "fail"), row(2, "", store::JobState::failed), open}, {},
              std::chrono::seconds(60)));
  CHECK(document["name"].is_null());
  CHECK(document["state"] == "done");
  CHECK(document["finished"] == "1970-01-01T00:00:05.000Z");
  CHECK(document["expires"] == "1970-01-01T00:01:05.000Z");
  CHECK(document["counts"]["total"] == 6);
  CHECK(document["counts"]["undecided"] == 1);
  CHECK(document["failures"][0]["distance"] == json{{"lower", 0.5}, {"upper", 0.75}});
  CHECK(document["failures"][0]["unit"] == "mm");
  CHECK(document["failures"][2]["unit"].is_null());  // its result does not say
  CHECK(document["failures"][0]["problem"].is_null());
  CHECK(document["failures"][1]["distance"].is_null());
  CHECK(document["failures"][1]["problem"]["status"] == 500);
  CHECK(document["failures"][2]["distance"] == json{{"lower", 0}, {"upper", nullptr}});
}

TEST_CASE("batch document: running until the last comparison has ended, then cancelled") {
  store::Batch cancelled = batch("b");
  cancelled.cancel_requested = true;
  CHECK(json::parse(progress_json(cancelled))["state"] == "cancelled");
  cancelled.finished.reset();
  store::BatchRow begun = row(1, "begun", store::JobState::running);
  begun.job->progress = store::Progress{0.5, 0.75, "reduce", ""};
  const json running =
      json::parse(to_json(cancelled, {}, {begun, row(2, "", store::JobState::running)}, std::chrono::seconds(60)));
  CHECK(running["state"] == "running");
  CHECK(running["finished"].is_null());
  CHECK(running["expires"].is_null());
  CHECK(running["running"][0]["position"] == 1);
  CHECK(running["running"][0]["comparison"] == std::string(32, '1'));
  CHECK(running["running"][0]["progress"] == json{{"lower", 0.5}, {"upper", 0.75}, {"stage", "reduce"}});
  CHECK(running["running"][1]["progress"].is_null());
}

TEST_CASE("batch document: a line for each result") {
  const json done = json::parse(result_line(row(3, "a", store::JobState::done, "pass")));
  CHECK(done["position"] == 3);
  CHECK(done["comparison"] == std::string(32, '3'));
  CHECK(done["verdict"] == "pass");
  CHECK(done["result"]["distance"]["lower"] == 0.5);
  CHECK(done["problem"].is_null());
  const json lost = json::parse(result_line(gone(5)));
  CHECK(lost["state"] == "gone");
  CHECK(lost["comparison"].is_null());
  CHECK(lost["result"].is_null());
  const std::string line = result_line(row(0, "two\nlines"));
  CHECK(line.find('\n') == line.size() - 1);
}
