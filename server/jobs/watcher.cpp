#include "server/jobs/watcher.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/result/response.h"
#include "server/base/heap.h"

namespace meshgauge::server {
namespace {

using std::chrono::seconds;
using store::JobState;

constexpr seconds kReadInterval{1};
constexpr unsigned kRoundsUnwatched = 10;  // every tenth round also reads jobs without a waiting client
constexpr std::size_t kMostAtOnce = 500;   // rows of one read

std::optional<std::size_t> triangles_of(const nlohmann::json& document, const char* part) {
  const nlohmann::json::json_pointer pointer(std::string("/meshes/") + part + "/triangles");
  if (!document.contains(pointer) || !document[pointer].is_number_unsigned()) return std::nullopt;
  return document[pointer].get<std::size_t>();
}

// Returns the view of a job whose end was read from the store: its stages and sizes are those of its document.
JobView as_told(const store::Job& row) {
  JobView view;
  view.row = row;
  const auto document = nlohmann::json::parse(row.document, nullptr, false);
  if (!document.is_object()) return view;
  const auto times = document.value("timings_ms", nlohmann::json::object());
  for (const char* name : api::kStageNames) {
    if (times.contains(name) && times[name].is_number()) view.stages.push_back({name, times[name].get<double>()});
  }
  view.timing = api::to_server_timing(view.stages);
  const auto a = triangles_of(document, "a"), b = triangles_of(document, "b");
  if (a && b) view.triangles = MeshSizes{*a, *b};
  return view;
}

}  // namespace

Watcher::Watcher(store::JobStore& jobs, StoreErrors& store_errors, Metrics& metrics, seconds keep, Listener& listener)
    : jobs_(jobs), store_errors_(store_errors), metrics_(metrics), keep_(keep), listener_(listener), threads_([this] {
        tell_end();
      }) {
  threads_.start([this] { watch_on(); });
}

void Watcher::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
}

void Watcher::expect(const std::shared_ptr<LiveJob>& job) {
  const std::lock_guard lock(mutex_);
  watched_[job->key.id] = {job, job->durable ? job : nullptr, false};
}

void Watcher::begin(const std::shared_ptr<LiveJob>& job) {
  {
    const std::lock_guard lock(mutex_);
    if (!stopped_) {
      watched_[job->key.id].stored = true;
      changed_.insert(job->key.id);  // an earlier signal did not find the job
      wake_.notify_all();
      return;
    }
  }
  release(job);
}

void Watcher::forget(const LiveJob& job) {
  const std::lock_guard lock(mutex_);
  watched_.erase(job.key.id);
}

std::shared_ptr<LiveJob> Watcher::unstored(const store::JobKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = watched_.find(key.id);
  if (found == watched_.end() || found->second.stored) return nullptr;
  auto job = found->second.job.lock();
  return job && job->key == key && !job->durable ? job : nullptr;
}

std::shared_ptr<LiveJob> Watcher::watch(const store::Job& row) {
  const std::lock_guard lock(mutex_);
  return stopped_ ? nullptr : watch_under_lock(row);
}

void Watcher::adopt(const store::Job& row, Scheduler::Slot slot, JobSlot counted) {
  const std::lock_guard lock(mutex_);
  const auto job = watch_under_lock(row);
  job->hold_place(std::move(slot));
  job->counted.emplace(std::move(counted));
  watched_[row.key.id].held = job;
}

std::shared_ptr<LiveJob> Watcher::watch_under_lock(const store::Job& row) {
  Watched& watched = watched_[row.key.id];
  if (auto job = watched.job.lock(); job && job->key == row.key) return job;
  auto job = std::make_shared<LiveJob>(row, std::nullopt, MeshSource{}, MeshSource{}, !row.deadline);
  job->seen(row);
  watched = {job, nullptr, true};
  changed_.insert(row.key.id);  // the row may have changed since it was read
  wake_.notify_all();
  return job;
}

void Watcher::leave(const std::shared_ptr<LiveJob>& job) {
  job->give_places_back();
  const std::lock_guard lock(mutex_);
  if (std::find(left_.begin(), left_.end(), job) != left_.end()) return;
  left_.push_back(job);
  leaving_ = true;
  wake_.notify_all();
}

void Watcher::drain() {
  const std::lock_guard lock(mutex_);
  draining_ = true;
  missed_ = true;
  wake_.notify_all();
}

// Reads the rows once more, so that jobs which have just ended are reported as ended.
void Watcher::stop() {
  Jobs changed, left;
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(stopped_, true)) return;
    changed = those_changed();
  }
  poll(changed);
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, watched] : watched_) {
      auto job = watched.job.lock();
      if (job && watched.stored) left.push_back(std::move(job));  // else begin() or forget() follows
    }
    std::erase_if(watched_, [](const auto& watched) { return watched.second.stored; });
  }
  for (const auto& job : left) release(job);
}

