// Jobs: submissions.
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/digest.h"
#include "server/jobs/jobs.h"
#include "server/measure/revived.h"

namespace meshgauge::server {
namespace {

using api::ProblemKind;
using std::chrono::seconds;

// Added to the deadline of an awaited job: by then the client has its answer.
constexpr seconds kNeverRun{10};

// The fingerprint: equal for requests that may share an idempotency key.
std::string fingerprint_of(const std::string& a, const std::string& b, const std::string& options) {
  const std::string all = a + "\n" + b + "\n" + options;
  return api::sha256_hex(std::as_bytes(std::span(all)));
}

// Without blanks and needless digits: what is stored is as small as what it says.
std::string canonical(const std::string& options) {
  const auto json = nlohmann::json::parse(options, nullptr, false);
  return json.is_object() ? json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) : options;
}

void name_meshes(Submission& submission) {
  for (MeshSource* source : {&submission.a, &submission.b}) {
    if (source->id.empty()) source->id = api::sha256_hex(source->input.bytes);
  }
}

store::NewJob row_of(const Submission& submission, store::TimePoint now, seconds ttl) {
  store::NewJob row;
  row.key = submission.key;
  row.client = submission.client;
  row.mesh_a = submission.a.id;
  row.mesh_b = submission.b.id;
  row.hints = hints_of(submission.a, submission.b);
  row.options = canonical(submission.options);
  row.cost = submission.a.input.bytes.size() + submission.b.input.bytes.size();
  row.idempotency_key = submission.idempotency_key;
  if (!row.idempotency_key.empty()) row.fingerprint = fingerprint_of(row.mesh_a, row.mesh_b, submission.options);
  row.trace = submission.trace;
  row.created = now;
  row.expires_if_never_run = now + ttl;
  if (!submission.durable) {
    row.deadline = now + submission.request.timeout;
    row.expires_if_never_run = *row.deadline + kNeverRun;
  }
  return row;
}

Denial removed_just_now() {
  return {{ProblemKind::storage_unavailable,
           "the comparison of this Idempotency-Key was just removed; send the request again",
           {}},
          {}};
}

}  // namespace

std::shared_ptr<LiveJob> Jobs::job_of(Submission submission) const {
  auto row = row_of(submission, stores_.jobs.time(), seconds(settings_.result_ttl_s));
  auto job = std::make_shared<LiveJob>(std::move(row), limited(submission.request, settings_), std::move(submission.a),
                                       std::move(submission.b), submission.durable);
  if (submission.counted) job->counted.emplace(std::move(*submission.counted));
  return job;
}

Jobs::Submitted Jobs::submit(Scheduler::Slot slot, Submission submission) {
  if (submission.durable || stores_.shared) return submit_stored(std::move(slot), std::move(submission));
  const auto job = job_of(std::move(submission));
  run_unstored(job, std::move(slot));
  return job;
}

// Reserves the blobs until the row refers to them. Removes them again if the row is not stored.
Jobs::Submitted Jobs::submit_stored(Scheduler::Slot slot, Submission submission) {
  name_meshes(submission);
  const std::string id = submission.key.id;
  const store::BlobKey a{submission.key.owner, submission.a.id};
  const store::BlobKey b{submission.key.owner, submission.b.id};
  auto submitted = [&]() -> Submitted {
    // An early check, so that no bytes are stored in vain. insert() checks again.
    if (stores_.shared) {
      if (auto denial = access_.find_denial(a.owner, unended_of(a.owner))) {
        return denied(row_of(submission, stores_.jobs.time(), seconds(0)), std::move(*denial));
      }
    }
    const auto reserved_a = stores_.blobs.reserve(a);
    const auto reserved_b = stores_.blobs.reserve(b);
    if (auto denial = keep_blobs(submission)) return std::move(*denial);
    return insert(job_of(std::move(submission)), std::move(slot));
  }();
  const auto* job = std::get_if<std::shared_ptr<LiveJob>>(&submitted);
  if (!job || (*job)->key.id != id) release_blobs(stores_, store_errors_, a.owner, a.id, b.id);
  return submitted;
}

