// The processes in which uploads are read: an api::load() that trusts no file. Each file is read by a process of its
// own, made beforehand, which may compute and nothing else and ends with it; whatever it does costs that one reading.
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

#include "api/load.h"
#include "server/sandbox/reading.h"
#include "server/sandbox/spawner_client.h"

namespace meshgauge::server::sandbox {

struct PoolSettings {
  std::vector<std::string> command;  // a program and its arguments that calls run_spawner() (spawner.h)
  std::size_t parsers = 1;           // files read at a time; as many processes more are kept ready
  Bounds bounds;                     // of each process; `filter` is filled in by start()
};

// Since start(), by how readings ended. Every load() is in one of them; in `lost` and in another, or twice in it, if
// its file was read a second time.
struct Counters {
  std::uint64_t started = 0;  // processes
  std::array<std::uint64_t, kEndNames.size()> ended{};

  std::uint64_t& operator[](End end) { return ended[static_cast<std::size_t>(end)]; }
  std::uint64_t operator[](End end) const { return ended[static_cast<std::size_t>(end)]; }
};

std::string to_string(const Counters& counters);  // for the log

// Thread safe.
class Pool {
 public:
  using Log = std::function<void(const std::string& detail)>;

  // `log` is told of every reading that did not end well.
  Pool(PoolSettings settings, Log log);

  // Makes the first processes. Gives what this machine lacks and what follows from that, a line each. Called once,
  // before load().
  Result<std::vector<std::string>> start();

  // As api::load(). A worker that crashed, broke a rule or lied is the Error unreadable_mesh, one that needed too much
  // memory is too_large. One that ended through no doing of its file is replaced, once; when that does not help, or a
  // process cannot be had, the Error is internal. When `control` says to stop, whatever is going on, it is out_of_time
  // within 10 ms.
  Result<api::LoadedMesh> load(const api::MeshInput& input, const api::ReadLimits& limits, Control& control);

  // Whether a file would be read: why not, or empty. Tries it, with a triangle and a worker ordered for that, which may
  // take as long as `control` allows; a spawner that has ended is started for it, as it is for load(). That worker is
  // beside those of `parsers`.
  std::string defect(Control& control);

  Counters counters() const;

 private:
  class Turn;

  ReadingOutcome read(const api::MeshInput& input, const api::ReadLimits& limits, Control& control);
  ReadingOutcome read_once(const api::MeshInput& input, const api::ReadLimits& limits, Control& control);
  std::string try_triangle(Control& control);
  enum class Kind { any, fresh };  // fresh: ordered now, which shows that one can be had
  std::variant<ReaderProcess, ReadingOutcome> take(const std::string& part, Control& control, Kind kind = Kind::any);
  std::optional<ReaderProcess> ready();
  std::optional<ReaderProcess> make();
  void start_anew(std::unique_lock<std::mutex>& lock, Control& control);
  std::string try_start(const Interrupted& interrupted);
  void refill();
  void note(const ReadingOutcome& outcome, const std::string& part);

  PoolSettings settings_;  // does not change after start()
  const Log log_;
  mutable std::mutex mutex_;  // guards what follows; held by nobody who waits
  std::condition_variable turn_free_;
  std::size_t busy_ = 0;
  SpawnerClient spawner_;  // its spawner's life; belongs to the thread that starts it anew
  bool starting_ = false;  // there is such a thread
  std::condition_variable started_;
  std::uint64_t failed_starts_ = 0;
  std::string why_not_started_;  // the last time
  std::chrono::milliseconds pause_{0};
  Control::Clock::time_point next_start_{};
  std::deque<ReaderProcess> idle_;
  Counters counters_;
};

}  // namespace meshgauge::server::sandbox
