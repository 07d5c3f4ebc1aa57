// Connections that have had their last response. The client must get to read it: closing a socket with unread bytes
// resets the connection and takes the response with it. So our side is ended, and what still arrives is thrown away
// until the client closes as well.
//
// One thread does that for all of them: an I/O thread that waited for each client would serve nobody else meanwhile,
// and under a surplus of requests most connections end this way.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <thread>

#include "server/sandbox/descriptor.h"

namespace meshgauge::server {

class LingeringClose {
 public:
  static constexpr std::chrono::milliseconds kTime{1000};           // that a client has to close
  static constexpr std::size_t kMostBytes = std::size_t{16} << 20;  // of one client that are thrown away
  static constexpr std::size_t kMost = 256;                         // at once

  explicit LingeringClose(std::size_t most = kMost);  // beyond `most` the oldest is closed
  ~LingeringClose();                                  // gives those that are left their time
  LingeringClose(const LingeringClose&) = delete;
  LingeringClose& operator=(const LingeringClose&) = delete;

  // Takes `socket` over; nothing may be written to it any more. Any thread; does not wait.
  void take(Descriptor socket);

  void abort();  // from now on nobody is waited for
  std::size_t size() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Closing {
    Descriptor socket;
    Clock::time_point deadline;
    std::size_t drained = 0;
  };

  void run();

  const std::size_t most_;
  mutable std::mutex mutex_;  // guards what follows; nothing under it waits for a client
  std::condition_variable changed_;
  std::deque<Closing> closings_;  // the oldest first
  bool ending_ = false;
  bool aborted_ = false;
  std::thread thread_;
};

}  // namespace meshgauge::server
