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
class Worker {
 public:
  Worker(Descriptor channel, Descriptor life) : channel_(std::move(channel)), life_(std::move(life)) {}

  int channel() const { return channel_.get(); }

  bool gone() const;  // it has ended, or has said something unasked: of no use either way

  // Kills it and waits until it is no more, within `time`. Gives its wait status (waitpid), of its own end if it came
  // first; nullopt when that is not known in time, or when the spawner could not make it or ended before it.
  std::optional<int> end(std::chrono::milliseconds time);

 private:
  Descriptor channel_;
  Descriptor life_;
};

// Not thread safe.
class Nursery {
 public:
  // `command` is a program and its arguments, which calls run_spawner() (spawner.h).
  explicit Nursery(std::vector<std::string> command) : command_(std::move(command)) {}
  ~Nursery() { stop(); }
  Nursery(const Nursery&) = delete;
  Nursery& operator=(const Nursery&) = delete;

  // Starts the spawner, in place of one that ran before. May be called while there are other threads. Gives what
  // run_spawner() says: why calls cannot be forbidden, empty when they can.
  Result<std::string> start();

  // The spawner is not running.
  bool gone() const;

  // Orders a worker; it may be asked at once and answers when it is there. nullopt: the spawner is not running, or no
  // descriptors are left.
  std::optional<Worker> spawn(const Bounds& bounds);

 private:
  void stop();

  const std::vector<std::string> command_;
  Descriptor control_;
  pid_t pid_ = -1;
};

}  // namespace meshgauge::server::sandbox
