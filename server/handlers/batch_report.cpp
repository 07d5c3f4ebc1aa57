#include "server/handlers/batch_report.h"

#include <optional>
#include <string_view>

#include <nlohmann/json.hpp>

#include "api/base/figures.h"
#include "api/result/criteria.h"
#include "api/result/json_of.h"
#include "api/result/junit.h"
#include "api/result/result_document.h"
#include "server/handlers/job_document.h"
#include "server/web/pages.h"

namespace meshgauge::server {
namespace {

using api::Json;
using api::shortest;
using api::text_or_null;

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

const char* state_of(const store::Batch& batch) {
  if (!batch.finished) return "running";
  return batch.cancel_requested ? "cancelled" : "done";
}

Json counts_of(const store::BatchCounts& counts) {
  return {{"total", counts.total},        {"queued", counts.queued}, {"running", counts.running},
          {"done", counts.done},          {"failed", counts.failed}, {"cancelled", counts.cancelled},
          {"gone", counts.gone},          {"pass", counts.pass},     {"fail", counts.fail},
          {"undecided", counts.undecided}};
}

// The members that every list of a batch's comparisons has for each.
Json head_of(const store::BatchRow& row) {
  Json head{{"position", row.position}, {"name", text_or_null(row.name)}};
  head["comparison"] = row.job ? Json(row.job->key.id) : Json(nullptr);
  head["state"] = row.job ? to_string(row.job->state) : "gone";
  head["verdict"] = row.job ? text_or_null(row.job->verdict) : Json(nullptr);
  return head;
}

// Returns the job's result; not an object: it has none.
Json result_of(const store::Job& job) { return Json::parse(job.document, nullptr, false); }

// nullopt: the job has no result.
std::optional<api::ResultFacts> facts_of(const Json& result) {
  const auto facts = api::result_facts(result, api::Side::a);
  return facts ? std::optional(*facts) : std::nullopt;
}

// The max_distance of the job's gate; nullopt: none.
std::optional<double> limit_of(const store::Job& job) {
  const Json gate = gate_of(job);
  if (!gate.is_object() || !gate["max_distance"].is_number()) return std::nullopt;
  return gate["max_distance"].get<double>();
}

// The unit of the limit. Empty: not known, or there is no gate.
std::string_view unit_of(const Json& gate) {
  if (!gate.contains("units") || !gate["units"].is_string()) return "";
  return api::to_string(api::parse_unit(gate["units"].get_ref<const std::string&>()));
}

Json failure_of(const store::BatchRow& row) {
  Json failure = head_of(row);
  const auto facts = row.job ? facts_of(result_of(*row.job)) : std::nullopt;
  const Json gate = row.job ? gate_of(*row.job) : Json(nullptr);
  failure["gate"] = gate;
  failure["unit"] = text_or_null(facts ? api::to_string(facts->units.result.unit) : unit_of(gate));
  failure["distance"] = facts ? Json{{"lower", facts->lower}, {"upper", facts->upper}} : Json(nullptr);
  failure["problem"] = row.job ? Json::parse(problem_json(*row.job), nullptr, false) : Json(nullptr);
  return failure;
}

Json running_of(const store::BatchRow& row) {
  Json running = head_of(row);
  running["progress"] = row.job ? progress_of(*row.job) : Json(nullptr);
  return running;
}

double seconds_between(store::TimePoint from, store::TimePoint to) {
  return std::chrono::duration<double>(to - from).count();
}

// The time of the measurement. The store's times also include the time that a claimed job waits for a thread.
double seconds_of_work(const store::Job& job, const Json& result) {
  const auto times = result.is_object() ? result.find("timings_ms") : result.end();
  if (times == result.end() || !times->is_object()) {
    return job.started && job.finished ? seconds_between(*job.started, *job.finished) : 0;
  }
  return (times->value("total", 0.0) - times->value("queue", 0.0)) / 1000;
}

std::string name_of(const store::Batch& batch) { return batch.name.empty() ? batch.key.id : batch.name; }

std::string detail_of(const store::Job& job) {
  const auto problem = nlohmann::json::parse(problem_json(job), nullptr, false);
  return problem.is_object() ? problem.value("detail", std::string("the comparison failed")) : "the comparison failed";
}

// "fail: the distance in bore is at least 0.03 mm, above the limit of 0.02 mm; pass: ...", the foremost first. Empty:
// the result has no criteria, or was made by an earlier version.
std::string found_of_criteria(const Json& result, const std::string& unit) {
  std::string text;
  for (const api::Criterion& one : api::foremost_first(api::read_criteria(result)))
    text += (text.empty() ? "" : "; ") + std::string(to_string(one.verdict)) + ": " + api::finding_of(one, unit);
  return text;
}

// "; a was moved before, no point farther than 5.2 mm"; empty: it was not.
std::string found_of_alignment(const Json& result, const std::string& units) {
  const auto found = result.find("alignment");
  if (found == result.end()) return "";
  return "; a was moved before, no point farther than " + shortest((*found)["largest_displacement"]) + units;
}

std::string found(const store::Job& job, const Json& result) {
  const auto facts = facts_of(result);
  if (!facts) return detail_of(job);
  const std::string unit(api::to_string(facts->units.result.unit));
  const std::string units = unit.empty() ? "" : " " + unit;
  std::string text = found_of_criteria(result, unit);
  if (text.empty()) {
    text = "distance in [" + shortest(facts->lower) + ", " + shortest(facts->upper) + "]" + units;
    if (const auto limit = limit_of(job)) text += ", limit " + shortest(*limit) + units;
  }
  return text + found_of_alignment(result, units);
}

// nullopt: the job has passed, or has no gate.
std::optional<api::JUnitDefect> defect_of(const store::Job& job, const Json& result) {
  if (job.state != store::JobState::done) {
    return api::JUnitDefect{"error", to_string(job.state), found(job, result), ""};
  }
  if (job.verdict.empty() || job.verdict == "pass") return std::nullopt;
  return api::JUnitDefect{"failure", job.verdict, found(job, result), ""};
}

}  // namespace

std::string to_json(const store::Batch& batch, const std::vector<store::BatchRow>& failures,
                    const std::vector<store::BatchRow>& running, std::chrono::seconds kept) {
  Json json{{"id", batch.key.id},
            {"name", text_or_null(batch.name)},
            {"state", state_of(batch)},
            {"created", to_text(batch.created)},
            {"finished", time_or_null(batch.finished)},
            {"expires", batch.finished ? Json(to_text(*batch.finished + kept)) : Json(nullptr)},
            {"counts", counts_of(batch.counts)},
            {"failures", Json::array()},
            {"running", Json::array()}};
  if (has_pages()) json["view"] = "/b/" + batch.key.id;
  for (const store::BatchRow& row : failures) json["failures"].push_back(failure_of(row));
  for (const store::BatchRow& row : running) json["running"].push_back(running_of(row));
  return dumped(json);
}

std::string progress_json(const store::Batch& batch) {
  return dumped({{"state", state_of(batch)}, {"counts", counts_of(batch.counts)}});
}

std::string result_line(const store::BatchRow& row) {
  // Result and problem are JSON text already, and may be large: they are not parsed.
  std::string line = dumped(head_of(row));
  line.pop_back();
  const bool has_result = row.job && !row.job->document.empty();
  return line + ",\"result\":" + (has_result ? result_json(*row.job) : "null") +
         ",\"problem\":" + (row.job ? problem_json(*row.job) : "null") + "}\n";
}

std::string junit_head(const store::Batch& batch) {
  const store::BatchCounts& counts = batch.counts;
  api::JUnitSuite suite{name_of(batch), api::junit_class(name_of(batch)), 0, batch.created};
  suite.tests = counts.total;
  suite.failures = counts.fail + counts.undecided;
  suite.errors = counts.failed + counts.cancelled + counts.gone;
  suite.seconds = seconds_between(batch.created, batch.finished.value_or(batch.created));
  suite.properties = {{"batch", "/v1/batches/" + batch.key.id}};
  return api::junit_begin() + junit_suite(suite);
}

std::string junit_case(const store::Batch& batch, const store::BatchRow& row) {
  api::JUnitCase test{row.name.empty() ? "comparison " + std::to_string(row.position) : row.name,
                      api::junit_class(name_of(batch)), 0, std::nullopt};
  if (row.job) {
    const Json result = result_of(*row.job);
    test.seconds = seconds_of_work(*row.job, result);
    test.defect = defect_of(*row.job, result);
  } else {
    test.defect = api::JUnitDefect{"error", "gone", "the result was removed after its time or by its owner", ""};
  }
  if (test.defect) {
    test.defect->text = test.defect->message;
    if (row.job) test.defect->text += "\ncomparison: /v1/comparisons/" + row.job->key.id;
  }
  return junit_case(test);
}

std::string junit_tail() { return api::junit_suite_end() + api::junit_end(); }

}  // namespace meshgauge::server
