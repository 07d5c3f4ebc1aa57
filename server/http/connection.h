// One accepted socket: buffered reading and writing, each with an absolute deadline. A time-out per read would let a
// client hold a thread for ever by sending one byte at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "server/http/connection_limit.h"
#include "server/http/transport.h"

namespace meshgauge::server {

using Clock = std::chrono::steady_clock;

// closed: the peer closed the connection, or it broke. aborted: the service is shutting down. peer_limit: too many
// connections from this address are being waited for.
enum class Io { ok, closed, timeout, aborted, peer_limit };

class Connection {
 public:
  // Bytes per read. Small while a head is read, so that little of a body is copied before the head can refuse it.
  static constexpr std::size_t kHeadPiece = std::size_t{4} << 10;
  static constexpr std::size_t kBodyPiece = std::size_t{64} << 10;

  // Borrows all three. `aborted`: once true, every wait ends with Io::aborted. `peers`: limits how many connections per
  // address are waited for; null: no limit.
  Connection(int fd, const std::atomic<bool>& aborted, ConnectionLimit* peers = nullptr)
      : fd_(fd), aborted_(aborted), peers_(peers), transport_(std::make_unique<PlainTransport>(fd)) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Waits for the first byte and copies it to `byte`; it stays unread. It tells TLS from plain HTTP. Call before any
  // other read. `give_up` as for idle().
  Io first_byte(char& byte, Clock::time_point deadline, const std::function<bool()>& give_up);

  // Replaces the transport and completes its handshake.
  Io secure(std::unique_ptr<Transport> transport, Clock::time_point deadline);

  std::string_view buffered() const { return std::string_view(buffer_).substr(start_); }
  void consume(std::size_t n);  // precondition: n <= buffered().size()

  // Appends up to `most` bytes to buffered(), waiting for them if none has arrived. The first wait takes one of the
  // places of this address and keeps it until release_place(); Io::peer_limit when none is free.
  Io fill(Clock::time_point deadline, std::size_t most = kBodyPiece);

  // As fill(), between two requests: takes no place. `give_up` is called every 50 ms; true ends the wait with
  // Io::timeout.
  Io idle(Clock::time_point deadline, const std::function<bool()>& give_up);

  enum class Counted { yes, no };
  // Writes all of `bytes`. Waiting takes a place as in fill(); with Counted::no it does not, for responses that are
  // limited elsewhere and must not fail in the middle for lack of a place.
  Io write(std::string_view bytes, Clock::time_point deadline, Counted counted = Counted::yes);

  void release_place() { place_.reset(); }  // call when the request has arrived in full

  // True: the client has closed its side (or half of it), or the connection is broken. Call on the thread that reads
  // and writes. Does not block.
  bool peer_gone() { return transport_->peer_gone(); }

  // Tells the client that nothing more will be sent. The socket then goes to server/http/lingering_close.h.
  void end() { transport_->end(); }

  int fd() const { return fd_; }

 private:
  bool take_place();
  Io wait(short events, Clock::time_point deadline, Counted counted, const std::function<bool()>& give_up);
  Io receive(std::size_t most, Clock::time_point deadline, Counted counted, const std::function<bool()>& give_up);
  Io read(std::span<char> out, std::size_t& got, Clock::time_point deadline, Counted counted,
          const std::function<bool()>& give_up);

  int fd_;
  const std::atomic<bool>& aborted_;
  ConnectionLimit* peers_;
  std::shared_ptr<const void> place_;
  std::unique_ptr<Transport> transport_;
  std::string buffer_;
  std::size_t start_ = 0;
};

// Returns the peer's address as bytes to compare: 4 bytes for IPv4; the first 8 for IPv6, since one host may use any
// address of its /64. Empty: another kind of socket, or not connected any more.
std::string peer_of(int fd);

}  // namespace meshgauge::server
