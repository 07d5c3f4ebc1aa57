// Closes connections without losing their last response. Closing a socket with unread bytes resets the connection, and
// the client may lose the response. So the service ends its own direction and discards what still arrives until the
// client closes as well.
//
// One thread does this for all connections, so that no I/O thread waits for a client. Under overload most connections
// end this way.
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
  static constexpr std::chrono::milliseconds kTime{1000};           // time that a client has to close
  static constexpr std::size_t kMostBytes = std::size_t{16} << 20;  // bytes discarded for one client
  static constexpr std::size_t kMost = 256;                         // connections at once

  explicit LingeringClose(std::size_t most = kMost);  // beyond `most` connections the oldest is closed
  ~LingeringClose();                                  // waits for those that are left, for kTime at most
  LingeringClose(const LingeringClose&) = delete;
  LingeringClose& operator=(const LingeringClose&) = delete;

  // Takes ownership of `socket`. Precondition: its sending direction is ended. Thread safe; does not block.
  void take(Descriptor socket);

  void abort();  // closes all connections at once, also those that come later
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
  mutable std::mutex mutex_;  // guards what follows; never held while waiting
  std::condition_variable changed_;
  std::deque<Closing> closings_;  // oldest first
  bool ending_ = false;
  bool aborted_ = false;
  std::thread thread_;
};

}  // namespace meshgauge::server
