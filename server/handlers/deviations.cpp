#include "server/handlers/deviations.h"

#include <new>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/digest.h"
#include "api/base/problem.h"
#include "engine/hausdorff.h"
#include "server/access/entrance.h"
#include "server/handlers/refusals.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::not_found;
using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

// Beyond the time limit of a map that is being made, for its worker to report the time-out.
constexpr milliseconds kGrace{10'000};
constexpr std::size_t kShownIdDigits = 8;

std::optional<Problem> refuse_unready(const store::Job& row) {
  if (!store::has_ended(row.state)) {
    return Problem{ProblemKind::no_interval, "the comparison has not ended; ask for its maps when it has"};
  }
  if (!row.document.empty()) return std::nullopt;
  return Problem{ProblemKind::no_interval, "the comparison ended without an interval, so there is no map"};
}

Problem mesh_gone(const std::string& part, const std::string& id) {
  const std::string what =
      "the file of mesh '" + part + "' is not kept any more; send it by PUT /v1/meshes/" + id + " and ask again";
  return {ProblemKind::mesh_gone, what, {{part, "", what}}};
}

// A map has the same bytes as long as version and instruction set are the same.
std::string etag_of(const MapKey& key, const std::string& simd) {
  const std::string all = key.job.owner + "\n" + key.job.id + "\n" + key.name + "\n" + version() + "\n" + simd;
  return "\"" + api::sha256_hex(std::as_bytes(std::span(all))).substr(0, 32) + "\"";
}

// By weak comparison (RFC 9110 section 13.1.2).
bool matches(std::string_view if_none_match, std::string_view etag) {
  while (!if_none_match.empty()) {
    std::string_view tag = trimmed(next(if_none_match, ","));
    if (tag == "*") return true;
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == etag) return true;
  }
  return false;
}

// Returns the id of the comparison's mesh: from the row for stored meshes and durable comparisons, else the digest in
// the result, under which the owner may have stored the mesh since. Empty: not known.
std::string mesh_of(const store::Job& row, const std::string& part) {
  const std::string& id = part == "a" ? row.mesh_a : row.mesh_b;
  if (!id.empty()) return id;
  const auto document = nlohmann::json::parse(row.document, nullptr, false);
  const nlohmann::json::json_pointer digest("/meshes/" + part + "/sha256");
  return document.contains(digest) && document[digest].is_string() ? document[digest].get<std::string>() : "";
}

}  // namespace

struct Deviations::MapRequest {
  MapOrder order;
  store::Job row;
  std::string etag;
};

// Registers a client that waits for a map. When the last one is destroyed, the work is cancelled.
class Deviations::Watching {
 public:
  Watching(Deviations& all, std::shared_ptr<Making> making) : all_(all), making_(std::move(making)) {}
  ~Watching() { all_.leave(*making_); }
  Watching(const Watching&) = delete;
  Watching& operator=(const Watching&) = delete;

  Making& get() const { return *making_; }

 private:
  Deviations& all_;
  const std::shared_ptr<Making> making_;
};

Deviations::Deviations(const Settings& settings, Jobs& jobs, const Stores& stores, Access& access, Metrics& metrics,
                       MeshLoader& loader)
    : settings_(settings),
      jobs_(jobs),
      stores_(stores),
      access_(access),
      metrics_(metrics),
      tools_{settings, loader, *stores.maps, jobs.threads(), jobs.memory()},
      sending_(ConnectionLimit::shared(max_files_sent(settings))) {}

// Waits for idle_, not for a use_count of 1: reading use_count() does not synchronize with the tasks' writes.
Deviations::~Deviations() {
  works_.reset();
  while (!idle_.load()) std::this_thread::sleep_for(milliseconds(1));
}

void Deviations::get(Exchange& exchange, MapKind kind) {
  auto found = find(exchange, kind);
  if (const auto* problem = std::get_if<Problem>(&found)) return answer(exchange, *problem);
  auto& request = std::get<MapRequest>(found);
  if (matches(exchange.head.header("if-none-match"), request.etag)) {
    exchange.response.status = kNotModified;
    return add_validators(exchange, request.etag);
  }
  if (const auto file = stores_.maps->find(request.order.key)) {
    metrics_.map_found();
    return send(exchange, {request.etag, request.order.query, request.row.key.id}, MadeFile{file, {}});
  }
  if (auto problem = open_meshes(request)) return answer(exchange, *problem);
  if (exchange.head.method != "HEAD") return make(exchange, request);
  exchange.response.length_known = false;
  add_headers(exchange, {request.etag, request.order.query, request.row.key.id});
}

