#include "server/jobs/jobs.h"

#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/digest.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::JobState;

constexpr milliseconds kProgressInterval{100};
constexpr seconds kCancelTime{1};
constexpr milliseconds kUntold{50};  // after the deadline of a queued job: its end may be known a little later
constexpr seconds kLate{5};          // after the deadline of a running job, or while the store is away

// One process uses these stores: it gets every signal, and no other process can take a suspected job.
WorkerOptions embedded_worker() {
  WorkerOptions options;
  options.name = api::random_id();
  options.lease = std::chrono::hours(365L * 24);
  options.progress = kProgressInterval;
  options.poll = seconds(10);
  options.trusted_tries = 2;  // the end of the process loses all running jobs, so one loss means little
  options.pass_over = milliseconds(0);
  return options;
}

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
           "the comparison of this Idempotency-Key was just removed; send the request again"}};
}

}  // namespace

Jobs::Jobs(const Settings& settings, MeshLoader& loader, const Stores& stores, Access& access, Metrics& metrics)
    : settings_(settings),
      stores_(stores),
      access_(access),
      metrics_(metrics),
      store_errors_(metrics, stores.place),
      threads_(settings.workers),
      memory_(memory_for_meshes(settings)),
      measuring_(settings, loader, metrics, threads_, memory_, stores.jobs),
      scheduler_({settings.workers, settings.workers + settings.queue, settings.max_queued_jobs}),
      upkeep_(settings, stores, store_errors_),
      watcher_(stores.jobs, store_errors_, metrics, seconds(settings.result_ttl_s), *this) {
  if (stores.shared) {
    queue_.emplace(stores.jobs, store_errors_);
  } else {
    worker_.emplace(settings, stores, measuring_, scheduler_, store_errors_, metrics, embedded_worker());
  }
  upkeep_thread_.emplace([this] { upkeep_.tick(); });
  stores.signals.listen([this](const store::Signal& signal) {  // last: where the start ends above, nothing listens
    watcher_.hear(signal);
    if (worker_) worker_->hear(signal);
  });
}

Jobs::~Jobs() {
  stop();
  upkeep_thread_.reset();
  stores_.signals.stop_listening();
  scheduler_.end();
  store_errors_.note(stores_.jobs.flush());
}

// Requeues all jobs that were running when the last process ended, whatever their worker.
Result<Done> Jobs::recover() {
  if (!worker_) return Done{};
  const auto rows =
      stores_.jobs.recover("", "the service ended while it ran", stores_.jobs.moment(seconds(settings_.result_ttl_s)));
  if (!rows) return rows.error();
  for (const store::Job& row : *rows) {
    watcher_.adopt(row, scheduler_.admit_again(client_of(row)), access_.adopt_job(row.key.owner));
  }
  worker_->start();
  return Done{};
}

void Jobs::drain() {
  draining_.store(true);
  if (!worker_) return;
  worker_->drain();
  watcher_.drain();
}

void Jobs::stop() {
  drain();
  stopping_.store(true);
  scheduler_.cancel_all();
  if (worker_) worker_->stop();
  watcher_.stop();
}

// In the distributed form a durable job holds its slot until it is stored; from then on the store counts it.
std::optional<Scheduler::Slot> Jobs::admit(Kind kind, const std::string& client) {
  return is_full(kind) ? std::nullopt : scheduler_.admit(kind, client);
}

bool Jobs::has_place(Kind kind, const std::string& client) const {
  return !is_full(kind) && scheduler_.has_place(kind, client);
}

bool Jobs::has_place_for_new_client(Kind kind) const {
  return !is_full(kind) && scheduler_.has_place_for_new_client(kind);
}

bool Jobs::is_full(Kind kind) const {
  return queue_ && kind == Kind::durable && figures().durable_slots >= settings_.max_queued_jobs;
}

