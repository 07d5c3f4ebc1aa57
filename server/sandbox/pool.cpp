#include "server/sandbox/pool.h"

#include <utility>

#include "server/sandbox/memory_file.h"

namespace meshgauge::server::sandbox {
namespace {

constexpr std::chrono::milliseconds kTick{10};

std::uint64_t Counters::*counter_of(End end) {
  switch (end) {
    case End::read:
      return &Counters::read;
    case End::out_of_memory:
      return &Counters::out_of_memory;
    case End::crashed:
      return &Counters::crashed;
    case End::untrue:
      return &Counters::untrue;
    case End::overdue:
      return &Counters::overdue;
    case End::cancelled:
      break;
  }
  return &Counters::cancelled;
}

}  // namespace

std::string to_string(const Counters& c) {
  return std::to_string(c.started) + " processes started; " + std::to_string(c.read) + " read, " +
         std::to_string(c.out_of_memory) + " out of memory, " + std::to_string(c.crashed) + " crashed, " +
         std::to_string(c.untrue) + " untrue, " + std::to_string(c.overdue) + " overdue, " +
         std::to_string(c.cancelled) + " cancelled";
}

// One of the readings that may go on at a time.
class Pool::Turn {
 public:
  Turn(Pool& pool, Control& control) : pool_(pool) {
    std::unique_lock lock(pool_.mutex_);
    while (pool_.busy_ == pool_.settings_.parsers && why_ == Interruption::none) {
      pool_.turn_free_.wait_for(lock, kTick);
      why_ = control.check();
    }
    if (why_ == Interruption::none) ++pool_.busy_;
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  ~Turn() {
    if (why_ != Interruption::none) return;
    {
      const std::lock_guard lock(pool_.mutex_);
      --pool_.busy_;
    }
    pool_.turn_free_.notify_one();
  }

  Interruption why() const { return why_; }  // it was not had; none: it was

 private:
  Pool& pool_;
  Interruption why_ = Interruption::none;
};

Pool::Pool(PoolSettings settings, Log log)
    : settings_(std::move(settings)), log_(std::move(log)), nursery_(settings_.command) {}

Result<std::vector<std::string>> Pool::start() {
  auto unfiltered = nursery_.start();
  if (!unfiltered) return std::move(unfiltered).error();
  settings_.bounds.filter = unfiltered->empty();
  refill();
  std::vector<std::string> lacks;
  if (!unfiltered->empty()) lacks.push_back("seccomp is not in force: " + *unfiltered);
  if (!seals_are_known()) lacks.emplace_back("files in memory cannot be sealed");
  return lacks;
}

Result<api::LoadedMesh> Pool::load(const api::MeshInput& input, const api::ReadLimits& limits, Control& control) {
  const Turn turn(*this, control);
  if (turn.why() != Interruption::none) return api::not_in_time(turn.why(), "'" + input.part + "' was read");
  auto worker = take();
  if (!worker) return Error{ErrorCode::internal, "there is no process to read '" + input.part + "'", "", ""};
  Reading reading(std::move(*worker), input, limits);
  if (!reading.begin()) return Error{ErrorCode::internal, "'" + input.part + "' could not be handed over", "", ""};
  refill();  // while that one works
  Outcome outcome = reading.finish(control);
  count(outcome.end);
  if (!outcome.how.empty()) log_("the reader of '" + input.part + "' " + outcome.how);
  return std::move(outcome.mesh);
}

Counters Pool::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

// Somebody, or the kernel, may have killed one that was waiting.
std::optional<Worker> Pool::take() {
  const std::lock_guard lock(mutex_);
  while (!idle_.empty()) {
    Worker worker = std::move(idle_.front());
    idle_.pop_front();
    if (!worker.gone()) return worker;
  }
  auto worker = make();
  // A spawner that lives, and could not be asked for want of descriptors, has workers that others wait for.
  if (worker || !nursery_.gone() || !nursery_.start()) return worker;
  return make();
}

std::optional<Worker> Pool::make() {
  auto worker = nursery_.spawn(settings_.bounds);
  if (worker) ++counters_.started;
  return worker;
}

void Pool::refill() {
  const std::lock_guard lock(mutex_);
  while (idle_.size() < settings_.parsers) {
    auto worker = make();
    if (!worker) return;  // take() starts anew
    idle_.push_back(std::move(*worker));
  }
}

void Pool::count(End end) {
  const std::lock_guard lock(mutex_);
  ++(counters_.*counter_of(end));
}

}  // namespace meshgauge::server::sandbox
