// The HTTP server: wraps cpp-httplib and shields it from clients. Workarounds for the library live here.
//
// cpp-httplib listens, accepts and writes plain responses. It never sees a byte from a client: server/http/head reads
// and validates the head, server/http/body the body, and the library gets a request line made here.
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

  // `handle` is called for every valid request, on an I/O thread; if it throws, the response is 500. `log` is called
  // after every response, on the same thread. `tls`: serve TLS only; it must outlive the guard. Null: plain HTTP.
  HttpGuard(const Settings& settings, Handler handle, Handler log, const Tls* tls);

  std::optional<int> bind();                                         // the port; nullopt: failed, see errno
  bool bound_to_loopback() const;                                    // after bind(): only this machine can connect
  std::uint64_t connections() const { return connections_.load(); }  // being served
  std::uint64_t dropped() const { return dropped_.load(); }          // closed without a response, since the start

  // Serves until stop(), or until the listening socket fails. Blocks until the running requests have their responses.
  void run();
  bool running() const;   // run() can be stopped; the library ignores a stop() before that
  bool draining() const;  // no connection is accepted any more, after stop() or a failure
  void stop();            // accepts no more connections; does not wait
  void abort();           // ends every wait for a client with Io::aborted

 private:
  using Refusal = std::optional<api::Problem>;
  struct Current;

  bool process_and_close_socket(socket_t socket) override;
  enum class End { open, answered, lost };  // answered: the last response is sent, but perhaps not read yet
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
  IoPool* pool_ = nullptr;  // the library owns it while it listens
  ConnectionLimit peers_;
  LingeringClose lingering_;
  std::atomic<bool> draining_{false};
  std::atomic<bool> aborted_{false};
  std::atomic<std::uint64_t> connections_{0};
  std::atomic<std::uint64_t> dropped_{0};
  static thread_local Current* current_;
};

}  // namespace meshgauge::server
