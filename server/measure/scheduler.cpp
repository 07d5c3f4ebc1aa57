#include "server/measure/scheduler.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "server/base/heap.h"
#include "server/settings/settings.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr double kShareOfTheLast = 0.1;
constexpr int kNiceness = 10;

// Lets threads that answer clients go first: else, under overload, refusals would wait for comparisons. The threads
// that a comparison starts inherit it.
void lower_priority() { ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNiceness); }

milliseconds handicap(const Scheduler::Task& task) {
  const milliseconds most = std::min(Scheduler::kMostHandicap, task.timeout / 4);
  const std::uint64_t ms = std::min(task.bytes / Scheduler::kBytesPerMs, static_cast<std::uint64_t>(most.count()));
  return milliseconds(static_cast<std::int64_t>(ms));
}

}  // namespace

Scheduler::Slot::~Slot() {
  if (scheduler_) scheduler_->release(kind_, client_);
}

Scheduler::Scheduler(const Limits& limits) : limits_(limits), workers_([this] { tell_end(); }) {
  awaited_.limit = limits.awaited;
  durable_.limit = limits.durable;
  for (std::size_t i = 0; i < limits.workers + kGuests; ++i) workers_.start([this] { work(); });
}

void Scheduler::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ready_.notify_all();
}

NextPlace Scheduler::Slots::next(const std::string& client) const {
  const auto found = of.find(client);
  return next_place(found == of.end() ? TakenPlaces{} : found->second, taken, limit);
}

void Scheduler::Slots::take(const std::string& client, NextPlace place) {
  TakenPlaces& own = of[client];
  const bool within = place == NextPlace::within_share;
  ++(within ? own.within : own.beyond);
  ++(within ? taken.within : taken.beyond);
}

void Scheduler::Slots::give(const std::string& client) {
  const auto found = of.find(client);
  TakenPlaces& own = found->second;
  const bool within = own.within > 0;
  --(within ? own.within : own.beyond);
  --(within ? taken.within : taken.beyond);
  if (own.all() == 0) {
    of.erase(found);
    return;
  }
  for (; own.beyond > 0 && next(client) == NextPlace::within_share; --own.beyond, --taken.beyond) {
    ++own.within;
    ++taken.within;
  }
}

std::optional<Scheduler::Slot> Scheduler::admit(Kind kind, const std::string& client) {
  const std::lock_guard lock(mutex_);
  Slots& places = slots(kind);
  const NextPlace place = places.next(client);
  if (place == NextPlace::none) return std::nullopt;
  places.take(client, place);
  return Slot(this, kind, client);
}

bool Scheduler::has_place(Kind kind, const std::string& client) const {
  const std::lock_guard lock(mutex_);
  return (kind == Kind::awaited ? awaited_ : durable_).next(client) != NextPlace::none;
}

bool Scheduler::has_place_for_new_client(Kind kind) const {
  const std::lock_guard lock(mutex_);
  const Slots& places = kind == Kind::awaited ? awaited_ : durable_;
  return next_place({}, places.taken, places.limit) != NextPlace::none;
}

Scheduler::Slot Scheduler::admit_again(const std::string& client) {
  const std::lock_guard lock(mutex_);
  durable_.take(client, durable_.next(client));  // where there is no place, one beyond its share
  return {this, Kind::durable, client};
}

void Scheduler::release(Kind kind, const std::string& client) {
  const std::lock_guard lock(mutex_);
  slots(kind).give(client);
}

void Scheduler::submit(Slot slot, Task task) {
  {
    const std::lock_guard lock(mutex_);
    if (cancelled_) task.control->cancel();
    const auto turn = Clock::now() + handicap(task);
    waiting_.push_back({std::move(slot), std::move(task), turn});
  }
  ready_.notify_one();
}

bool Scheduler::withdraw(const Control& control) {
  std::list<Entry> withdrawn;  // destroyed after the lock is released: its slot takes the lock
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(waiting_.begin(), waiting_.end(),
                                  [&](const Entry& entry) { return entry.task.control.get() == &control; });
  if (found == waiting_.end()) return false;
  withdrawn.splice(withdrawn.end(), waiting_, found);
  return true;
}

void Scheduler::cancel_all() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  for (const Entry& entry : waiting_) entry.task.control->cancel();
  for (const Running& job : running_) job.control->cancel();
}

Scheduler::Figures Scheduler::figures() const {
  const std::lock_guard lock(mutex_);
  return {waiting_.size(), running_.size(), awaited_.taken.all(), durable_.taken.all()};
}

std::chrono::milliseconds Scheduler::expected_wait(std::size_t elsewhere) const {
  const std::lock_guard lock(mutex_);
  const double before = static_cast<double>(waiting_.size() + elsewhere) + 1;
  return milliseconds(static_cast<std::int64_t>(time_of_job_ms() * before / static_cast<double>(limits_.workers)));
}

double Scheduler::time_of_job_ms() const {
  double until_now = 0;
  for (const Running& job : running_) until_now += ms_since(job.since) / static_cast<double>(running_.size());
  return std::max(mean_ms_, until_now);
}

// The first job's time counts fully: a mean that began at 0 would be too short for long.
void Scheduler::ran_for(double ms) {
  ++ended_;
  mean_ms_ += std::max(kShareOfTheLast, 1 / static_cast<double>(ended_)) * (ms - mean_ms_);
}

std::size_t Scheduler::running_of(const std::string& client) const {
  const auto found = running_of_.find(client);
  return found == running_of_.end() ? 0 : found->second;
}

// Returns the task to run next; end(): none, or none that a thread is free for. Precondition: mutex_ is held.
Scheduler::Waiting::iterator Scheduler::next() {
  const auto rank = [this](const Entry& entry) { return std::pair(running_of(entry.task.client), entry.turn); };
  const auto first = std::min_element(waiting_.begin(), waiting_.end(),
                                      [&](const Entry& x, const Entry& y) { return rank(x) < rank(y); });
  const bool for_guests = running_.size() >= limits_.workers;
  return first != waiting_.end() && for_guests && running_of(first->task.client) > 0 ? waiting_.end() : first;
}

Scheduler::Entry Scheduler::take(Waiting::iterator next) {
  Entry entry = std::move(*next);
  waiting_.erase(next);
  return entry;
}

void Scheduler::work() {
  const NeverFails never_fails;
  lower_priority();
  std::unique_lock lock(mutex_);
  for (;;) {
    auto found = waiting_.end();
    ready_.wait(lock, [&] {
      found = next();
      return found != waiting_.end() || (ending_ && waiting_.empty());
    });
    if (found == waiting_.end()) return;
    {
      Entry entry = take(found);
      Control* const control = entry.task.control.get();
      const auto start = Clock::now();
      running_.push_back({control, start});
      ++running_of_[entry.task.client];
      lock.unlock();
      entry.task.work(std::move(entry.slot));
      lock.lock();
      ran_for(ms_since(start));
      std::erase_if(running_, [control](const Running& job) { return job.control == control; });
      if (--running_of_[entry.task.client] == 0) running_of_.erase(entry.task.client);
      if (ending_) ready_.notify_all();
      lock.unlock();  // the job's files and memory are freed without blocking other threads
    }
    lock.lock();
  }
}

}  // namespace meshgauge::server