// Stores the blobs durably, so that they exist when the job runs, even after a crash.
std::optional<Denial> Jobs::keep_blobs(const Submission& submission) {
  const std::string& owner = submission.key.owner;
  std::uint64_t more = 0;
  for (const MeshSource* source : {&submission.a, &submission.b}) {
    if (source == &submission.b && source->id == submission.a.id) continue;
    const auto there = stores_.blobs.exists({owner, source->id});
    if (!there) return Denial{api::to_problem(there.error()), {}};
    if (!*there) more += source->input.bytes.size();
  }
  const auto hold = hold_storage(access_, stores_, owner, more, settings_.max_stored_bytes);
  if (const auto* denial = std::get_if<Denial>(&hold)) return *denial;
  for (const MeshSource* source : {&submission.a, &submission.b}) {
    if (auto denial = keep_blob(owner, *source)) return denial;
  }
  return std::nullopt;
}

// Stores an upload; a mesh that was stored before must still exist.
std::optional<Denial> Jobs::keep_blob(const std::string& owner, const MeshSource& source) {
  if (!source.kept) {
    const auto put = stores_.blobs.put({owner, source.id}, source.input.bytes);
    store_errors_.note(put);
    return put ? std::nullopt : std::optional(Denial{api::to_problem(put.error()), {}});
  }
  const auto renewed = stores_.blobs.renew({owner, source.id});
  store_errors_.note(renewed);
  if (!renewed) return Denial{api::to_problem(renewed.error()), {}};
  if (*renewed) return std::nullopt;
  return Denial{{ProblemKind::unknown_mesh,
                 "the mesh '" + source.input.part + "' was deleted while the request was handled; store it again",
                 {}},
                {}};
}

// Counts the owner's jobs in the store: other front ends accept jobs of this owner, too.
Access::CountJobs Jobs::unended_of(const std::string& owner) {
  return [this, owner] {
    auto unended = stores_.jobs.unended(owner, stores_.jobs.time());
    store_errors_.note(unended);
    return unended;
  };
}

// A request over the limit may repeat one that was stored meanwhile: then its job is the answer.
Jobs::Submitted Jobs::denied(const store::NewJob& row, Denial denial) {
  if (row.idempotency_key.empty()) return denial;
  const auto first = stores_.jobs.find_idempotent(row.key.owner, row.idempotency_key);
  if (!first || !*first) return denial;
  return found(**first, row.fingerprint != (*first)->fingerprint);
}

// Registers the job with the watcher before it is stored, so that a repetition of the request finds it.
Jobs::Submitted Jobs::insert(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  const std::string& owner = job->key.owner;
  const auto turn = stores_.shared ? access_.await_turn(owner, unended_of(owner)) : JobTurn{};
  if (const auto* denial = std::get_if<Denial>(&turn)) return denied(job->view().row, *denial);
  watcher_.expect(job);
  const auto inserted = stores_.jobs.insert(job->view().row);
  // A row with this id is this job: a call whose answer was lost has stored it.
  if (inserted && (!inserted->existed || inserted->job.key == job->key)) {
    release_bytes(job->a);
    release_bytes(job->b);
    if (queue_ && job->durable) queue_->added();
    if (worker_ || slot.kind() == Kind::awaited) job->hold_place(std::move(slot));
    watcher_.begin(job);
    return job;
  }
  watcher_.forget(*job);
  store_errors_.note(inserted);
  if (!inserted) return Denial{api::to_problem(inserted.error()), {}};
  return found(inserted->job, inserted->conflict);
}

Jobs::Submitted Jobs::found(const store::Job& row, bool conflict) {
  if (conflict) {
    return Denial{{ProblemKind::idempotency_key_reused,
                   "this Idempotency-Key was used for another comparison; take a new one",
                   {}},
                  {}};
  }
  if (!store::has_ended(row.state)) {
    if (auto first = watcher_.watch(row)) return first;
  }
  auto view = get(row.key);  // it has ended since, or waits for the next start
  if (!view) return Denial{api::to_problem(view.error()), {}};
  if (*view) return std::move(**view);
  return removed_just_now();
}

Result<bool> Jobs::repeats(const Submission& submission) {
  if (submission.idempotency_key.empty()) return false;
  const auto row = stores_.jobs.find_idempotent(submission.key.owner, submission.idempotency_key);
  if (!row) return row.error();
  return row->has_value();
}

Jobs::Submitted Jobs::repeated(Submission& submission) {
  name_meshes(submission);
  const auto row = stores_.jobs.find_idempotent(submission.key.owner, submission.idempotency_key);
  if (!row) return Denial{api::to_problem(row.error()), {}};
  if (!*row) return removed_just_now();
  const std::string print = fingerprint_of(submission.a.id, submission.b.id, submission.options);
  return found(**row, print != (*row)->fingerprint);
}

}  // namespace meshgauge::server