// Revalidated each time, so that the key is checked.
void Deviations::add_validators(Exchange& exchange, const std::string& etag) {
  exchange.response.headers.emplace_back("ETag", etag);
  exchange.response.headers.emplace_back("Cache-Control", "private, no-cache");
}

void Deviations::add_headers(Exchange& exchange, const Label& label) {
  add_validators(exchange, label.etag);
  const api::MapFormat& format = api::format_of(label.query.kind);
  exchange.response.content_type = format.media_type;
  const std::string name = "deviation-" + std::string(label.query.of == api::Side::a ? "a-" : "b-") +
                           label.job.substr(0, kShownIdDigits) + "." + std::string(format.name);
  exchange.response.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + name + "\"");
}

std::variant<Deviations::MapRequest, Problem> Deviations::find(const Exchange& exchange, MapKind kind) {
  const auto query = parse_map_query(exchange.head.query, kind);
  if (const auto* problem = std::get_if<Problem>(&query)) return *problem;
  MapRequest request;
  request.order.query = std::get<MapQuery>(query);
  request.order.key = {{exchange.owner, exchange.segment}, request.order.query.name()};
  auto job = jobs_.get(request.order.key.job);
  if (!job) return api::to_problem(job.error());
  if (!*job) return not_found("comparison");
  request.row = std::move((*job)->row);
  if (auto refusal = refuse_unready(request.row)) return *refusal;
  request.etag = etag_of(request.order.key, settings_.simd);
  return request;
}

std::variant<MeshSource, Problem> Deviations::open(const std::string& owner, const std::string& part,
                                                   const std::string& id) {
  auto blob = stores_.blobs.open({owner, id});
  if (!blob) return api::to_problem(blob.error());
  if (!*blob) return mesh_gone(part, id);
  return source_of(part, std::move(**blob), id);
}

// Marks a stored mesh as used now, and as one for the mesh cache.
std::optional<Problem> Deviations::touch_if_stored(MeshSource& source, const std::string& owner) {
  const store::BlobKey key{owner, source.id};
  const auto stored = stores_.meshes.get_mesh(key);
  if (!stored) return api::to_problem(stored.error());
  if (!*stored) return std::nullopt;
  const auto now = stores_.jobs.time();
  stores_.meshes.touch_mesh(key, now, now + std::chrono::seconds(settings_.mesh_ttl_s));
  source.kept = MeshCache::key(owner, source.id, source.input.filename, source.input.media_type);
  return std::nullopt;
}

std::optional<Problem> Deviations::open_meshes(MapRequest& request) {
  MapOrder& order = request.order;
  const std::string a = mesh_of(request.row, "a"), b = mesh_of(request.row, "b");
  // The cache notices deletions from here on; those before are found by the following look-ups.
  order.coming = stores_.maps->expect(order.key, {a, b});
  const auto job = jobs_.get(order.key.job);
  if (!job) return api::to_problem(job.error());
  if (!*job) return not_found("comparison");
  for (const char* part : {"a", "b"}) {
    auto found = open(request.row.key.owner, part, *part == 'a' ? a : b);
    if (const auto* problem = std::get_if<Problem>(&found)) return *problem;
    (*part == 'a' ? order.a : order.b) = std::move(std::get<MeshSource>(found));
  }
  set_hints(request.row.hints, order.a, order.b);
  for (MeshSource* source : {&order.a, &order.b}) {
    if (auto problem = touch_if_stored(*source, request.row.key.owner)) return problem;
    order.bytes += source->input.bytes.size();
  }
  auto facts = api::result_facts(nlohmann::ordered_json::parse(request.row.document, nullptr, false), order.query.of);
  if (!facts) return api::to_problem(facts.error());
  if (!facts->has_units)
    return Problem{ProblemKind::internal,
                   "the result was made by a version before 0.2.0 and has no unit; compare the meshes again"};
  order.facts = std::move(*facts);
  // The same time limit as the comparison had.
  const auto options = api::parse_options(request.row.options, request_limits(settings_));
  order.timeout = options ? options->timeout : milliseconds(settings_.default_timeout_ms);
  return std::nullopt;
}

void Deviations::make(Exchange& exchange, MapRequest& request) {
  if (jobs_.draining()) return answer(exchange, shutting_down());
  // Every waiting client occupies a connection and so takes a place, even if the map is already being made.
  auto slot = jobs_.admit_work(client_of(exchange));
  if (!slot) {
    return answer(exchange, queue_full(), jobs_.expected_wait_for_work());
  }
  auto counted = access_.take_job(exchange.owner);
  if (const auto* denial = std::get_if<Denial>(&counted)) return answer(exchange, *denial);
  const auto place = std::make_shared<const JobSlot>(std::get<JobSlot>(std::move(counted)));
  const Label label{request.etag, request.order.query, request.row.key.id};
  request.order.client = client_of(exchange);
  const auto making = std::make_shared<Watching>(*this, begin(request, slot));
  making->get().on_end(exchange.wake);
  exchange.response.later = [this, making, place, label](Exchange& later) { return look(later, label, making->get()); };
}

