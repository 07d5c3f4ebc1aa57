// The server's side of the spawner: starts it, orders workers, ends it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.h"
#include "server/sandbox/channel.h"
#include "server/sandbox/protocol.h"

namespace meshgauge::server::sandbox {

// A worker, killed when this object is destroyed. For one thread at a time.
class ReaderProcess {
 public:
  ReaderProcess(Descriptor channel, Descriptor life) : channel_(std::move(channel)), life_(std::move(life)) {}

  int channel() const { return channel_.get(); }

  bool gone() const;  // it has ended, or has sent something unexpected; useless in both cases

  // Waits until the worker has ended, without killing it. Returns its wait status (waitpid). nullopt: unknown within
  // `time` or until `interrupted`, not forked, or the spawner ended before it.
  std::optional<int> status(std::chrono::milliseconds time, const Interrupted& interrupted) const;

 private:
  Descriptor channel_;
  Descriptor life_;
};

// Not thread safe.
class SpawnerClient {
 public:
  // `command`: program and arguments that call run_spawner() (spawner.h).
  explicit SpawnerClient(std::vector<std::string> command) : command_(std::move(command)) {}
  ~SpawnerClient() { stop(); }
  SpawnerClient(const SpawnerClient&) = delete;
  SpawnerClient& operator=(const SpawnerClient&) = delete;

  // Starts the spawner, replacing one that ran before, and has it try `bounds`. Threads may exist. Returns its Trial,
  // with empty `limits`. Blocks for at most ten seconds, and 10 ms after `interrupted` is true.
  Result<Trial> start(const Bounds& bounds, const Interrupted& interrupted = never_interrupted);

  // Whether the spawner does not run.
  bool gone() const;

  // Orders a worker, which may be sent a request at once. nullopt: the spawner does not run, or no descriptors are
  // left.
  std::optional<ReaderProcess> spawn(const Bounds& bounds);

 private:
  Result<Trial> hear(const Interrupted& interrupted);
  void stop(const Interrupted& interrupted = never_interrupted);

  const std::vector<std::string> command_;
  Descriptor control_;
  pid_t pid_ = -1;
  std::vector<pid_t> killed_;  // groups that were killed and may still have processes
};

}  // namespace meshgauge::server::sandbox
