#include "server/http/http_guard.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <exception>

#include "api/digest.h"
#include "server/http/event_stream.h"
#include "server/http/file_body.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

constexpr int kBacklog = 1024;  // with the library's own, 5, the kernel would refuse a burst
constexpr milliseconds kWriteTime{30'000};
constexpr milliseconds kRefusalHandshake{250};  // one thread sends all refusals, so it cannot wait for slow clients

milliseconds ms(std::uint64_t count) { return milliseconds(static_cast<std::int64_t>(count)); }

// The library's view of the connection: it reads a request line made here, and writes to the socket.
class GuardedStream final : public httplib::Stream {
 public:
  GuardedStream(Connection& connection, std::string request)
      : connection_(connection), request_(std::move(request)), deadline_(Clock::now() + kWriteTime) {}

  bool is_readable() const override { return read_ < request_.size(); }
  bool is_writable() const override { return !broken_; }

  ssize_t read(char* out, size_t size) override {
    const std::size_t n = request_.copy(out, size, read_);
    read_ += n;
    return static_cast<ssize_t>(n);
  }

  ssize_t write(const char* bytes, size_t size) override {
    if (!started_) deadline_ = Clock::now() + kWriteTime;  // of the whole response
    started_ = true;
    broken_ = broken_ || connection_.write({bytes, size}, deadline_) != Io::ok;
    if (!broken_) written_ += size;
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }

  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return connection_.fd(); }

  bool broken() const { return broken_; }
  std::uint64_t written() const { return written_; }

 private:
  Connection& connection_;
  std::string request_;
  std::size_t read_ = 0;
  Clock::time_point deadline_;
  bool started_ = false;
  bool broken_ = false;
  std::uint64_t written_ = 0;
};

// Increments a counter for its own lifetime.
class Counted {
 public:
  explicit Counted(std::atomic<std::uint64_t>& count) : count_(count) { ++count_; }
  ~Counted() { --count_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  std::atomic<std::uint64_t>& count_;
};

void hand_over(const Response& from, httplib::Response& to) {
  to.status = from.status;
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  if (has_content(from.status)) to.set_content(from.body, from.content_type);
}

}  // namespace

// The request that this thread serves. Thread local, because the library's handlers cannot be given it.
struct HttpGuard::Current {
  Exchange& exchange;
  const Refusal& refusal;
  bool close;  // close the connection after this response
};
thread_local HttpGuard::Current* HttpGuard::current_ = nullptr;

HttpGuard::HttpGuard(const Settings& settings, Handler handle, Handler log, const Tls* tls)
    : settings_(settings),
      handle_(std::move(handle)),
      log_(std::move(log)),
      tls_(tls),
      peers_(settings.max_arriving_per_peer) {
  new_task_queue = [this] {
    const auto at_end = [this] { draining_.store(true); };
    return pool_ = new IoPool(settings_.io_threads, settings_.max_pending_connections, at_end);
  };
  set_tcp_nodelay(true);  // else responses wait for the client's delayed acknowledgement
  set_socket_options([](socket_t socket) {
    const int yes = 1;  // the library's default, SO_REUSEPORT, would let two services share a port unnoticed
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  set_pre_routing_handler([](const httplib::Request&, httplib::Response& response) {
    hand_over(current_->exchange.response, response);
    return HandlerResponse::Handled;
  });
  // Runs after the library has added headers of its own.
  set_post_routing_handler([](const httplib::Request&, httplib::Response& response) {
    for (const char* name : {"Keep-Alive", "Accept-Ranges", "Connection"}) response.headers.erase(name);
    const bool has_length = has_content(response.status) && current_->exchange.response.length_known;
    if (!has_length) response.headers.erase("Content-Length");  // RFC 9110 section 8.6
    if (current_->close) response.set_header("Connection", "close");
  });
}

std::optional<int> HttpGuard::bind() {
  int port = static_cast<int>(settings_.port);
  if (port == 0) {
    port = bind_to_any_port(settings_.host);
  } else if (!bind_to_port(settings_.host, port)) {
    port = -1;
  }
  if (port < 0 || ::listen(svr_sock_, kBacklog) != 0) return std::nullopt;
  return port;
}

bool HttpGuard::bound_to_loopback() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getsockname(svr_sock_, reinterpret_cast<sockaddr*>(&address), &size) != 0) return false;
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    return ntohl(v4.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
  }
  if (address.ss_family != AF_INET6) return false;
  const in6_addr& v6 = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  return IN6_IS_ADDR_LOOPBACK(&v6) || (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == IN_LOOPBACKNET);
}

void HttpGuard::run() { listen_after_bind(); }

bool HttpGuard::running() const { return is_running(); }

bool HttpGuard::draining() const { return draining_.load(); }

// After a failed accept the library has closed the listening socket. Its stop() would close that descriptor again,
// which may be another file's by now.
void HttpGuard::stop() {
  if (!draining_.exchange(true)) httplib::Server::stop();
}

void HttpGuard::abort() {
  aborted_.store(true);
  lingering_.abort();
}

bool HttpGuard::process_and_close_socket(socket_t socket) {
  Descriptor owned(socket);
  if (IoPool::role() == IoPool::Role::drop) return ++dropped_, true;
  const Counted counted(connections_);
  try {
    if (serve_or_refuse(socket) == End::answered) lingering_.take(std::move(owned));
  } catch (const std::exception&) {  // out of memory between two requests: only this connection is lost
  }
  return true;
}

HttpGuard::End HttpGuard::serve_or_refuse(int socket) {
  const bool serving = IoPool::role() == IoPool::Role::serve;
  Connection connection(socket, aborted_, serving ? &peers_ : nullptr);
  End end = secure(connection);
  if (end == End::open) end = serving ? serve(connection) : refuse(connection);
  if (end == End::answered) connection.end();
  return end;
}