std::optional<Clock::time_point> Deviations::look(Exchange& exchange, const Label& label, const Making& making) {
  if (const Result<MadeFile>* result = making.result()) {
    *result ? send(exchange, label, **result) : fail(exchange, result->error());
    return std::nullopt;
  }
  const auto latest = making.submitted + making.order.timeout + (making.begun ? kGrace : milliseconds(0));
  if (Clock::now() >= latest) {
    answer(exchange,
           Problem{ProblemKind::out_of_time,
                   "no worker made the map within " + std::to_string(making.order.timeout.count()) + " ms; ask again"});
    return std::nullopt;
  }
  if (exchange.client_gone) {
    answer(exchange, Problem{ProblemKind::out_of_time, "cancelled: the client disconnected"});
    return std::nullopt;
  }
  return latest;
}

void Deviations::fail(Exchange& exchange, const Error& error) const {
  Problem problem = api::to_problem(error);
  const bool cancelled = error.code == ErrorCode::out_of_time && jobs_.stopping();
  if (cancelled) problem.kind = ProblemKind::shutting_down;
  answer(exchange, problem);
}

// Returns the map that is being made, or starts a new one, which takes the slot. The cache is looked at again under the
// lock: a map enters the cache before it leaves making_.
std::shared_ptr<Making> Deviations::begin(MapRequest& request, std::optional<Scheduler::Slot>& slot) {
  std::shared_ptr<Making> making;
  {
    const std::lock_guard lock(mutex_);
    if (const auto there = making_.find(request.order.key); there != making_.end()) {
      ++there->second->watchers;
      return there->second;
    }
    making = std::make_shared<Making>(std::move(request.order));
    making->watchers = 1;
    if (auto file = stores_.maps->find(making->order.key)) {
      metrics_.map_found();
      making->end(MadeFile{std::move(file), {}});
      return making;
    }
    making_.emplace(making->order.key, making);
  }
  try {
    submit(making, std::move(*slot));
  } catch (const std::bad_alloc&) {  // other clients may have joined and wait for its end
    making->end(Error{ErrorCode::internal, "out of memory", "", ""});
  }
  slot.reset();
  return making;
}

void Deviations::submit(const std::shared_ptr<Making>& making, Scheduler::Slot slot) {
  const MapOrder& order = making->order;
  jobs_.work(std::move(slot),
             {order.client, order.bytes, order.timeout, std::shared_ptr<Control>(making, &making->control),
              [this, making, works = works_](Scheduler::Slot held) { run(making, std::move(held)); }});
}

void Deviations::run(const std::shared_ptr<Making>& making, Scheduler::Slot slot) {
  auto result = make_map(*making, tools_);
  metrics_.map_ended(making->order.query.kind, result.ok(), result.ok() ? result->stages.back().ms / 1000 : 0);
  { const Scheduler::Slot done = std::move(slot); }
  making->end(std::move(result));
}

void Deviations::leave(Making& making) {
  {
    const std::lock_guard lock(mutex_);
    if (--making.watchers > 0) return;
    const auto found = making_.find(making.order.key);
    if (found != making_.end() && found->second.get() == &making) making_.erase(found);
  }
  making.control.cancel();
  jobs_.withdraw(making.control);
}

// The number is limited, so that one key's slow clients do not keep all maps from others.
void Deviations::send(Exchange& exchange, const Label& label, const MadeFile& made) {
  std::shared_ptr<const void> place;
  if (exchange.head.method != "HEAD" && !(place = sending_.take(exchange.owner))) {
    return answer(exchange, Problem{ProblemKind::overloaded, "too many maps are being sent (limit " +
                                                                 std::to_string(max_files_sent(settings_)) +
                                                                 "); retry in a moment"});
  }
  exchange.stages = made.stages;
  exchange.response.headers.emplace_back("Server-Timing",
                                         made.stages.empty() ? "cached" : api::to_server_timing(made.stages));
  add_headers(exchange, label);
  using Held = std::pair<MapCache::File, std::shared_ptr<const void>>;
  exchange.response.file = FileBody{made.file->bytes(), std::make_shared<const Held>(made.file, std::move(place))};
}

}  // namespace meshgauge::server
