#include "server/handlers/batch_document.h"

#include <nlohmann/json.hpp>

#include "api/json_of.h"
#include "server/measure/job_document.h"
#include "server/web/pages.h"

namespace meshgauge::server {
namespace {

using api::Json;
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

Json failure_of(const store::BatchRow& row) {
  Json failure = head_of(row);
  const auto facts = row.job ? facts_of(*row.job) : std::nullopt;
  failure["gate"] = row.job ? gate_of(*row.job) : Json(nullptr);
  failure["unit"] = row.job ? text_or_null(unit_of(*row.job)) : Json(nullptr);
  failure["distance"] = facts ? Json{{"lower", facts->lower}, {"upper", facts->upper}} : Json(nullptr);
  failure["problem"] = row.job ? Json::parse(problem_json(*row.job), nullptr, false) : Json(nullptr);
  return failure;
}

}  // namespace

std::string to_json(const store::Batch& batch, const std::vector<store::BatchRow>& failures,
                    std::chrono::seconds kept) {
  Json json{{"id", batch.key.id},
            {"name", text_or_null(batch.name)},
            {"state", state_of(batch)},
            {"created", to_text(batch.created)},
            {"finished", time_or_null(batch.finished)},
            {"expires", batch.finished ? Json(to_text(*batch.finished + kept)) : Json(nullptr)},
            {"counts", counts_of(batch.counts)},
            {"failures", Json::array()}};
  if (has_pages()) json["view"] = "/b/" + batch.key.id;
  for (const store::BatchRow& row : failures) json["failures"].push_back(failure_of(row));
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

std::optional<api::ResultFacts> facts_of(const store::Job& job) {
  const auto facts = api::result_facts(Json::parse(job.document, nullptr, false), api::Side::a);
  return facts ? std::optional(*facts) : std::nullopt;
}

std::optional<double> limit_of(const store::Job& job) {
  const Json gate = gate_of(job);
  if (!gate.is_object() || !gate["max_distance"].is_number()) return std::nullopt;
  return gate["max_distance"].get<double>();
}

std::string unit_of(const store::Job& job) {
  std::optional<api::LengthUnit> unit;
  if (const auto facts = facts_of(job)) {
    unit = facts->units.result.unit;
  } else if (const Json gate = gate_of(job); gate.contains("units") && gate["units"].is_string()) {
    unit = api::parse_unit(gate["units"].get_ref<const std::string&>());
  }
  return unit ? std::string(api::to_string(*unit)) : std::string();
}

}  // namespace meshgauge::server
