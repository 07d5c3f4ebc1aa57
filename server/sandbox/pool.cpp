#include "server/sandbox/pool.h"

#include <algorithm>
#include <exception>
#include <new>
#include <span>
#include <string_view>
#include <utility>

#include "api/base/memory_file.h"

namespace meshgauge::server::sandbox {
namespace {

// Pause after the first failed start of a spawner; doubles with each failure.
constexpr std::chrono::milliseconds kLeastPause{50};
constexpr std::chrono::milliseconds kMostPause{1000};

// A process that waits for a file has this limit, which is enough for files up to 512 KiB.
constexpr std::uint64_t kMemoryOfIdle = std::uint64_t{48} << 20;

// What reading a file usually takes: an array exists twice while it grows, and a compressed file expands.
std::uint64_t usual_memory(std::uint64_t file_bytes) {
  constexpr std::uint64_t kBeside = std::uint64_t{32} << 20;
  constexpr std::uint64_t kOfByte = 32;
  return kBeside + kOfByte * file_bytes;
}

Error not_protected(const std::string& lack) {
  return {ErrorCode::internal, "--require-sandbox: " + lack + "; allow it in the container's or unit's policy", "", ""};
}

constexpr std::string_view kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

}  // namespace

std::string to_string(const Counters& counters) {
  std::string text = std::to_string(counters.started) + " processes started";
  for (std::size_t i = 0; i < kEndNames.size(); ++i) {
    text += (i == 0 ? "; " : ", ") + std::to_string(counters.ended[i]) + " " + std::string(kEndNames[i]);
  }
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

// One of the readings that may run at the same time.
class Pool::Turn {
 public:
  Turn(Pool& pool, Control& control, Memory* memory) : pool_(pool) {
    std::unique_lock lock(pool_.mutex_);
    if (memory && pool_.busy_ == pool_.settings_.parsers) may_wait_ = memory->wait_for_turn();
    if (!may_wait_) return;
    while (pool_.busy_ == pool_.settings_.parsers && why_ == Interruption::none) {
      pool_.turn_free_.wait_for(lock, kTick);
      why_ = control.check();
    }
    if (why_ == Interruption::none) ++pool_.busy_;
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  ~Turn() {
    if (!may_wait_ || why_ != Interruption::none) return;
    {
      const std::lock_guard lock(pool_.mutex_);
      --pool_.busy_;
    }
    pool_.turn_free_.notify_one();
  }

  // Why there is no turn; nullopt: it was granted.
  std::optional<ReadingOutcome> refusal(const std::string& part) const {
    if (!may_wait_) return no_memory(may_wait_.error());
    if (why_ != Interruption::none) return interrupted(why_, part, "was still waited for");
    return std::nullopt;
  }

 private:
  Pool& pool_;
  Result<Done> may_wait_ = Done{};
  Interruption why_ = Interruption::none;
};

Pool::Pool(PoolSettings settings, Log log)
    : settings_(std::move(settings)),
      memory_of_idle_(std::min(settings_.bounds.memory_bytes, kMemoryOfIdle)),
      log_(std::move(log)),
      spawner_(settings_.command) {}

Result<std::vector<std::string>> Pool::start() {
  auto trial = spawner_.start(settings_.bounds);
  if (!trial) return std::move(trial).error();
  settings_.bounds.filter = trial->filter.empty();
  refill();
  std::vector<std::string> lacks;
  if (!trial->filter.empty()) lacks.push_back("seccomp is not in force: " + trial->filter);
  if (!seals_are_known()) lacks.emplace_back("files in memory cannot be sealed");
  if (settings_.required && !lacks.empty()) return not_protected(lacks.front());
  for (std::string& lack : lacks) lack += "; uploads are read with less protection";
  if (!trial->small.empty()) lacks.push_back(trial->small + "; uploads are read as safely, and take longer");
  return lacks;
}

Result<api::LoadedMesh> Pool::load(const api::MeshInput& input, const api::ReadLimits& limits, Control& control,
                                   Memory* memory) {
  ReadingOutcome outcome = [&] {
    try {
      return read({input, limits, memory}, control);
    } catch (const std::bad_alloc&) {
      return failed(input.part, "did not get through: the service ran out of memory");
    } catch (const std::exception& e) {
      return failed(input.part, std::string("did not get through: ") + e.what());
    }
  }();
  note(outcome, input.part);
  return std::move(outcome.mesh);
}

ReadingOutcome Pool::read(const Task& task, Control& control) {
  const Turn turn(*this, control, task.memory);
  if (auto refusal = turn.refusal(task.input.part)) return *std::move(refusal);
  const std::uint64_t most = settings_.bounds.memory_bytes;
  std::uint64_t bytes = std::min(most, std::max(memory_of_idle_, usual_memory(task.input.bytes.size())));
  ReadingOutcome outcome = read_within(task, bytes, control);
  if (outcome.end == End::out_of_memory && bytes < most) outcome = read_within(task, most, control);
  if (task.memory) task.memory->end_reader();
  return outcome;
}

ReadingOutcome Pool::read_within(const Task& task, std::uint64_t memory_bytes, Control& control) {
  for (bool first = true;; first = false) {
    if (task.memory) {
      const auto granted = task.memory->take_reader(memory_bytes);
      if (!granted) return no_memory(granted.error());
      memory_bytes = *granted;
    }
    ReadingOutcome outcome = read_once(task, memory_bytes, control);
    if (outcome.end != End::lost || !first) return outcome;
    note(outcome, task.input.part);
  }
}

ReadingOutcome Pool::read_once(const Task& task, std::uint64_t memory_bytes, Control& control) {
  auto taken = take(task.input.part, memory_bytes, control);
  if (auto* const instead = std::get_if<ReadingOutcome>(&taken)) return std::move(*instead);
  Reading reading(std::get<ReaderProcess>(std::move(taken)), task.input, task.limits, task.memory);
  if (!reading.begin()) return failed(task.input.part, "could not be given it: memory or descriptors ran out");
  refill();  // while the worker reads
  return reading.finish(control);
}

std::string Pool::defect(Control& control) {
  try {
    const std::string how = try_triangle(control);
    return how.empty() ? "" : "a reader of uploads " + how;
  } catch (const std::exception& e) {
    return std::string("a reader of uploads could not be tried: ") + e.what();
  }
}

// Uses a new worker: the idle ones do not show whether the spawner can still fork.
std::string Pool::try_triangle(Control& control) {
  const api::MeshInput triangle{"triangle", std::as_bytes(std::span(kTriangle)), "triangle.obj", ""};
  auto taken = take(triangle.part, memory_of_idle_, control, Kind::fresh);
  if (const auto* none = std::get_if<ReadingOutcome>(&taken)) return none->how;
  const api::ReadLimits limits{3, 1, kTriangle.size()};
  Reading reading(std::get<ReaderProcess>(std::move(taken)), triangle, limits);
  if (!reading.begin()) return "could not be given a triangle: memory or descriptors ran out";
  const ReadingOutcome outcome = reading.finish(control);
  if (outcome.mesh) return "";
  return outcome.how.empty() ? "did not understand a triangle: " + outcome.mesh.error().message : outcome.how;
}

Counters Pool::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

// Waits at most for one attempt to start the spawner that began after the call.
std::variant<ReaderProcess, ReadingOutcome> Pool::take(const std::string& part, std::uint64_t memory_bytes,
                                                       Control& control, Kind kind) {
  std::unique_lock lock(mutex_);
  const std::uint64_t failed_before = failed_starts_;
  for (;;) {
    const bool idle_one = kind == Kind::any && memory_bytes == memory_of_idle_;
    if (auto worker = idle_one ? ready() : make(memory_bytes)) return std::move(*worker);
    if (failed_starts_ != failed_before) return failed(part, "is not there: " + why_not_started_);
    // The spawner lives and could not be asked, because descriptors ran out. Other readings wait for its workers.
    if (!starting_ && !spawner_.gone()) return failed(part, "is not there: no process could be ordered");
    if (const Interruption why = control.check(); why != Interruption::none) {
      return interrupted(why, part, "was still waited for");
    }
    if (!starting_ && Control::Clock::now() >= next_start_) {
      start_anew(lock, control);
    } else {
      started_.wait_for(lock, kTick);
    }
  }
}

// An idle worker may have been killed, by the kernel or an operator.
std::optional<ReaderProcess> Pool::ready() {
  if (starting_) return std::nullopt;
  if (spawner_.gone()) idle_.clear();
  while (!idle_.empty()) {
    ReaderProcess worker = std::move(idle_.front());
    idle_.pop_front();
    if (!worker.gone()) return worker;
  }
  return make(memory_of_idle_);
}

std::optional<ReaderProcess> Pool::make(std::uint64_t memory_bytes) {
  if (starting_) return std::nullopt;
  Bounds bounds = settings_.bounds;
  bounds.memory_bytes = memory_bytes;
  auto worker = spawner_.spawn(bounds);
  if (worker) ++counters_.started;
  return worker;
}

// An interrupted thread leaves the start to another one; that is not a failure.
void Pool::start_anew(std::unique_lock<std::mutex>& lock, Control& control) {
  bool given_up = false;
  starting_ = true;
  idle_.clear();  // workers of a dead spawner are about to die
  lock.unlock();
  std::string why_not = try_start([&] { return given_up = control.check() != Interruption::none; });
  lock.lock();
  starting_ = false;
  if (why_not.empty()) {
    pause_ = std::chrono::milliseconds(0);
  } else if (!given_up) {
    ++failed_starts_;
    why_not_started_ = std::move(why_not);
    pause_ = std::clamp(2 * pause_, kLeastPause, kMostPause);
    next_start_ = Control::Clock::now() + pause_;
  }
  started_.notify_all();
}

// Returns why the spawner does not run; empty: it runs.
std::string Pool::try_start(const Interrupted& interrupted) {
  try {
    const auto started = spawner_.start(settings_.bounds, interrupted);
    return started ? "" : started.error().message;
  } catch (const std::bad_alloc&) {
    return "memory ran out";
  }
}

void Pool::refill() {
  const std::lock_guard lock(mutex_);
  while (idle_.size() < settings_.parsers) {
    auto worker = make(memory_of_idle_);
    if (!worker) return;  // take() handles it
    idle_.push_back(std::move(*worker));
  }
}

void Pool::note(const ReadingOutcome& outcome, const std::string& part) {
  {
    const std::lock_guard lock(mutex_);
    ++counters_[outcome.end];
  }
  if (!outcome.how.empty()) log_("the reader of '" + part + "' " + outcome.how);
}

}  // namespace meshgauge::server::sandbox
