#include "server/handlers/batches.h"

#include <algorithm>
#include <list>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "api/base/digest.h"
#include "api/base/problem.h"
#include "api/options/batch_request.h"
#include "server/handlers/batch_report.h"
#include "server/handlers/refusals.h"
#include "server/measure/live_job.h"
#include "server/measure/mesh_source.h"

namespace meshgauge::server {
namespace {

using api::not_found;
using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;
using store::BatchStore;
using Due = std::optional<Clock::time_point>;

constexpr std::size_t kRowsShown = 100;  // of each list in a batch's document
constexpr std::size_t kRowsOfPage = 100;
constexpr std::size_t kMostErrors = 100;  // that name meshes which are not stored
constexpr milliseconds kEventGap{500};    // between two events of a stream
// Between two looks at a batch that a client waits for: a share of its age, so that the answer is late by that share.
constexpr int kLooksOfAge = 20;
constexpr milliseconds kFirstLook{5}, kLastLook{500};
constexpr std::chrono::hours kMaxQueueTime{7 * 24};  // of a batch's jobs, at least: a batch may take days
constexpr std::chrono::seconds kRenewAfter{60};      // far less than the age at which a sweep removes unused blobs

// The batch was removed while the request arrived. Sent again, the request makes a new batch.
Problem batch_removed_just_now() {
  return {ProblemKind::storage_unavailable,
          "the batch of this Idempotency-Key was removed while the request arrived; send it again"};
}

store::JobKey key_of(const Exchange& exchange) { return {exchange.owner, exchange.segment}; }

struct BatchHead {
  store::JobKey key;
  std::string client;  // NewJob::client
  std::string idempotency_key;
  std::string trace;
  store::TimePoint created{};
  store::TimePoint expires_if_never_run{};
};

class NamedMeshes {
 public:
  NamedMeshes(const std::map<std::string, BatchFile>& files, const std::vector<store::MeshRow>& known) : files_(files) {
    for (const store::MeshRow& row : known) rows_.emplace(row.key.id, &row);
  }

  BatchFile operator()(const api::BatchMesh& mesh) const {
    if (!mesh.part.empty()) return files_.at(mesh.part);
    const auto found = rows_.find(mesh.id);
    if (found == rows_.end()) return {mesh.id, 0, "", ""};
    const store::MeshRow& row = *found->second;
    return {row.key.id, row.bytes, row.file_name, row.media_type};
  }