Scheduler::Figures Jobs::figures() const {
  Scheduler::Figures figures = scheduler_.figures();
  if (queue_) figures.durable_slots += queue_->unawaited();
  return figures;
}

std::size_t Jobs::waiting() const { return scheduler_.figures().waiting + (worker_ ? watcher_.queued() : 0); }

// An awaited job waits for those that a thread of this process runs; a durable one for those in the store, too.
milliseconds Jobs::expected_wait(Kind kind) const {
  if (queue_) return queue_->expected_wait();
  return scheduler_.expected_wait(kind == Kind::durable ? watcher_.queued() : 0);
}

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
    if (!there) return Denial{api::to_problem(there.error())};
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
    const auto put = store_errors_.noted(stores_.blobs.put({owner, source.id}, source.input.bytes));
    return put ? std::nullopt : std::optional(Denial{api::to_problem(put.error())});
  }
  const auto renewed = store_errors_.noted(stores_.blobs.renew({owner, source.id}));
  if (!renewed) return Denial{api::to_problem(renewed.error())};
  if (*renewed) return std::nullopt;
  return Denial{{ProblemKind::unknown_mesh,
                 "the mesh '" + source.input.part + "' was deleted while the request was handled; store it again"}};
}

// Counts the owner's jobs in the store: other front ends accept jobs of this owner, too.
Access::CountJobs Jobs::unended_of(const std::string& owner) {
  return [this, owner] { return store_errors_.noted(stores_.jobs.unended(owner, stores_.jobs.time())); };
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
  if (!inserted) return Denial{api::to_problem(inserted.error())};
  return found(inserted->job, inserted->conflict);
}

Jobs::Submitted Jobs::found(const store::Job& row, bool conflict) {
  if (conflict) {
    return Denial{
        {ProblemKind::idempotency_key_reused, "this Idempotency-Key was used for another comparison; take a new one"}};
  }
  if (!store::has_ended(row.state)) {
    if (auto first = watcher_.watch(row)) return first;
  }
  auto view = get(row.key);  // it has ended since, or waits for the next start
  if (!view) return Denial{api::to_problem(view.error())};
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
  if (!row) return Denial{api::to_problem(row.error())};
  if (!*row) return removed_just_now();
  const std::string print = fingerprint_of(submission.a.id, submission.b.id, submission.options);
  return found(**row, print != (*row)->fingerprint);
}

void Jobs::run_unstored(const std::shared_ptr<LiveJob>& job, Scheduler::Slot slot) {
  watcher_.expect(job);
  job->set_up_control(job->deadline());
  scheduler_.submit(std::move(slot),
                    {job->client, job->bytes, job->request.timeout, std::shared_ptr<Control>(job, &job->control),
                     [this, job](Scheduler::Slot held) { measure_unstored(*job, std::move(held)); }});
}

void Jobs::measure_unstored(LiveJob& job, Scheduler::Slot slot) {
  job.started(1, stores_.jobs.time());
  const auto result = measuring_.measured(job);
  end_unstored(job, result, std::move(slot));
}

// Gives the places back before the answer: the client may send the next request at once.
void Jobs::end_unstored(LiveJob& job, const Result<api::Comparison>& result, std::optional<Scheduler::Slot> slot) {
  measuring_.count(job, result);
  JobView last = measuring_.last_view(job, result, stopping_.load());
  release_bytes(job.a);
  release_bytes(job.b);
  job.give_places_back();
  slot.reset();
  stores_.jobs.record(last.row);
  watcher_.forget(job);
  job.ended(std::move(last));
}

Result<std::optional<JobView>> Jobs::get(const store::JobKey& key) {
  if (const auto job = watcher_.unstored(key)) return std::optional(job->view());
  auto row = stores_.jobs.get(key);
  if (!row) return row.error();
  if (!*row) return std::optional<JobView>();
  JobView view;
  view.row = std::move(**row);
  return std::optional(std::move(view));
}

