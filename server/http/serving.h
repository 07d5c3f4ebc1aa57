// One request, from its complete head to the last byte of its response. It belongs to one thread at a time and never
// waits: advance() does what can be done now, and says what to wait for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "api/base/problem.h"
#include "server/http/connection.h"
#include "server/http/edge.h"
#include "server/http/event_loop.h"
#include "server/http/exchange.h"
#include "server/http/request_handler.h"
#include "server/http/transport.h"

namespace meshgauge::server {

// Why a head or body did not arrive. peer_limit: too many connections of this address are being waited for.
enum class Lost { closed, timeout, stalled, aborted, peer_limit };

// Returns the problem of a head or body (`what` names which) that did not arrive. `time_ms`: the limit, for the
// message.
api::Problem not_arrived(Lost why, const std::string& what, std::uint64_t time_ms);

// What is to be sent to one client: text, then perhaps a file.
class Outgoing {
 public:
  void add(std::string text) { text_.empty() ? text_ = std::move(text) : text_ += text; }  // precondition: no file
  void add(FileBody file) { file_ = std::move(file); }

  // Writes as much as the socket takes, up to 1 MiB of a file. Does not block. done: that is written; empty() says
  // whether more is left.
  Transport::Step write(Transport& transport);

  bool empty() const { return text_.size() == text_sent_ && file_.bytes.empty(); }
  bool has_file() const { return !file_.bytes.empty(); }
  std::uint64_t written() const { return written_; }  // in all

 private:
  Transport::Step write(Transport& transport, std::string_view bytes, std::size_t& sent);

  std::string text_;
  std::size_t text_sent_ = 0;
  FileBody file_;
  std::uint64_t written_ = 0;
};

class Serving {
 public:
  using Step = Transport::Step;
  static constexpr std::uint64_t kMostDiscarded = std::uint64_t{16} << 20;

  enum class End { keep, close };  // of the connection, after to_discard() bytes
  // What to wait for: the socket, until deadline(); or a time, a wake-up or the client's going; or nothing any more.
  using State = std::variant<Step, Clock::time_point, End>;

  // Borrows the first three. `refusal`: of the head; it is the response then. `wake`: for Exchange::wake.
  Serving(Edge& edge, const EventLoop& loop, Connection& connection, Head head,
          const std::optional<api::Problem>& refusal, std::function<void()> wake);

  RequestHandler::Entry enter();  // calls RequestHandler::enter
  void handle();                  // calls RequestHandler::handle

  // Receives what has arrived of the body, makes the response and writes as much of it as the socket takes.
  State advance();
  bool is_quick() const;                // advance() does not block now
  void lose(Lost why) { lost_ = why; }  // the rest of the body is not waited for: advance() ends it
  State end(bool delivered);            // ends the response where it is, and logs it

  Exchange& exchange() { return exchange_; }
  bool receiving() const { return body_.reading(); }
  Clock::time_point deadline() const { return *deadline_; }
  std::uint64_t to_discard() const { return body_.left(); }

 private:
  Step receive_body();
  std::optional<Clock::time_point> make_response();
  void compose();
  bool stands_still();
  bool add_piece(Clock::time_point& due);
  void fail(const std::exception& error);

  Edge& edge_;
  const EventLoop& loop_;
  Connection& connection_;
  const Head head_;
  Body body_;
  Exchange exchange_;
  Outgoing outgoing_;
  bool composed_ = false;
  bool close_;  // after this response
  std::optional<Lost> lost_;
  std::optional<Clock::time_point> deadline_;            // of the body's next bytes, then of what is being written
  Clock::time_point body_latest_;                        // of the whole body
  Clock::time_point latest_ = Clock::time_point::max();  // of the whole response
  Clock::time_point last_piece_ = Clock::now();          // of a stream
  std::uint64_t unsent_ = 0;                             // of a stream: Connection::unsent() at the last look
  std::uint64_t written_by_then_ = 0;                    // of a stream: bytes at the last look
  Clock::time_point moved_{};                            // of a stream: when it began or its client last took some
};

}  // namespace meshgauge::server
