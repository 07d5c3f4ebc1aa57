#include "check/remote/answer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/problem.h"
#include "api/base/text.h"
#include "api/compare/align.h"
#include "api/options/names.h"
#include "api/options/request.h"
#include "api/result/json_of.h"
#include "api/result/result_document.h"
#include "check/remote/address.h"

namespace meshgauge::check::service {
namespace {

using Json = nlohmann::ordered_json;

ErrorCode code_of(std::string_view slug) {
  if (slug == "quota-exceeded") return ErrorCode::storage_full;
  for (const api::ProblemRow& row : api::problem_table()) {
    if (row.slug == slug) return row.code.value_or(ErrorCode::invalid_request);
  }
  return ErrorCode::invalid_request;
}

// Empty if the member is missing or not a string.
std::string text(const Json& json, const char* member) {
  const auto found = json.find(member);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

double number_or(const Json& json, const char* member, double other) {
  const auto found = json.find(member);
  return found != json.end() && found->is_number() ? found->get<double>() : other;
}

// Returns a static string, since Progress::stage is not copied.
const char* stage_of(const std::string& stage) {
  for (const char* known : {"build", "traverse", "reduce", "certify"}) {
    if (stage == known) return known;
  }
  return "read";
}

// Interval and stage of a running comparison.
Progress progress_from(const Json& comparison) {
  const auto found = comparison.find("progress");
  const Json progress = found != comparison.end() && found->is_object() ? *found : Json::object();
  return {number_or(progress, "lower", 0), number_or(progress, "upper", Progress{}.upper),
          stage_of(text(progress, "stage"))};
}

bool has_units_of(const Json& comparison, const api::AskedUnits& asked) {
  if (comparison.find("unit") == comparison.end()) return false;  // the service does not know units
  if (asked == api::AskedUnits{}) return true;
  const api::UnitPlan given = api::unit_plan_of(comparison);
  const auto fits = [](const std::optional<LengthUnit>& wanted, const api::KnownUnit& known) {
    return !wanted || known.unit == wanted;
  };
  return fits(asked.limit, given.result) && fits(asked.a, given.a) && fits(asked.b, given.b);
}

bool is_id(const std::string& text) { return api::is_lower_hex(text, 32); }

// Checks the members that are shown; measured_from() checks the numbers.
bool is_comparison(const Json& json) {
  return json.is_object() && is_id(text(json, "id")) && api::value_of(api::kStops, text(json, "status"));
}

// False: the member is not a count.
bool read_count(const Json& json, const char* member, std::size_t& count) {
  const auto found = json.find(member);
  if (found == json.end() || !found->is_number_unsigned()) return false;
  count = found->get<std::size_t>();
  return true;
}

std::vector<std::pair<std::size_t, Progress>> running_from(const Json& batch, std::size_t total) {
  std::vector<std::pair<std::size_t, Progress>> running;
  const auto found = batch.find("running");
  if (found == batch.end() || !found->is_array()) return running;
  for (const Json& comparison : *found) {
    std::size_t position = 0;
    if (comparison.is_object() && read_count(comparison, "position", position) && position < total)
      running.emplace_back(position, progress_from(comparison));
  }
  return running;
}

// Whether it has the regions asked for, and the rest.
bool has_regions(const Json& comparison, const std::vector<Region>& asked_for) {
  const auto found = comparison.find("regions");
  if (found == comparison.end()) return asked_for.empty();
  if (asked_for.empty() || !found->is_array() || found->size() != asked_for.size() + 1) return false;
  for (std::size_t i = 0; i < asked_for.size(); ++i) {
    if (!found->at(i).is_object()) return false;
    const Json region = api::json_of(asked_for[i]);
    for (const auto& [member, asked] : region.items()) {
      if (!found->at(i).contains(member) || found->at(i).at(member) != asked) return false;
    }
  }
  return true;
}

std::string hint(int status, bool has_key) {
  if (status == 401) {
    return has_key ? " (the key is not accepted)" : " (give a key by --key-file or MESHGAUGE_KEY)";
  }
  return "";
}

}  // namespace

std::optional<Json> document_from(std::string_view body) {
  api::JsonFilter filter;
  if (!nlohmann::json::sax_parse(body, &filter)) return std::nullopt;
  return Json::parse(body);
}

// Only the expected path is accepted: a report must not link wherever a service says.
std::string take_view(Json& comparison) {
  const std::string said = text(comparison, "view");
  comparison.erase("view");
  const std::string page = "/c/" + text(comparison, "id");
  return said == page ? page : "";
}

std::string sha256_of(const Json& comparison, const char* part) {
  const auto meshes = comparison.find("meshes");
  if (meshes == comparison.end() || !meshes->is_object()) return "";
  const auto mesh = meshes->find(part);
  return mesh != meshes->end() && mesh->is_object() ? text(*mesh, "sha256") : "";
}

bool is_answer_to(const Json& comparison, const Gate& gate_asked) {
  const api::ComparisonOptions asked = options_in(gate_asked, comparison);
  if (text(comparison, "direction") != api::name_of(api::kDirections, asked.direction)) return false;
  if (!has_units_of(comparison, asked.units)) return false;
  const auto alignment = comparison.find("alignment");  // never moved, or left, unasked
  if ((alignment != comparison.end()) != asked.align.has_value()) return false;
  if (asked.align && !api::is_alignment_by(*alignment, *asked.align)) return false;
  const auto gate = comparison.find("gate");
  if (gate == comparison.end() || !gate->is_object()) return false;
  const auto has = [](const Json& json, const std::string& member, const Json& wanted) {
    const auto found = json.find(member);
    return found == json.end() ? wanted.is_null() : *found == wanted;
  };
  const Json limits = api::gate_of(asked);  // of which none may have been left out, and none added
  for (const Json* part : {&limits, &*gate}) {
    for (const auto& [name, limit] : part->items()) {
      if (api::is_about_limits(name) && !(has(limits, name, limit) && has(*gate, name, limit))) return false;
    }
  }
  return has_regions(comparison, asked.regions) &&
         has(comparison, "expect", asked.expect.any() ? api::json_of(asked.expect) : Json());
}

std::optional<Problem> problem_from(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  const std::string type = text(json, "type");
  const std::string slug(api::slug_of(type));
  if (slug.empty()) return std::nullopt;
  Problem problem{one_line(slug, 64), one_line(text(json, "detail")), "", ""};
  const auto errors = json.find("errors");
  if (errors == json.end() || !errors->is_array() || errors->empty() || !errors->front().is_object()) return problem;
  problem.part = one_line(text(errors->front(), "part"), 64);
  problem.where = one_line(text(errors->front(), "where"), 64);
  for (std::size_t i = 1; i < std::min<std::size_t>(errors->size(), 8); ++i) {
    if (errors->at(i).is_object()) problem.detail += "; " + one_line(text(errors->at(i), "message"));
  }
  return problem;
}

std::optional<Problem> problem_from(std::string_view body) {
  const auto json = document_from(body);
  return json ? problem_from(*json) : std::nullopt;
}

std::optional<BatchState> batch_from(std::string_view body) {
  const auto json = document_from(body);
  if (!json || !json->is_object()) return std::nullopt;
  const std::string state = text(*json, "state");
  BatchState batch{text(*json, "id"), text(*json, "view"), state != "running", 0, 0, {}};
  if (!is_id(batch.id) || (batch.finished && state != "done" && state != "cancelled")) return std::nullopt;
  const auto counts = json->find("counts");
  if (counts == json->end() || !counts->is_object() || !read_count(*counts, "total", batch.total)) return std::nullopt;
  std::size_t queued = 0, running = 0;
  if (!read_count(*counts, "queued", queued) || !read_count(*counts, "running", running)) return std::nullopt;
  if (queued > batch.total || running > batch.total - queued) return std::nullopt;
  batch.ended = batch.total - queued - running;
  batch.running = running_from(*json, batch.total);
  if (batch.view != "/b/" + batch.id) batch.view.clear();  // as in take_view()
  return batch;
}

std::optional<BatchLine> batch_line_from(std::string_view line) {
  auto json = document_from(line);
  BatchLine result;
  if (!json || !json->is_object() || !read_count(*json, "position", result.position)) return std::nullopt;
  const std::string state = text(*json, "state");
  if (state == "gone") return result;
  constexpr std::array kStates{"done", "failed", "cancelled"};
  if (!is_id(text(*json, "comparison")) || std::find(kStates.begin(), kStates.end(), state) == kStates.end())
    return std::nullopt;
  End& end = result.end.emplace();
  const auto document = json->find("result"), problem = json->find("problem");
  if (document != json->end() && is_comparison(*document)) end.document = std::move(*document);
  if (problem != json->end()) end.problem = problem_from(*problem);
  return result;
}

std::optional<double> run_ms(const Json& comparison) {
  const auto times = comparison.find("timings_ms");
  if (times == comparison.end() || !times->is_object()) return std::nullopt;
  const double ms = number_or(*times, "total", -1) - number_or(*times, "queue", 0);
  return ms >= 0 && ms < 1e12 ? std::optional(ms) : std::nullopt;
}

Error error_of(const Problem& problem, const Gate& gate, const std::string& base) {
  const ErrorCode code = code_of(problem.slug);
  const bool of_units = problem.where == "/gate/units";
  if (problem.part == "a" || problem.part == "b" || of_units)
    return with_files({code, problem.detail, problem.part, problem.where}, gate);
  return {code, "the service at " + base + " says: " + problem.detail, problem.part, problem.where};
}

Error error_of(const net::HttpAnswer& reply, const Gate& gate, const std::string& base, bool has_key) {
  if (reply.status >= 300 && reply.status < 400) {
    const std::string where = reply.redirect.empty() ? "nowhere" : "to " + one_line(reply.redirect, 200);
    return not_a_service(base, "it redirects " + where + "; give the address of the service itself");
  }
  const auto problem = problem_from(std::string_view(reply.body));
  if (!problem) {
    const std::string named = reply.header("content-type");
    const std::string type = named.empty() ? "no type" : one_line(named, 64);
    return not_a_service(base, "it answers " + std::to_string(reply.status) + " with a body of " + type);
  }
  Error error = error_of(*problem, gate, base);
  error.message += hint(reply.status, has_key);
  return error;
}

Error not_a_service(const std::string& base, const std::string& what) {
  return {ErrorCode::internal, base + " does not answer as a meshgauge service: " + what, "", "--server"};
}

}  // namespace meshgauge::check::service
