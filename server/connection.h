// One accepted socket: buffered reading and writing, each with an absolute deadline. A time-out per read
// would let a client hold a thread for ever by sending one byte at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/transport.h"

namespace meshgauge::server {

using Clock = std::chrono::steady_clock;

enum class Io { ok, closed, timeout };

class Connection {
 public:
  // Borrows the socket; `aborted` ends every wait as if its deadline had passed.
  Connection(int fd, const std::atomic<bool>& aborted)
      : fd_(fd), aborted_(aborted), transport_(std::make_unique<PlainTransport>(fd)) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Waits for the peer's first byte, which stays unread: at the start it tells TLS from a request. Before anything
  // else.
  Io first_byte(char& byte, Clock::time_point deadline, const std::function<bool()>& give_up) const;

  // From now on the connection speaks through `transport`, once its handshake is done.
  Io secure(std::unique_ptr<Transport> transport, Clock::time_point deadline);

  std::string_view buffered() const { return std::string_view(buffer_).substr(start_); }
  void consume(std::size_t n);  // precondition: n <= buffered().size()

  // Waits for more bytes and appends them to buffered(). `give_up` is asked every 50 ms.
  Io fill(Clock::time_point deadline, const std::function<bool()>& give_up = nullptr);

  Io write(std::string_view bytes, Clock::time_point deadline);

  // The client has closed its side (or half of it), or the connection is broken. By the thread that reads and writes.
  bool peer_gone() { return transport_->peer_gone(); }

  // Ends our side and lets the client read the last response: closing with unread bytes would reset the
  // connection and take the response with it. At most `time` and 16 MiB.
  void linger(std::chrono::milliseconds time);

  int fd() const { return fd_; }

 private:
  Io read(char* out, std::size_t& got, Clock::time_point deadline, const std::function<bool()>& give_up);
  Io wait(short events, Clock::time_point deadline, const std::function<bool()>& give_up) const;

  int fd_;
  const std::atomic<bool>& aborted_;
  std::unique_ptr<Transport> transport_;
  std::string buffer_;
  std::size_t start_ = 0;
};

}  // namespace meshgauge::server
