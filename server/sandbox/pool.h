// Reads uploads in separate processes: an api::load() for untrusted files. Each file has a process of its own,
// started in advance, that may only compute and ends with the file. Whatever a file does costs that one reading.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/compare/load.h"
#include "server/sandbox/reading.h"
#include "server/sandbox/spawner_client.h"

namespace meshgauge::server::sandbox {

struct PoolSettings {
  std::vector<std::string> command;  // program and arguments that call run_spawner() (spawner.h)
  std::size_t parsers = 1;           // files read at the same time; as many more processes are kept ready
  Bounds bounds;                     // limits of a process at most; start() fills in `filter`
  bool required = false;             // start() fails where a protection is lacking
};

// Numbers of readings since start(), by how they ended. Each load() counts in one; a file that was read twice counts
// in `lost` and in one more, or twice in `lost`.
struct Counters {
  std::uint64_t started = 0;  // processes started
  std::array<std::uint64_t, kEndNames.size()> ended{};

  std::uint64_t& operator[](End end) { return ended[static_cast<std::size_t>(end)]; }
  std::uint64_t operator[](End end) const { return ended[static_cast<std::size_t>(end)]; }
};

std::string to_string(const Counters& counters);  // for the log

// Thread safe.
class Pool {
 public:
  using Log = std::function<void(const std::string& detail)>;

  // Calls `log` for each reading that failed.
  Pool(PoolSettings settings, Log log);

  // Starts the first processes. Returns a line for each protection that this machine lacks, with its consequence.
  // Call once, before load(). Errors: no process can be started, or limited; `required` and a protection is lacking.
  Result<std::vector<std::string>> start();

  // As api::load(). Errors: unreadable_mesh: the worker crashed, broke a rule or lied; too_large: it needed too much
  // memory; internal: no process was available, or two were lost through no fault of the file; out_of_time: within 10
  // ms after `control` says to stop. Blocks.
  //
  // A process first gets memory for a file as files usually are, and only where that is not enough, a second one all
  // that `bounds` allow. `memory` is asked before each, before the arrays come, and before a wait for other files;
  // null: it is not.
  Result<api::LoadedMesh> load(const api::MeshInput& input, const api::ReadLimits& limits, Control& control,
                               Memory* memory = nullptr);

  // Checks whether a file would be read: returns why not, or an empty string. Reads a triangle in an extra worker,
  // and starts the spawner if it has ended, as load() does. Blocks as long as `control` allows.
  std::string defect(Control& control);

  Counters counters() const;

 private:
  class Turn;

  struct Task {
    const api::MeshInput& input;
    const api::ReadLimits& limits;
    Memory* memory;
  };

  ReadingOutcome read(const Task& task, Control& control);
  ReadingOutcome read_within(const Task& task, std::uint64_t memory_bytes, Control& control);
  ReadingOutcome read_once(const Task& task, std::uint64_t memory_bytes, Control& control);
  std::string try_triangle(Control& control);
  enum class Kind { any, fresh };  // fresh: a new one, to see whether the spawner can make one
  std::variant<ReaderProcess, ReadingOutcome> take(const std::string& part, std::uint64_t memory_bytes,
                                                   Control& control, Kind kind = Kind::any);
  std::optional<ReaderProcess> ready();
  std::optional<ReaderProcess> make(std::uint64_t memory_bytes);
  void start_anew(std::unique_lock<std::mutex>& lock, Control& control);
  std::string try_start(const Interrupted& interrupted);
  void refill();
  void note(const ReadingOutcome& outcome, const std::string& part);

  PoolSettings settings_;  // constant after start()
  const std::uint64_t memory_of_idle_;
  const Log log_;
  mutable std::mutex mutex_;  // guards the members below; not held while waiting
  std::condition_variable turn_free_;
  std::size_t busy_ = 0;
  SpawnerClient spawner_;  // its start and end belong to the thread that restarts it
  bool starting_ = false;  // a thread restarts the spawner
  std::condition_variable started_;
  std::uint64_t failed_starts_ = 0;
  std::string why_not_started_;  // reason of the last failure
  std::chrono::milliseconds pause_{0};
  Control::Clock::time_point next_start_{};
  std::deque<ReaderProcess> idle_;
  Counters counters_;
};

}  // namespace meshgauge::server::sandbox