std::shared_ptr<LiveJob> Jobs::watch(const JobView& job) {
  return store::has_ended(job.row.state) ? nullptr : watcher_.watch(job.row);
}

Result<Jobs::Deleted> Jobs::remove(const store::JobKey& key) {
  const auto job = get(key);
  if (!job) return job.error();
  if (!*job) return Deleted::unknown;
  if (store::has_ended((*job)->row.state)) return forget(key);
  const auto cancelled = cancel((*job)->row);
  if (!cancelled) return cancelled.error();
  return *cancelled ? Deleted::asked_to_end : Deleted::unknown;
}

Result<Done> Jobs::cancel(const store::JobKey& key) {
  const auto job = get(key);
  if (!job) return job.error();
  if (!*job || store::has_ended((*job)->row.state)) return Done{};
  const auto cancelled = cancel((*job)->row);
  if (!cancelled) return cancelled.error();
  return Done{};
}

// false: the job no longer exists.
Result<bool> Jobs::cancel(const store::Job& row) {
  const auto job = watcher_.watch(row);
  if (const auto unstored = watcher_.unstored(row.key)) {
    unstored->cancel();
  } else {
    const auto state = stores_.jobs.request_cancel(row.key, stores_.jobs.moment(seconds(settings_.result_ttl_s)));
    if (!state) return state.error();
    if (!*state) return false;
    if (**state == JobState::cancelled) {
      const auto request = api::parse_options(row.options, request_limits(settings_));
      metrics_.job_cancelled_early(request ? request->options.strategy : Strategy{});
    }
  }
  if (job) job->wait_for_end(kCancelTime);
  return true;
}

Result<Jobs::Deleted> Jobs::forget(const store::JobKey& key) {
  const auto forgotten = stores_.jobs.forget(key);
  if (!forgotten) return forgotten.error();
  if (stores_.maps) stores_.maps->forget(key);
  return Deleted::forgotten;
}

bool Jobs::abandon(const std::shared_ptr<LiveJob>& job) {
  if (queue_) {
    watcher_.leave(job);
  } else {
    job->control.cancel();
  }
  return queue_.has_value();
}

void Jobs::end_if_over(LiveJob& job) {
  if (queue_ || job.durable) return;
  // Not control.check(): of a job that runs, that is for its own threads.
  const bool over = job.control.cancelled() || LiveJob::Clock::now() >= job.deadline();
  if (!over || !scheduler_.withdraw(job.control)) return;
  end_unstored(job, api::in_time(job.control, "a thread was free for it").error(), std::nullopt);
}

// An awaited job ends by its deadline, which its worker keeps; a durable one goes on in any case.
std::optional<Problem> Jobs::give_up(const LiveJob& job) const {
  if (!queue_) return std::nullopt;
  const bool there = queue_->available().ok();
  if (job.durable) {
    if (there || queue_->silence() < job.request.timeout) return std::nullopt;
    return Problem{ProblemKind::storage_unavailable,
                   "the store does not answer; the comparison runs when it does again"};
  }
  const bool begun = job.state() != JobState::queued;
  const milliseconds late = begun || !there ? kLate : kUntold;
  if (LiveJob::Clock::now() < job.deadline() + late) return std::nullopt;
  if (!there)
    return Problem{ProblemKind::storage_unavailable,
                   "the store does not answer, and the timeout of the request has passed; send it again later"};
  return Problem{ProblemKind::out_of_time, "no worker ended the comparison within the timeout of the request"};
}

void Jobs::ended(const LiveJob& job, const store::Job& row) {
  if (!stores_.shared) return release_blobs(stores_, store_errors_, row.key.owner, row.mesh_a, row.mesh_b);
  for (const MeshSource* source : {&job.a, &job.b}) {
    if (!source->id.empty() && !source->kept) upkeep_.remove_unless_used({job.key.owner, source->id});
  }
}

}  // namespace meshgauge::server