// The handshake has the time limit of a head, from its first byte on. A client that sends plain HTTP gets a 400.
HttpGuard::End HttpGuard::secure(Connection& connection) {
  if (!tls_) return End::open;
  const bool refusing = IoPool::role() == IoPool::Role::refuse;
  const auto idle_until = Clock::now() + (refusing ? kRefusalHandshake : ms(settings_.keep_alive_ms));
  char first = 0;
  const auto give_up = [&] { return !refusing && should_yield(); };
  if (connection.first_byte(first, idle_until, give_up) != Io::ok) return End::lost;
  if (first >= 'A' && first <= 'Z') {  // the first letter of an HTTP method
    respond(connection, Head{}, Problem{ProblemKind::malformed_request, "this port speaks TLS: use https", {}});
    return End::answered;
  }
  const auto deadline = Clock::now() + (refusing ? kRefusalHandshake : ms(settings_.head_timeout_ms));
  return connection.secure(tls_->accept(connection.fd()), deadline) == Io::ok ? End::open : End::lost;
}

HttpGuard::End HttpGuard::serve(Connection& connection) {
  while (await_request(connection)) {
    if (!serve_one(connection)) return End::answered;
  }
  return End::lost;
}

HttpGuard::End HttpGuard::refuse(Connection& connection) {
  respond(connection, Head{}, Problem{ProblemKind::overloaded, "all connections are in use; retry in a moment", {}});
  return End::answered;
}

// True: an idle connection is to be closed, since its thread is needed for a pending one or the service stops.
bool HttpGuard::should_yield() const { return draining_.load() || pool_->has_pending(); }

bool HttpGuard::await_request(Connection& connection) const {
  connection.release_place();
  if (!connection.buffered().empty()) return true;
  const auto idle_until = Clock::now() + ms(settings_.keep_alive_ms);
  return connection.idle(idle_until, [this] { return should_yield(); }) == Io::ok;
}

bool HttpGuard::serve_one(Connection& connection) {
  Head head;
  const Refusal refusal = read_head(connection, Clock::now() + ms(settings_.head_timeout_ms), head);
  const bool has_body = head.chunked || head.content_length.value_or(0) > 0;
  if (!refusal && !has_body) connection.release_place();  // else Body::read() releases it
  return respond(connection, head, refusal);
}

HttpGuard::Refusal HttpGuard::read_head(Connection& connection, Clock::time_point deadline, Head& head) const {
  for (;;) {
    while (connection.buffered().starts_with("\r\n")) connection.consume(2);  // RFC 9112 section 2.2
    const std::string_view buffered = connection.buffered();
    const std::size_t end = buffered.substr(0, kMaxHeadBytes).find("\r\n\r\n");
    if (end != std::string_view::npos) {
      const std::string text(buffered.substr(0, end + 4));
      connection.consume(text.size());
      return parse_head(text, settings_.max_request_bytes, head);
    }
    if (auto refusal = check_incomplete(buffered)) return refusal;
    const Io io = connection.fill(deadline, Connection::kHeadPiece);
    if (io != Io::ok) return not_arrived(io, "head", ms(settings_.head_timeout_ms));
  }
}

// A template, so that only the overload that the installed version of the library has is compiled.
template <class Stream>
void HttpGuard::process(Stream& stream) {
  bool closed = false;
  if constexpr (requires { this->process_request(stream, false, closed, nullptr); }) {
    process_request(stream, false, closed, nullptr);
  } else {
    process_request(stream, "", 0, "", 0, false, closed, nullptr);
  }
}

bool HttpGuard::respond(Connection& connection, const Head& head, const Refusal& refusal) {
  Body body(connection, head, settings_.max_request_bytes, ms(settings_.body_timeout_ms));
  Exchange exchange(api::random_id(), head, body, connection);
  Current serving{exchange, refusal, refusal.has_value() || !head.keep_alive};
  handle(serving);
  if (exchange.response.stream) {
    send_stream(exchange);
  } else if (exchange.response.file) {
    send_file(exchange, serving.close);
  } else {
    send(serving);
  }
  log_(exchange);
  return exchange.delivered && !serving.close;
}

void HttpGuard::send(Current& serving) {
  Exchange& exchange = serving.exchange;
  const bool no_body = exchange.head.method == "HEAD";
  GuardedStream stream(exchange.connection, (no_body ? "HEAD" : "GET") + std::string(" / HTTP/1.1\r\n\r\n"));
  current_ = &serving;
  process(stream);
  current_ = nullptr;
  exchange.bytes_out = stream.written();
  exchange.delivered = !stream.broken();
}

void HttpGuard::handle(Current& serving) const {
  Exchange& exchange = serving.exchange;
  try {
    serving.refusal ? answer(exchange, *serving.refusal) : handle_(exchange);
  } catch (const std::exception& error) {
    exchange.failure = error.what();
    answer(exchange, Problem{ProblemKind::internal,
                             "internal error; the service's log has the cause under the id " + exchange.id,
                             {}});
  }
  auto& headers = exchange.response.headers;
  headers.emplace_back("X-Request-Id", exchange.id);
  for (auto& header : trace_headers(exchange.trace)) headers.push_back(std::move(header));
  add_security_headers(exchange.response);
  // The connection is kept after such a refusal: under overload a new connection would cost more than the refusal.
  const bool try_again = exchange.response.status == 429 || exchange.response.status == 503;
  if (try_again && exchange.head.method == "POST") exchange.body.discard_arrived();
  // The unread rest of a body would be parsed as the next request.
  serving.close = serving.close || draining_.load() || !exchange.body.consumed() || exchange.response.stream;
}

}  // namespace meshgauge::server
