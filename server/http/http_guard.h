// The HTTP library behind a guard: all that is known of its weak sides stays in this file.
//
// cpp-httplib listens, accepts, writes responses and (later) streams. It never sees a byte from a client: a
// head is read and judged by server/http/head, a body by server/http/body, and the library is given a request line
// only.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "api/problem.h"
#include "server/http/exchange.h"
#include "server/http/http_library.h"
#include "server/http/io_pool.h"
#include "server/http/lingering_close.h"
#include "server/http/tls.h"
#include "server/settings.h"

namespace meshgauge::server {

class HttpGuard final : private httplib::Server {
 public:
  using Handler = std::function<void(Exchange&)>;

  // Called on the I/O threads: `handle` for every request that is let through (it may throw: 500), `log` for every
  // request that was answered. With `tls`, which must outlive the guard, it speaks TLS alone.
  HttpGuard(const Settings& settings, Handler handle, Handler log, const Tls* tls);

  std::optional<int> bind();       // the port; nullopt when the address cannot be had
  bool bound_to_loopback() const;  // after bind(): nobody but this machine can reach the port
  std::uint64_t connections() const { return connections_.load(); }  // being served
  std::uint64_t dropped() const { return dropped_.load(); }          // closed without an answer, since the start
  void run();             // serves until stop(), or until accepting fails for good
  bool running() const;   // run() has come as far as to be stopped: the library forgets a stop() before that
  bool draining() const;  // no connection is accepted any more: after stop(), or the listening socket failed
  void stop();            // no new connections; run() returns when the running requests have their answers
  void abort();           // every wait for a client ends now

 private:
  using Refusal = std::optional<api::Problem>;
  struct Current;

  bool process_and_close_socket(socket_t socket) override;
  enum class End { open, answered, lost };  // answered: the client is to read its last response
  End serve_or_refuse(int socket);
  End secure(Connection& connection);
  End serve(Connection& connection);
  bool await_request(Connection& connection) const;
  bool serve_one(Connection& connection);
  End refuse(Connection& connection);
  Refusal read_head(Connection& connection, Clock::time_point deadline, Head& head) const;
  bool respond(Connection& connection, const Head& head, const Refusal& refusal);
  void send(Current& serving);
  template <class Stream>
  void process(Stream& stream);
  void handle(Current& serving) const;
  bool should_yield() const;

  const Settings settings_;
  const Handler handle_;
  const Handler log_;
  const Tls* const tls_;
  IoPool* pool_ = nullptr;  // owned by the library while it listens
  ConnectionLimit peers_;
  LingeringClose lingering_;
  std::atomic<bool> draining_{false};
  std::atomic<bool> aborted_{false};
  std::atomic<std::uint64_t> connections_{0};
  std::atomic<std::uint64_t> dropped_{0};
  static thread_local Current* current_;
};

}  // namespace meshgauge::server
