// One accepted socket: buffered reading and writing, each with an absolute deadline. A time-out per read
// would let a client hold a thread for ever by sending one byte at a time.
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

// aborted: nobody is waited for any more. peer_limit: too many connections of this address are waited for.
enum class Io { ok, closed, timeout, aborted, peer_limit };

class Connection {
 public:
  // Read at a time. What may be refused by its head is not read any further: of a body that nobody wants nothing is
  // copied.
  static constexpr std::size_t kHeadPiece = std::size_t{4} << 10;
  static constexpr std::size_t kBodyPiece = std::size_t{64} << 10;

  // Borrows all three; `aborted` ends every wait. Without `peers` nothing is counted.
  Connection(int fd, const std::atomic<bool>& aborted, ConnectionLimit* peers = nullptr)
      : fd_(fd), aborted_(aborted), peers_(peers), transport_(std::make_unique<PlainTransport>(fd)) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Waits for the peer's first byte, which stays unread: at the start it tells TLS from a request. Before anything
  // else.
  Io first_byte(char& byte, Clock::time_point deadline, const std::function<bool()>& give_up);

  // From now on the connection speaks through `transport`, once its handshake is done.
  Io secure(std::unique_ptr<Transport> transport, Clock::time_point deadline);

  std::string_view buffered() const { return std::string_view(buffer_).substr(start_); }
  void consume(std::size_t n);  // precondition: n <= buffered().size()

  // Waits for more bytes and appends them to buffered(). The first time that they are not there yet takes one of the
  // places of this address, which is kept until release_place().
  Io fill(Clock::time_point deadline, std::size_t most = kBodyPiece);

  // The same between two requests, where nobody is owed anything: takes no place. `give_up` is asked every 50 ms.
  Io idle(Clock::time_point deadline, const std::function<bool()>& give_up);

  enum class Counted { yes, no };
  // Takes a place as fill() does, unless what is written is counted elsewhere: an answer that has begun must not fail
  // for want of one.
  Io write(std::string_view bytes, Clock::time_point deadline, Counted counted = Counted::yes);

  void release_place() { place_.reset(); }  // the request is here: its client is waited for no more

  // The client has closed its side (or half of it), or the connection is broken. By the thread that reads and writes.
  bool peer_gone() { return transport_->peer_gone(); }

  void end() {
    transport_->end();
  }  // tells the client that nothing more will be sent; then server/http/lingering_close.h

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

// The address at the other end, as bytes to compare: of IPv4 all 4, of IPv6 the first 8, since a single host is given
// that many of the rest. Empty for every other kind of socket, and one that is no longer connected.
std::string peer_of(int fd);

}  // namespace meshgauge::server
