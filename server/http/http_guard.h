// The HTTP server. cpp-httplib resolves the address and binds the socket; it never sees a byte from a client:
// server/http/head reads and validates the head, server/http/body the body, server/http/serving writes the response.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

#include "server/http/client.h"
#include "server/http/event_loop.h"
#include "server/http/exchange.h"
#include "server/http/handshakes.h"
#include "server/http/http_library.h"
#include "server/http/request_handler.h"
#include "server/http/tls.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// Returns whether a host's name has an address that only this machine can reach, or has no address. May block for the
// name's resolution.
bool stands_for_loopback(const std::string& host);

class HttpGuard final : private httplib::Server {
 public:
  // Borrows handler and `tls`. `tls`: serve TLS only; null: plain HTTP. `connections`: the most that may be open.
  // `write_time`: for a client to take a response, or a piece of a stream.
  HttpGuard(const Settings& settings, RequestHandler& handler, const Tls* tls, std::size_t connections,
            std::chrono::milliseconds write_time = std::chrono::seconds(30));

  std::optional<int> bind();                                  // the port; nullopt: failed, see errno
  bool bound_to_loopback() const;                             // after bind(): only this machine can connect
  std::uint64_t connections() const { return loop_.size(); }  // open
  std::uint64_t dropped() const { return loop_.dropped(); }   // closed without a response, since the start
  Handshakes::Counts handshakes() const;                      // since the start; none without TLS

  // Serves until stop(), or until the listening socket fails. Blocks until the running requests have their responses.
  // Call once, after bind().
  void run();
  bool draining() const { return loop_.stopping(); }  // no connection is accepted any more, after stop() or a failure
  void stop() { loop_.stop(); }                       // accepts no more connections; does not wait
  void abort() { loop_.abort(); }                     // waits for no client any more: ends arriving requests

 private:
  Edge edge_;
  EventLoop loop_;
};

}  // namespace meshgauge::server
