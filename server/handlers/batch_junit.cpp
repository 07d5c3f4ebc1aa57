#include "server/handlers/batch_junit.h"

#include <chrono>
#include <string>

#include <nlohmann/json.hpp>

#include "api/decimal.h"
#include "api/gate.h"
#include "api/junit.h"
#include "api/result_document.h"
#include "server/handlers/batch_document.h"
#include "server/jobs/job_document.h"

namespace meshgauge::server {
namespace {

using api::shortest;
using Json = nlohmann::ordered_json;

double seconds_between(store::TimePoint from, store::TimePoint to) {
  return std::chrono::duration<double>(to - from).count();
}

// The time of the measurement. The store's times also include the time that a claimed job waits for a thread.
double seconds_of_work(const store::Job& job) {
  const auto document = nlohmann::json::parse(job.document, nullptr, false);
  const auto times = document.is_object() ? document.find("timings_ms") : document.end();
  if (times == document.end() || !times->is_object()) {
    return job.started && job.finished ? seconds_between(*job.started, *job.finished) : 0;
  }
  return (times->value("total", 0.0) - times->value("queue", 0.0)) / 1000;
}

std::string name_of(const store::Batch& batch) { return batch.name.empty() ? batch.key.id : batch.name; }

std::string detail_of(const store::Job& job) {
  const auto problem = nlohmann::json::parse(problem_json(job), nullptr, false);
  return problem.is_object() ? problem.value("detail", std::string("the comparison failed")) : "the comparison failed";
}

// "; share of the area beyond 0.05 mm in [0.002, 0.003], limit 0.01"; empty without such a limit.
std::string found_of_area(const Json& document, const std::string& units) {
  const auto found = document.find("share_beyond");
  if (found == document.end()) return "";
  const auto& limit = document["gate"]["max_share_beyond"];
  return "; share of the area beyond " + shortest(limit["distance"]) + units + " in [" +
         shortest((*found)["share"]["lower"]) + ", " + shortest((*found)["share"]["upper"]) + "], limit " +
         shortest(limit["share"]);
}

// "; bore in [0.01, 0.02] mm, limit 0.02 mm: pass" for each region and the rest.
std::string found_of_regions(const Json& document, const std::string& units) {
  std::string text;
  if (!document.contains("regions")) return text;
  for (const auto& region : document["regions"]) {
    const auto& distance = region["distance"];
    text += "; " + region["name"].get<std::string>() + " in [" + shortest(distance["lower"]) + ", " +
            shortest(api::upper_of(distance)) + "]" + units;
    if (region.contains("max_distance"))
      text += ", limit " + shortest(region["max_distance"]) + units + ": " + region["verdict"].get<std::string>();
  }
  return text;
}

// "; inside in [0.01, 0.02] mm, limit 0.05 mm: pass; outside in [0.2, 0.3] mm, limit 0.1 mm: fail", or why there are no
// sides; empty without a zone.
std::string found_of_zone(const Json& document, const std::string& units) {
  if (!document.contains("sides") || !document["gate"].is_object() || !document["gate"].contains("zone")) return "";
  const auto& sides = document["sides"];
  if (!sides["refused"].is_null()) return "; no sides: " + sides["refused"]["detail"].get<std::string>();
  const double uncertainty = document["gate"].value("uncertainty", 0.0);
  const auto side = [&](const char* name, double limit) {
    const double lower = sides[name]["lower"], upper = api::upper_of(sides[name]);
    const auto verdict = to_string(api::verdict_within(lower, upper, limit, uncertainty));
    return std::string("; ") + name + " in [" + shortest(lower) + ", " + shortest(upper) + "]" + units + ", limit " +
           shortest(limit) + units + ": " + std::string(verdict);
  };
  const auto& zone = document["gate"]["zone"];
  return side("inside", -zone[0].get<double>()) + side("outside", zone[1].get<double>());
}

// "; a was moved before, no point farther than 5.2 mm"; empty: it was not.
std::string found_of_alignment(const Json& document, const std::string& units) {
  const auto found = document.find("alignment");
  if (found == document.end()) return "";
  return "; a was moved before, no point farther than " + shortest((*found)["largest_displacement"]) + units;
}

// "; watertight: no: 4 open edges, ..., expected yes: fail" for each expectation; empty without.
std::string found_of_expectations(const Json& document) {
  std::string text;
  if (!document.contains("expectations")) return text;
  for (const auto& one : document["expectations"])
    text += "; " + one["name"].get<std::string>() + ": " + one["found"].get<std::string>() + ", expected " +
            one["expected"].get<std::string>() + ": " + one["verdict"].get<std::string>();
  return text;
}

std::string found(const store::Job& job) {
  const auto facts = facts_of(job);
  if (!facts) return detail_of(job);
  const std::string units = unit_of(job).empty() ? "" : " " + unit_of(job);
  std::string text = "distance in [" + shortest(facts->lower) + ", " + shortest(facts->upper) + "]" + units;
  if (const auto limit = limit_of(job)) text += ", limit " + shortest(*limit) + units;
  const auto document = Json::parse(job.document, nullptr, false);
  return text + found_of_zone(document, units) + found_of_area(document, units) + found_of_regions(document, units) +
         found_of_expectations(document) + found_of_alignment(document, units);
}

std::optional<api::JUnitDefect> defect_of(const store::BatchRow& row) {
  if (!row.job) return api::JUnitDefect{"error", "gone", "the result was removed after its time or by its owner", ""};
  const store::Job& job = *row.job;
  if (job.state != store::JobState::done) return api::JUnitDefect{"error", to_string(job.state), found(job), ""};
  if (job.verdict.empty() || job.verdict == "pass") return std::nullopt;
  return api::JUnitDefect{"failure", job.verdict, found(job), ""};
}

}  // namespace

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
                      api::junit_class(name_of(batch)), row.job ? seconds_of_work(*row.job) : 0, defect_of(row)};
  if (test.defect) {
    test.defect->text = test.defect->message;
    if (row.job) test.defect->text += "\ncomparison: /v1/comparisons/" + row.job->key.id;
  }
  return junit_case(test);
}

std::string junit_tail() { return api::junit_suite_end() + api::junit_end(); }

}  // namespace meshgauge::server
