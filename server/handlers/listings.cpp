#include "server/handlers/listings.h"

#include <algorithm>
#include <charconv>

#include <nlohmann/json.hpp>

#include "api/base/problem.h"
#include "server/handlers/batches.h"
#include "server/handlers/job_document.h"
#include "server/handlers/meshes.h"
#include "server/http/head_values.h"
#include "server/http/text.h"
#include "server/measure/kept_blobs.h"
#include "server/web/pages.h"

namespace meshgauge::server {
namespace {

using api::Json;
using api::Problem;
using api::text_or_null;
using store::JobState;
using store::Page;

constexpr std::size_t kMostListed = 100;

// A page's place as clients send it back in `after`: "1772366400000-0af7..."
std::string text_of(const Page::Place& place) {
  return std::to_string(place.created.time_since_epoch().count()) + "-" + place.id;
}

std::optional<Page::Place> place_in(std::string_view text) {
  const std::string_view digits = next(text, "-");
  std::int64_t created = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), created);
  const bool whole = error == std::errc() && end == digits.data() + digits.size() && !digits.empty();
  if (!whole || !is_token(text) || text.size() > 64) return std::nullopt;
  return Page::Place{store::TimePoint(std::chrono::milliseconds(created)), std::string(text)};
}

std::variant<Page, Problem> read_page(const Exchange& exchange) {
  Page page{exchange.owner, std::nullopt, kMostListed};
  auto refusal =
      read_query(exchange.head.query, {"limit", "after"},
                 [&](std::string_view name, std::string_view value) -> std::optional<Problem> {
                   if (name == "after") {
                     page.after = place_in(value);
                     if (page.after) return std::nullopt;
                     return api::malformed("'after' must be the 'next' of the page before, not " + quoted(value));
                   }
                   const auto limit = whole_number(name, value, kMostListed);
                   if (const auto* problem = std::get_if<Problem>(&limit)) return *problem;
                   page.most = std::get<std::uint64_t>(limit);
                   return std::nullopt;
                 });
  if (refusal) return *std::move(refusal);
  return page;
}

Json json_of_row(const store::MeshRow& row) { return mesh_json(row); }

Json json_of_row(const store::ListedJob& row) {
  MeshSource a{{"a", {}, "", "", -1}, nullptr, row.mesh_a, {}}, b{{"b", {}, "", "", -1}, nullptr, row.mesh_b, {}};
  set_hints(row.hints, a, b);
  const auto mesh = [](const MeshSource& source) {
    return Json{{"id", text_or_null(source.id)}, {"file_name", text_or_null(source.input.filename)}};
  };
  Json json{{"id", row.key.id},
            {"state", to_string(row.state)},
            {"verdict", text_or_null(row.verdict)},
            {"created", to_text(row.created)},
            {"started", time_or_null(row.started)},
            {"finished", time_or_null(row.finished)},
            {"expires", time_or_null(row.expires)},
            {"batch", text_or_null(row.batch)},
            {"a", mesh(a)},
            {"b", mesh(b)}};
  if (has_pages()) json["view"] = "/c/" + row.key.id;
  return json;
}

Json json_of_row(const store::ListedBatch& row) {
  Json json{{"id", row.key.id},
            {"name", text_or_null(row.name)},
            {"created", to_text(row.created)},
            {"cancel_requested", row.cancel_requested},
            {"unended", row.unended}};
  if (has_pages()) json["view"] = "/b/" + row.key.id;
  return json;
}

}  // namespace

Listings::Listings(const Settings& settings, const Stores& stores, Access& access)
    : settings_(settings), stores_(stores), access_(access) {}

// Asks for one row more than the page has: whether there is a next page.
template <class Row>
void Listings::list(Exchange& exchange, const char* name, List<Row> of,
                    Result<Json> (Listings::*used)(const std::string&)) {
  if (!access_.has_keys()) {
    return answer(exchange, Problem{api::ProblemKind::forbidden,
                                    "only what belongs to a key can be listed, and this service runs without keys"});
  }
  auto page = read_page(exchange);
  if (const auto* problem = std::get_if<Problem>(&page)) return answer(exchange, *problem);
  auto& asked = std::get<Page>(page);
  const std::size_t most = asked.most++;
  auto rows = (stores_.listings->*of)(asked);
  if (!rows) return answer(exchange, api::to_problem(rows.error()));
  auto sums = (this->*used)(exchange.owner);
  if (!sums) return answer(exchange, api::to_problem(sums.error()));
  const bool more = rows->size() > most;
  if (more) rows->pop_back();
  Json json{{name, Json::array()}, {"next", nullptr}, {"used", std::move(*sums)}};
  for (const Row& row : *rows) json[name].push_back(json_of_row(row));
  if (more) json["next"] = text_of({rows->back().created, rows->back().key.id});
  answer_with(exchange, json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void Listings::meshes(Exchange& exchange) {
  list(exchange, "meshes", &store::Listings::list_meshes, &Listings::meshes_used);
}

// What has just ended may not be in the database yet; if it cannot be written now, the list is without it.
void Listings::comparisons(Exchange& exchange) {
  if (access_.has_keys()) static_cast<void>(stores_.jobs.flush());
  list(exchange, "comparisons", &store::Listings::list_jobs, &Listings::comparisons_used);
}

void Listings::batches(Exchange& exchange) {
  list(exchange, "batches", &store::Listings::list_batches, &Listings::batches_used);
}

// The key may have been removed since the request was authenticated.
Allowance Listings::allowance_of(const std::string& owner) const {
  return access_.allowance_of(owner).value_or(Allowance{0, 0, 0, 0});
}

Result<Json> Listings::meshes_used(const std::string& owner) {
  const auto meshes = stores_.meshes.stored(owner);
  if (!meshes) return meshes.error();
  const auto bytes = bytes_of(stores_, owner);
  if (!bytes) return bytes.error();
  return Json{{"meshes", meshes->meshes},
              {"max_meshes", settings_.max_stored_meshes},
              {"bytes", *bytes},
              {"max_bytes", std::min(settings_.max_stored_bytes, allowance_of(owner).max_storage_bytes)}};
}

Result<Json> Listings::comparisons_used(const std::string& owner) {
  const auto jobs = stores_.listings->jobs_owned(owner);
  if (!jobs) return jobs.error();
  const auto unended = stores_.jobs.unended(owner, stores_.jobs.time());
  if (!unended) return unended.error();
  Json json;
  for (const JobState state :
       {JobState::queued, JobState::running, JobState::done, JobState::failed, JobState::cancelled}) {
    json[to_string(state)] = jobs->by_state.at(static_cast<std::size_t>(state));
  }
  json["bytes"] = jobs->bytes;
  json["jobs"] = *unended;
  json["max_jobs"] = allowance_of(owner).max_jobs;
  return json;
}

Result<Json> Listings::batches_used(const std::string& owner) {
  const auto number = stores_.listings->batches_owned(owner);
  if (!number) return number.error();
  const auto load = stores_.batches->batch_load(owner);
  if (!load) return load.error();
  return Json{{"batches", *number},
              {"unended_batches", load->batches},
              {"max_unended_batches", Batches::kMostBatches},
              {"unended_comparisons", load->jobs},
              {"max_unended_comparisons", Batches::kMostUnended * settings_.max_batch_pairs}};
}

}  // namespace meshgauge::server
