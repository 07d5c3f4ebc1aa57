#include "server/handlers/job_document.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/base/problem.h"
#include "api/base/utc.h"
#include "api/options/request.h"
#include "api/result/json_of.h"
#include "server/measure/measuring.h"
#include "server/web/pages.h"

namespace meshgauge::server {
namespace {

using Json = nlohmann::ordered_json;  // writes infinity and NaN as null

// A path without a host: the client knows by which name it reached the service.
std::string view_of(const store::Job& row) { return "/c/" + row.key.id; }

Json json_of(const store::Progress& progress) {
  return {{"lower", progress.lower}, {"upper", progress.upper}, {"stage", api::text_or_null(progress.stage)}};
}

}  // namespace

Json gate_of(const store::Job& row) {
  const auto request = api::parse_options(row.options);
  return request ? api::gate_of(request->options) : Json(nullptr);
}

Json progress_of(const store::Job& row) {
  if (!row.progress || store::has_ended(row.state)) return nullptr;
  return json_of(*row.progress);
}

std::string problem_json(const store::Job& row) {
  if (!row.problem.empty()) return row.problem;
  if (row.state == store::JobState::cancelled && row.document.empty()) return api::to_json(cancelled_early());
  if (row.state != store::JobState::failed) return "null";
  return api::to_json(api::Problem{api::ProblemKind::internal, "given up: " + row.last_error});
}

std::string to_text(store::TimePoint time) { return api::to_utc_ms(time); }

Json time_or_null(const std::optional<store::TimePoint>& time) { return time ? Json(to_text(*time)) : Json(nullptr); }

std::string to_json(const JobView& job) {
  const store::Job& row = job.row;
  Json head{{"id", row.key.id},
            {"state", to_string(row.state)},
            {"created", to_text(row.created)},
            {"started", time_or_null(row.started)},
            {"finished", time_or_null(row.finished)},
            {"expires", time_or_null(row.expires)},
            {"tries", row.tries},
            {"gate", job.request ? api::gate_of(job.request->options) : gate_of(row)},
            {"progress", progress_of(row)}};
  if (has_pages()) head["view"] = view_of(row);
  // Result and problem are JSON already and may be large, so they are appended as text.
  std::string text = head.dump();
  text.pop_back();
  return text + ",\"result\":" + (row.document.empty() ? "null" : result_json(row)) +
         ",\"problem\":" + problem_json(row) + "}";
}

std::string result_json(const store::Job& row) {
  if (!has_pages()) return row.document;
  // The result is an object from api::to_json(), and not empty.
  return row.document.substr(0, row.document.size() - 1) + ",\"view\":\"" + view_of(row) + "\"}";
}

std::string progress_json(const JobView& job, store::TimePoint now) {
  const store::Job& row = job.row;
  // A clock that is set back in between must not make it negative.
  const auto since =
      std::max(store::TimePoint::duration(0), row.finished.value_or(now) - row.started.value_or(row.created));
  Json json{{"state", to_string(row.state)}};
  json.update(json_of(row.progress.value_or(store::Progress{0, std::numeric_limits<double>::infinity(), ""})));
  json["elapsed_ms"] = since.count();
  return json.dump();
}

}  // namespace meshgauge::server
