#include "server/measure/live_job.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "api/base/digest.h"
#include "engine/hausdorff.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kReportInterval{100};  // between two reports of a job's progress, at least

}  // namespace

store::Progress certified(double lower, double upper, std::string stage) {
  return {lower, upper, std::move(stage), meshgauge::version()};
}

std::string work_of(const store::NewJob& job) {
  constexpr const char* kForm = "1";  // of a result: another one after each change of what a result has
  const std::string all =
      job.mesh_a + "\n" + job.mesh_b + "\n" + job.hints + "\n" + job.options + "\n" + version() + "\n" + kForm;
  return api::sha256_hex(std::as_bytes(std::span(all)));
}

LiveJob::LiveJob(store::NewJob job, std::optional<api::Request> parsed, MeshSource mesh_a, MeshSource mesh_b,
                 bool is_durable, Clock::time_point submission)
    : key(job.key),
      client(client_of(job)),
      bytes(job.cost),
      durable(is_durable),
      submitted(submission),
      request(parsed.value_or(api::Request{})),
      a(std::move(mesh_a)),
      b(std::move(mesh_b)) {
  static_cast<store::NewJob&>(view_.row) = std::move(job);
  if (parsed) view_.request = std::make_shared<const api::Request>(*std::move(parsed));
}

JobView LiveJob::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

store::JobState LiveJob::state() const {
  const std::lock_guard lock(mutex_);
  return view_.row.state;
}

std::uint64_t LiveJob::version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

bool LiveJob::wait_for_end(std::chrono::milliseconds time) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, time, [&] { return over(); });
}

bool LiveJob::is_over() const {
  const std::lock_guard lock(mutex_);
  return over();
}

std::shared_ptr<const void> LiveJob::on_change(std::function<void()> wake) { return listen({std::move(wake), false}); }

std::shared_ptr<const void> LiveJob::on_end(std::function<void()> wake) { return listen({std::move(wake), true}); }

std::shared_ptr<const void> LiveJob::listen(Listener listener) {
  auto shared = std::make_shared<const Listener>(std::move(listener));
  const std::lock_guard lock(mutex_);
  std::erase_if(listeners_, [](const auto& other) { return other.expired(); });
  listeners_.push_back(shared);
  return shared;
}

// In this order: a job that its control ends counts as cancelled only if its cancel was requested before, and a client
// that is woken reads the control.
void LiveJob::cancel() {
  {
    const std::lock_guard lock(mutex_);
    view_.row.cancel_requested = true;
    ++version_;
  }
  control.cancel();
  notify();
}

bool LiveJob::cancel_requested() const {
  const std::lock_guard lock(mutex_);
  return view_.row.cancel_requested;
}

std::optional<store::Progress> LiveJob::progress() const {
  const std::lock_guard lock(mutex_);
  return view_.row.progress;
}

void LiveJob::set_up_control(Clock::time_point latest) {
  control.set_deadline(latest);
  control.watch([this](const Progress& p) { progressed(certified(p.lower, p.upper, p.stage)); }, kReportInterval);
}

void LiveJob::started(unsigned tries, store::TimePoint when) {
  change([&](JobView& view) {
    view.row.state = store::JobState::running;
    view.row.tries = tries;
    view.row.started = when;
  });
}

void LiveJob::progressed(const store::Progress& progress) {
  change([&](JobView& view) { view.row.progress = store::narrowed(view.row.progress, progress); });
}

void LiveJob::ended(JobView last) {
  change([&](JobView& view) {
    if (over()) return;
    last.request = std::move(view.request);
    view = std::move(last);
  });
}

// A crash of the store may undo progress; clients keep the narrower interval.
void LiveJob::seen(const store::Job& row) {
  {
    const std::lock_guard lock(mutex_);
    store::Job& known = view_.row;
    const auto progress = row.progress ? std::optional(store::narrowed(known.progress, *row.progress)) : known.progress;
    const bool same = known.state == row.state && known.tries == row.tries && known.progress == progress &&
                      known.cancel_requested == row.cancel_requested;
    if (over() || same) return;
    known = row;
    known.progress = progress;
    ++version_;
  }
  notify();
}

void LiveJob::release() {
  change([this](JobView& view) {
    if (!over()) view.handed_back = true;
  });
}

// Other requests may know the job already, by its Idempotency-Key, and leave it at this moment.
void LiveJob::hold_place(Scheduler::Slot slot) {
  const std::lock_guard lock(mutex_);
  place_.emplace(std::move(slot));
}

// Gives them back without the lock: their owners have locks of their own.
void LiveJob::give_places_back() {
  std::optional<JobSlot> job;
  std::optional<Scheduler::Slot> place;
  const std::lock_guard lock(mutex_);
  if (counted) job.emplace(std::move(*counted));
  if (place_) place.emplace(std::move(*place_));
  counted.reset();
  place_.reset();
}

void LiveJob::notify() {
  changed_.notify_all();
  std::vector<std::weak_ptr<const Listener>> listeners;
  bool ends = false;
  {
    const std::lock_guard lock(mutex_);
    listeners = listeners_;
    ends = over() || view_.row.cancel_requested;
  }
  for (const auto& one : listeners) {
    const auto listener = one.lock();
    if (listener && (ends || !listener->ends_only)) listener->wake();
  }
}

template <class Change>
void LiveJob::change(const Change& how) {
  {
    const std::lock_guard lock(mutex_);
    how(view_);
    ++version_;
  }
  notify();
}

api::Request limited(api::Request request, const Settings& settings) {
  request.options.simd = settings.simd;
  std::size_t& memory_bytes = request.options.max_memory_bytes;
  memory_bytes = std::min<std::size_t>(memory_bytes, settings.max_heap_bytes);
  return request;
}

std::shared_ptr<LiveJob> live_job_of(const store::Job& row, const Settings& settings,
                                     std::chrono::milliseconds waited) {
  MeshSource a{{"a", {}, "", "", -1}, nullptr, row.mesh_a, {}};
  MeshSource b{{"b", {}, "", "", -1}, nullptr, row.mesh_b, {}};
  set_hints(row.hints, a, b);
  const auto request = api::parse_options(row.options, request_limits(settings));
  auto job = std::make_shared<LiveJob>(row, request ? std::optional(limited(*request, settings)) : std::nullopt,
                                       std::move(a), std::move(b), true, LiveJob::Clock::now() - waited);
  if (!request) job->defect = request.error();
  if (row.progress && row.progress->by == version()) job->progressed(*row.progress);
  return job;
}

Result<Done> recognise_meshes(LiveJob& job, store::MeshIndex& meshes) {
  const auto known = meshes.known_meshes(job.key.owner, std::array{job.a.id, job.b.id});
  if (!known) return known.error();
  for (MeshSource* source : {&job.a, &job.b}) {
    const bool stored = std::any_of(known->begin(), known->end(),
                                    [source](const store::MeshRow& row) { return row.key.id == source->id; });
    if (!stored) continue;
    source->kept = MeshCache::key(job.key.owner, source->id, source->input.filename, source->input.media_type);
  }
  return Done{};
}

Result<Done> open_blobs(LiveJob& job, store::BlobStore& blobs) {
  for (MeshSource* source : {&job.a, &job.b}) {
    auto blob = blobs.open({job.key.owner, source->id});
    if (!blob) return blob.error();
    if (*blob) hold_bytes(*source, std::move(**blob));
  }
  return Done{};
}

}  // namespace meshgauge::server
