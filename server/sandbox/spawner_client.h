// The server's side of the spawner: starts it, orders workers from it, and ends it.
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

// A worker as long as somebody wants it: it is killed when this object goes. One thread at a time.
class ReaderProcess {
 public:
  ReaderProcess(Descriptor channel, Descriptor life) : channel_(std::move(channel)), life_(std::move(life)) {}

  int channel() const { return channel_.get(); }

  bool gone() const;  // it has ended, or has said something unasked: of no use either way

  // Waits until it has ended, and does not make it. Gives its wait status (waitpid); nullopt when that is not known
  // within `time` or until `interrupted` says so, or when the spawner could not make it or ended before it.
  std::optional<int> status(std::chrono::milliseconds time, const Interrupted& interrupted) const;

 private:
  Descriptor channel_;
  Descriptor life_;
};

// Not thread safe.
class SpawnerClient {
 public:
  // `command` is a program and its arguments, which calls run_spawner() (spawner.h).
  explicit SpawnerClient(std::vector<std::string> command) : command_(std::move(command)) {}
  ~SpawnerClient() { stop(); }
  SpawnerClient(const SpawnerClient&) = delete;
  SpawnerClient& operator=(const SpawnerClient&) = delete;

  // Starts the spawner, in place of one that ran before, and has it try `bounds`. May be called while there are other
  // threads. Gives its Trial, of which `limits` is empty. Takes ten seconds at most, and 10 ms from when
  // `interrupted` says so.
  Result<Trial> start(const Bounds& bounds, const Interrupted& interrupted = never_interrupted);

  // The spawner is not running.
  bool gone() const;

  // Orders a worker; it may be asked at once and answers when it is there. nullopt: the spawner is not running, or no
  // descriptors are left.
  std::optional<ReaderProcess> spawn(const Bounds& bounds);

 private:
  Result<Trial> hear(const Interrupted& interrupted);
  void stop(const Interrupted& interrupted = never_interrupted);

  const std::vector<std::string> command_;
  Descriptor control_;
  pid_t pid_ = -1;
  std::vector<pid_t> killed_;  // groups that were killed and are not all gone: the kernel may take its time
};

}  // namespace meshgauge::server::sandbox
