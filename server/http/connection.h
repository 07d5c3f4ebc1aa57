// One accepted socket, its transport, and the bytes that have arrived and are not used yet. No call blocks.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/connection_limit.h"
#include "server/http/transport.h"

namespace meshgauge::server {

class Connection {
 public:
  // Bytes per read. Small while a head is read, so that little of a body is copied before the head can refuse it.
  static constexpr std::size_t kHeadPiece = std::size_t{4} << 10;
  static constexpr std::size_t kBodyPiece = std::size_t{64} << 10;

  explicit Connection(int fd) : fd_(fd), transport_(std::make_unique<PlainTransport>(fd)) {}  // borrows fd
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  Transport& transport() { return *transport_; }
  void secure(std::unique_ptr<Transport> transport) { transport_ = std::move(transport); }

  std::string_view buffered() const { return std::string_view(buffer_).substr(start_); }
  void consume(std::size_t n);  // precondition: n <= buffered().size()
  const std::string& peer();    // the address_tag() of the peer's address
  void shrink();                // gives the memory of an empty buffer back

  // Bytes that the kernel has taken for the peer and has not sent, since the peer has no room for them. 0: unknown.
  std::size_t unsent() const;

  // Appends up to `most` arrived bytes to buffered(). wants_*: there are none.
  Transport::Step receive(std::size_t most);

  // Takes one of the places of this address, if it has none yet. False: all are taken. Call before waiting for bytes
  // that are due, and release_place() when the request has arrived in full.
  bool take_place(ConnectionLimit& peers);
  void release_place() { place_.reset(); }

 private:
  int fd_;
  std::shared_ptr<const void> place_;
  std::unique_ptr<Transport> transport_;
  std::string buffer_;
  std::size_t start_ = 0;
  std::string peer_;
};

// Returns a digest of the address, under a key that this process draws at its start and keeps to itself: it is the same
// for as long as the process runs, and does not tell the address. Thread safe.
std::string address_tag(const std::string& address);

// Returns the peer's address as bytes to compare: 4 bytes for IPv4; the first 8 for IPv6, since one host may use any
// address of its /64. Empty: another kind of socket, or not connected any more.
std::string peer_of(int fd);

}  // namespace meshgauge::server