std::size_t Watcher::queued() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(watched_.begin(), watched_.end(), [](const auto& watched) {
    return watched.second.held && watched.second.held->state() == JobState::queued;
  }));
}

void Watcher::release(const std::shared_ptr<LiveJob>& job) {
  job->durable ? job->give_places_back() : leave(job);
  job->release();
}

void Watcher::hear(const store::Signal& signal) {
  const std::lock_guard lock(mutex_);
  if (signal.kind == store::Signal::Kind::missed) {
    missed_ = true;
  } else if (signal.kind != store::Signal::Kind::changed || !watched_.contains(signal.job.id)) {
    return;
  } else {
    changed_.insert(signal.job.id);
  }
  wake_.notify_all();
}

void Watcher::watch_on() {
  const NeverFails never_fails;
  auto next = LiveJob::Clock::now() + kReadInterval;
  std::unique_lock lock(mutex_);
  while (!ending_) {
    wake_.wait_until(lock, next, [&] { return ending_ || missed_ || leaving_ || !changed_.empty(); });
    const bool all = std::exchange(missed_, false) || LiveJob::Clock::now() >= next;
    const bool leaving = std::exchange(leaving_, false) || all;
    const Jobs jobs = all ? all_watched() : those_changed();
    lock.unlock();
    poll(jobs);
    if (leaving) cancel_left();
    if (all) next = LiveJob::Clock::now() + kReadInterval;
    lock.lock();
  }
  lock.unlock();
  cancel_left();
}

// Precondition of both functions: mutex_ is held.
Watcher::Jobs Watcher::those_changed() {
  Jobs jobs;
  for (const std::string& id : std::exchange(changed_, {})) {
    const auto found = watched_.find(id);
    if (found == watched_.end() || !found->second.stored) continue;
    if (auto job = found->second.job.lock()) jobs.push_back(std::move(job));
  }
  return jobs;
}

Watcher::Jobs Watcher::all_watched() {
  Jobs jobs;
  const std::set<std::string> changed = std::exchange(changed_, {});
  const bool unwatched = ++round_ % kRoundsUnwatched == 0;
  for (auto at = watched_.begin(); at != watched_.end();) {
    auto job = at->second.job.lock();
    if (!job) {
      at = watched_.erase(at);
      continue;
    }
    const auto& [id, watched] = *at++;
    const bool waited_for = !watched.held || job.use_count() > 2;  // besides this one and `held`
    if (watched.stored && (waited_for || unwatched || changed.contains(id))) jobs.push_back(std::move(job));
  }
  return jobs;
}

void Watcher::poll(const Jobs& jobs) {
  for (std::size_t first = 0; first < jobs.size(); first += kMostAtOnce) {
    poll_some(std::span(jobs).subspan(first, std::min(kMostAtOnce, jobs.size() - first)));
  }
}

void Watcher::poll_some(std::span<const std::shared_ptr<LiveJob>> jobs) {
  std::vector<store::JobKey> keys;
  for (const auto& job : jobs) keys.push_back(job->key);
  const auto rows = store_errors_.noted(jobs_.get_many(keys));
  if (!rows) return;  // they are read again in a second
  std::map<std::string, const store::Job*> by_id;
  for (const store::Job& row : *rows) by_id[row.key.id] = &row;
  for (const auto& job : jobs) {
    const auto found = by_id.find(job->key.id);
    tell(job, found == by_id.end() ? nullptr : found->second);
  }
}

// A job without a row was cancelled and removed by its owner.
void Watcher::tell(const std::shared_ptr<LiveJob>& job, const store::Job* row) {
  const bool ended = !row || store::has_ended(row->state);
  if (!ended) job->seen(*row);
  {
    const std::lock_guard lock(mutex_);
    const bool over = ended || (draining_ && job->durable && row->state == JobState::queued);
    if (!over || watched_.erase(job->key.id) == 0) return;
  }
  if (!ended) return release(job);
  JobView last = row ? as_told(*row) : job->view();
  if (!row) last.row.state = JobState::cancelled;
  listener_.ended(*job, last.row);
  job->give_places_back();  // before clients see the end: they may send the next request at once
  job->ended(std::move(last));
}

void Watcher::cancel_left() {
  Jobs left;
  {
    const std::lock_guard lock(mutex_);
    left.swap(left_);
  }
  while (!left.empty() && cancelled(*left.back())) left.pop_back();
  const auto now = LiveJob::Clock::now();
  std::erase_if(left, [&](const auto& job) { return now > job->deadline(); });
  const std::lock_guard lock(mutex_);
  left_.insert(left_.end(), left.begin(), left.end());
}

// false: the store did not take the request.
bool Watcher::cancelled(LiveJob& job) {
  const auto state = store_errors_.noted(jobs_.request_cancel(job.key, jobs_.moment(keep_)));
  if (!state) return false;
  if (*state == JobState::cancelled) metrics_.job_cancelled_early(job.request.options.strategy);
  return true;
}

}  // namespace meshgauge::server