 private:
  const std::map<std::string, BatchFile>& files_;
  std::unordered_map<std::string, const store::MeshRow*> rows_;
};

MeshSource source_of(const std::string& part, const BatchFile& mesh) {
  return {{part, {}, mesh.file_name, mesh.media_type, -1}, nullptr, mesh.id, {}};
}

store::BatchItem item_of(const BatchHead& head, const api::BatchPair& pair, const std::string& options,
                         const BatchFile& a, const BatchFile& b) {
  store::BatchItem item;
  item.name = pair.name;
  store::NewJob& job = item.job;
  job.key = {head.key.owner, api::random_id()};
  job.mesh_a = a.id;
  job.mesh_b = b.id;
  job.hints = hints_of(source_of("a", a), source_of("b", b));
  job.options = options;
  job.cost = a.bytes + b.bytes;
  job.trace = head.trace;
  job.batch = head.key.id;
  job.client = head.client;
  job.created = head.created;
  job.expires_if_never_run = head.expires_if_never_run;
  item.work = work_of(job);
  return item;
}

// A digest of the request alone, not of its meshes' rows: these may be gone when the request is repeated.
std::string fingerprint_of(const api::BatchRequest& request, const store::NewBatch& batch) {
  api::Sha256 all;
  const auto add = [&](const std::string& text) {
    const std::string framed = std::to_string(text.size()) + ":" + text;
    all.update(std::as_bytes(std::span(framed)));
  };
  add(request.name);
  for (const store::BatchItem& item : batch.items) {
    for (const std::string* text : {&item.name, &item.job.mesh_a, &item.job.mesh_b, &item.job.options}) add(*text);
  }
  return all.hex();
}

// Returns the ids of the stored meshes that the batch names, each once.
std::vector<std::string> stored_ids(const api::BatchRequest& request) {
  std::set<std::string> ids;
  for (const api::BatchPair& pair : request.pairs) {
    for (const api::BatchMesh* mesh : {&pair.a, &pair.b}) {
      if (!mesh->id.empty()) ids.insert(mesh->id);
    }
  }
  return {ids.begin(), ids.end()};
}

// Returns a problem that lists up to 100 places where the request names a mesh that is not in `known`; nullopt: all
// are.
std::optional<api::Problem> find_unknown(const api::BatchRequest& request, const std::vector<store::MeshRow>& known) {
  std::unordered_set<std::string> ids;
  for (const store::MeshRow& row : known) ids.insert(row.key.id);
  api::Problem problem{api::ProblemKind::unknown_mesh, ""};
  std::set<std::string> unknown;
  for (std::size_t i = 0; i < request.pairs.size(); ++i) {
    const api::BatchPair& pair = request.pairs[i];
    for (const auto& [part, mesh] : {std::pair("a", &pair.a), std::pair("b", &pair.b)}) {
      if (mesh->id.empty() || ids.contains(mesh->id)) continue;
      unknown.insert(mesh->id);
      if (problem.errors.size() == kMostErrors) continue;
      problem.errors.push_back({part, "/comparisons/" + std::to_string(i) + "/" + part,
                                "the mesh " + mesh->id + " is not stored; send it by PUT /v1/meshes/" + mesh->id});
    }
  }
  if (unknown.empty()) return std::nullopt;
  problem.detail = std::to_string(unknown.size()) + " of the batch's meshes are not stored, the first at " +
                   problem.errors.front().where + "; send them by PUT /v1/meshes/{id}";
  return problem;
}

// Makes the rows of a batch. `files`: the uploaded files, by field name. `known`: rows of the stored meshes; it may
// lack some if the batch repeats an Idempotency-Key, since it is then only compared with the stored batch.
store::NewBatch compose(const BatchHead& head, const api::BatchRequest& request,
                        const std::map<std::string, BatchFile>& files, const std::vector<store::MeshRow>& known) {
  const NamedMeshes meshes(files, known);
  store::NewBatch batch;
  batch.key = head.key;
  batch.name = request.name;
  batch.idempotency_key = head.idempotency_key;
  batch.created = head.created;
  batch.meshes = stored_ids(request);
  batch.items.reserve(request.pairs.size());
  for (const api::BatchPair& pair : request.pairs) {
    batch.items.push_back(item_of(head, pair, request.options[pair.options], meshes(pair.a), meshes(pair.b)));
  }
  if (!batch.idempotency_key.empty()) batch.fingerprint = fingerprint_of(request, batch);
  return batch;
}

}  // namespace

Batches::Batches(const Settings& settings, const Jobs& jobs, const Stores& stores, Access& access, ByteBudget& uploads,
                 ConnectionLimit& watchers)
    : settings_(settings),
      jobs_(jobs),
      stores_(stores),
      batches_(*stores.batches),
      access_(access),
      uploads_(uploads),
      watchers_(watchers),
      kept_(settings.result_ttl_s) {}

void Batches::create(Exchange& exchange, bool draining) {
  if (draining) return answer(exchange, shutting_down());
  const auto& [key, wrong_key] = exchange.idempotency_key;
  if (wrong_key) return answer(exchange, *wrong_key);
  auto repeats = is_known(exchange.owner, key);
  // A batch that was accepted before needs no place in the queue. The batch that took the last place may be this one,
  // sent before: hence the second look.
  auto refusal = repeats && !*repeats ? admit(exchange.owner) : std::nullopt;
  if (refusal) repeats = is_known(exchange.owner, key);
  if (!repeats) return answer(exchange, api::to_problem(repeats.error()));
  if (refusal && !*repeats) return answer(exchange, *refusal);
  const UploadShare share(uploads_, client_of(exchange));
  const auto receiver = std::make_shared<BatchReceiver>(exchange.owner, !*repeats, settings_, stores_, access_, share);
  BatchReceiver::receive(receiver, exchange, [this, &exchange, known = *repeats, receiver](const auto& wrong) {
    wrong ? answer(exchange, *wrong) : insert(exchange, *receiver, known);
  });
}

Result<bool> Batches::is_known(const std::string& owner, const std::string& idempotency_key) {
  if (idempotency_key.empty()) return false;
  const auto there = batches_.find_idempotent_batch(owner, idempotency_key);
  if (!there) return there.error();
  return there->has_value();
}

// Limits each owner by its own batches, so that none is locked out by another owner's.
std::optional<Problem> Batches::admit(const std::string& owner) {
  const auto load = batches_.batch_load(owner);
  if (!load) return api::to_problem(load.error());
  if (load->jobs < kMostUnended * settings_.max_batch_pairs && load->batches < kMostBatches) return std::nullopt;
  const std::string most = std::to_string(kMostUnended * settings_.max_batch_pairs);
  return Problem{ProblemKind::overloaded, "too many comparisons of your batches are queued or running (limit " + most +
                                              " comparisons, " + std::to_string(kMostBatches) +
                                              " batches); retry later"};
}

// The meshes are reserved before they are looked up: if one is deleted meanwhile, its bytes stay for the batch.
void Batches::insert(Exchange& exchange, BatchReceiver& receiver, bool repeats) {
  const api::BatchRequest& request = receiver.request();
  const std::vector<std::string> ids = stored_ids(request);
  std::list<std::unique_ptr<const store::Reservations::Held>> reserved;
  for (const std::string& id : ids) {
    reserved.emplace_back(new store::Reservations::Held(stores_.blobs.reserve({exchange.owner, id})));
  }
  const auto known = stores_.meshes.known_meshes(exchange.owner, ids);
  if (!known) return answer(exchange, api::to_problem(known.error()));
  const auto missing = repeats ? std::nullopt : find_unknown(request, *known);
  if (missing) return answer(exchange, *missing);
  if (auto refusal = receiver.renew(kRenewAfter)) return answer(exchange, *refusal);
  const auto now = stores_.jobs.time();
  for (const store::MeshRow& row : *known) {
    stores_.meshes.touch_mesh(row.key, now, now + std::chrono::seconds(settings_.mesh_ttl_s));
  }
  const BatchHead head{{exchange.owner, exchange.id},
                       client_of(exchange),
                       exchange.idempotency_key.value,
                       traceparent(exchange.trace),
                       now,
                       now + std::max<std::chrono::seconds>(kept_, kMaxQueueTime)};
  store::NewBatch batch = compose(head, request, receiver.files(), *known);
  batch.repeats = repeats;
  const auto inserted = batches_.insert_batch(batch);
  if (!inserted) return answer(exchange, api::to_problem(inserted.error()));
  if (inserted->gone) return answer(exchange, batch_removed_just_now());
  if (inserted->mesh_gone) return answer(exchange, problem_of_removed_mesh(exchange.owner, request));
  if (inserted->conflict) {
    return answer(exchange, Problem{ProblemKind::idempotency_key_reused,
                                    "this Idempotency-Key was used for another batch; take a new one"});
  }
  exchange.response.headers.emplace_back("Location", "/v1/batches/" + inserted->batch.key.id);
  send(exchange, inserted->batch, 202);
}

Problem Batches::problem_of_removed_mesh(const std::string& owner, const api::BatchRequest& request) {
  const auto known = stores_.meshes.known_meshes(owner, stored_ids(request));
  if (!known) return api::to_problem(known.error());
  if (auto unknown = find_unknown(request, *known)) return *std::move(unknown);
  return {ProblemKind::storage_unavailable,
          "a mesh of the batch was removed and stored again meanwhile; send the batch again"};
}

std::optional<store::Batch> Batches::find(Exchange& exchange) {
  auto batch = batches_.get_batch(key_of(exchange));
  if (!batch) {
    answer(exchange, api::to_problem(batch.error()));
    return std::nullopt;
  }
  if (!*batch) answer(exchange, not_found("batch"));
  return std::move(*batch);
}

// Asks for no more rows than were counted: the search for those that run ends with the last one.
Result<std::string> Batches::document(const store::Batch& batch) {
  const store::BatchCounts& counts = batch.counts;
  const auto rows = [&](std::uint64_t count, BatchStore::Rows which) {
    using Rows = Result<std::vector<store::BatchRow>>;
    const std::size_t most = std::min<std::uint64_t>(count, kRowsShown);
    return most > 0 ? batches_.batch_rows(batch.key, which, 0, most) : Rows(std::vector<store::BatchRow>());
  };
  const auto failures =
      rows(counts.fail + counts.undecided + counts.failed + counts.cancelled, BatchStore::Rows::failures_first);
  if (!failures) return failures.error();
  const auto running = rows(counts.running, BatchStore::Rows::running);
  if (!running) return running.error();
  return to_json(batch, *failures, *running, kept_);
}

void Batches::send(Exchange& exchange, const store::Batch& batch, int status) {
  auto json = document(batch);
  if (!json) return answer(exchange, api::to_problem(json.error()));
  answer_with(exchange, std::move(*json), status);
}

// With Prefer: wait the answer is sent when another comparison has ended. A client for which there is no place waits by
// asking again.
void Batches::get(Exchange& exchange) {
  const auto first = find(exchange);
  if (!first) return;
  const auto wait = exchange.preferences.wait.value_or(milliseconds(0));
  const auto place = first->finished || wait == milliseconds(0) ? nullptr : watchers_.take(client_of(exchange));
  if (!place) return send(exchange, *first, 200);
  exchange.response.later = [this, place, wait, unended = first->counts.queued + first->counts.running,
                             until = Clock::now() + wait,
                             next = Clock::now() + look_interval(*first)](Exchange& later) mutable -> Due {
    const auto now = Clock::now();
    const bool waits = now < until && !later.client_gone && !jobs_.stopping();
    if (waits && now < next) return next;
    const auto batch = find(later);
    if (!batch) return std::nullopt;
    if (waits && batch->counts.queued + batch->counts.running == unended) {
      next = std::min<Clock::time_point>(until, now + look_interval(*batch));
      return next;
    }
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(wait).count();
    later.response.headers.emplace_back("Preference-Applied", "wait=" + std::to_string(seconds));
    send(later, *batch, 200);
    return std::nullopt;
  };
}

milliseconds Batches::look_interval(const store::Batch& batch) const {
  return std::clamp<milliseconds>((stores_.jobs.time() - batch.created) / kLooksOfAge, kFirstLook, kLastLook);
}

void Batches::remove(Exchange& exchange) {
  const store::JobKey key = key_of(exchange);
  const auto forgotten = batches_.forget_batch(key);
  if (!forgotten) return answer(exchange, api::to_problem(forgotten.error()));
  if (*forgotten) {
    exchange.response.status = 204;
    return;
  }
  end(exchange, key);
}

void Batches::cancel(Exchange& exchange) { end(exchange, key_of(exchange)); }

void Batches::end(Exchange& exchange, const store::JobKey& key) {
  const auto cancelled = batches_.cancel_batch(key, stores_.jobs.moment(kept_));
  if (!cancelled) return answer(exchange, api::to_problem(cancelled.error()));
  if (const auto batch = find(exchange)) send(exchange, *batch, 200);
}

void Batches::events(Exchange& exchange) {
  if (!find(exchange)) return;
  const auto place = take_place(exchange, watchers_, settings_);
  if (!place) return;
  exchange.response.content_type = "text/event-stream";
  exchange.response.length_known = false;
  if (exchange.head.method == "HEAD") return;
  exchange.response.stream = [this, key = key_of(exchange), place, last_sent = std::string(),
                              next = Clock::time_point()](std::string& piece) mutable -> Due {
    if (jobs_.stopping()) return std::nullopt;
    const auto now = Clock::now();
    if (now < next) return next;
    next = now + kEventGap;
    const auto batch = batches_.get_batch(key);
    if (!batch) return next;           // the store may be back at the next look
    if (!*batch) return std::nullopt;  // deleted
    if ((*batch)->finished) {
      const auto last = document(**batch);
      if (!last) return next;
      piece = event("end", *last);
      return std::nullopt;
    }
    std::string progress = progress_json(**batch);
    if (progress == last_sent) return next;
    last_sent = std::move(progress);
    piece = event("progress", last_sent);
    return next;
  };
}

// Throws if the batch was deleted while its rows were read: it may have had more.
void Batches::throw_if_deleted(const store::JobKey& key) {
  const auto batch = batches_.get_batch(key);
  if (!batch) throw std::runtime_error(batch.error().message);
  if (!*batch) throw std::runtime_error("the batch was deleted while its rows were sent");
}

// Reads the rows in pages, so that a batch of any size takes the memory of one page.
void Batches::stream_rows(Exchange& exchange, std::string head, std::function<std::string(const store::BatchRow&)> line,
                          std::string tail) {
  const auto place = take_place(exchange, watchers_, settings_);
  if (!place) return;
  exchange.response.length_known = false;
  if (exchange.head.method == "HEAD") return;
  exchange.response.stream = [this, key = key_of(exchange), place, head = std::move(head), line = std::move(line),
                              tail = std::move(tail), from = std::uint64_t{0}](std::string& piece) mutable -> Due {
    const auto rows = batches_.batch_rows(key, BatchStore::Rows::ended, from, kRowsOfPage);
    if (!rows) throw std::runtime_error(rows.error().message);
    const bool more = rows->size() == kRowsOfPage;
    if (!more) throw_if_deleted(key);
    piece = std::exchange(head, {});
    for (const store::BatchRow& row : *rows) piece += line(row);
    if (!rows->empty()) from = rows->back().position + 1;
    if (!more) piece += tail;
    return more ? Due(Clock::now()) : std::nullopt;
  };
}

void Batches::results(Exchange& exchange) {
  if (!find(exchange)) return;
  exchange.response.content_type = "application/jsonl";
  stream_rows(exchange, "", result_line, "");
}

void Batches::junit(Exchange& exchange) {
  const auto batch = find(exchange);
  if (!batch) return;
  if (!batch->finished) {
    return answer(exchange, Problem{ProblemKind::not_ended, "the batch has not ended; ask for its report when it has"});
  }
  exchange.response.content_type = "application/xml";
  stream_rows(
      exchange, junit_head(*batch), [batch = *batch](const store::BatchRow& row) { return junit_case(batch, row); },
      junit_tail());
}

}  // namespace meshgauge::server
