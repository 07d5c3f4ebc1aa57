#include "server/jobs/scheduler.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

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
  if (scheduler_) scheduler_->release(kind_);
}

Scheduler::Scheduler(const Limits& limits) : limits_(limits) {
  for (std::size_t i = 0; i < limits.workers; ++i) workers_.emplace_back([this] { work(); });
}

void Scheduler::end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ready_.notify_all();
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

std::optional<Scheduler::Slot> Scheduler::admit(Kind kind) {
  const std::lock_guard lock(mutex_);
  std::size_t& taken = kind == Kind::awaited ? awaited_ : durable_;
  if (taken >= (kind == Kind::awaited ? limits_.awaited : limits_.durable)) return std::nullopt;
  ++taken;
  return Slot(this, kind);
}

Scheduler::Slot Scheduler::admit_again() {
  const std::lock_guard lock(mutex_);
  ++durable_;
  return {this, Kind::durable};
}

void Scheduler::release(Kind kind) {
  const std::lock_guard lock(mutex_);
  --(kind == Kind::awaited ? awaited_ : durable_);
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
  for (Control* control : running_) control->cancel();
}

Scheduler::Figures Scheduler::figures() const {
  const std::lock_guard lock(mutex_);
  return {waiting_.size(), running_.size(), awaited_, durable_};
}

std::chrono::milliseconds Scheduler::expected_wait(std::size_t elsewhere) const {
  const std::lock_guard lock(mutex_);
  const double before = static_cast<double>(waiting_.size() + elsewhere) + 1;
  return milliseconds(static_cast<std::int64_t>(mean_ms_ * before / static_cast<double>(limits_.workers)));
}

// Precondition: mutex_ is held and a task waits.
Scheduler::Entry Scheduler::take_next() {
  const auto rank = [this](const Entry& entry) {
    const auto found = running_of_.find(entry.task.owner);
    return std::pair(found == running_of_.end() ? std::size_t{0} : found->second, entry.turn);
  };
  auto next = waiting_.begin();
  auto first = rank(*next);
  for (auto other = std::next(next); other != waiting_.end(); ++other) {
    if (const auto of_other = rank(*other); of_other < first) next = other, first = of_other;
  }
  Entry entry = std::move(*next);
  waiting_.erase(next);
  return entry;
}

void Scheduler::work() {
  lower_priority();
  std::unique_lock lock(mutex_);
  for (;;) {
    ready_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    {
      Entry entry = take_next();
      Control* const control = entry.task.control.get();
      running_.push_back(control);
      ++running_of_[entry.task.owner];
      lock.unlock();
      const auto start = Clock::now();
      entry.task.work(std::move(entry.slot));
      lock.lock();
      mean_ms_ += kShareOfTheLast * (ms_since(start) - mean_ms_);
      std::erase(running_, control);
      if (--running_of_[entry.task.owner] == 0) running_of_.erase(entry.task.owner);
      lock.unlock();  // the job's files and memory are freed without blocking other threads
    }
    lock.lock();
  }
}

}  // namespace meshgauge::server
