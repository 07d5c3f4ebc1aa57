#include "server/http/http_guard.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

namespace meshgauge::server {
namespace {

constexpr int kBacklog = 1024;  // with the library's own, 5, the kernel would refuse a burst
constexpr std::size_t kStatusThreads = 2;
constexpr std::size_t kMostConnections = 100'000;

// Raises the limit on descriptors to what the process may have (the soft one is often 1024), and returns the share of
// connections: three quarters. The others are for uploads and stores.
std::size_t most_connections() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return kMostConnections;
  const rlim_t granted = std::exchange(limit.rlim_cur, limit.rlim_max);
  if (::setrlimit(RLIMIT_NOFILE, &limit) != 0) limit.rlim_cur = granted;
  return static_cast<std::size_t>(std::min<rlim_t>(kMostConnections, limit.rlim_cur / 4 * 3));
}

// The library's view of a connection: it reads a request line made here, and what it writes is kept.
class TextStream final : public httplib::Stream {
 public:
  explicit TextStream(std::string_view request) : request_(request) {}

  bool is_readable() const override { return !request_.empty(); }
  bool is_writable() const override { return true; }

  ssize_t read(char* out, size_t size) override {
    const std::size_t n = request_.copy(out, size);
    request_.remove_prefix(n);
    return static_cast<ssize_t>(n);
  }

  ssize_t write(const char* bytes, size_t size) override {
    written_.append(bytes, size);
    return static_cast<ssize_t>(size);
  }

  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return -1; }

  std::string take() { return std::move(written_); }

 private:
  std::string_view request_;
  std::string written_;
};

void hand_over(const Response& from, httplib::Response& to) {
  to.status = from.status;
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  if (has_content(from.status)) to.set_content(from.body, from.content_type);
}

}  // namespace

// The response that this thread writes. Thread local, because the library's handlers cannot be given it.
struct HttpGuard::Current {
  const Response& response;
  bool close;
};
thread_local HttpGuard::Current* HttpGuard::current_ = nullptr;

HttpGuard::HttpGuard(const Settings& settings, Handlers handlers, const Tls* tls)
    : edge_{settings,
            tls,
            std::move(handlers.enter),
            std::move(handlers.handle),
            std::move(handlers.log),
            [this](const Exchange& exchange, bool close) { return write(exchange, close); },
            [this] { return loop_.stopping(); },
            ConnectionLimit(settings.max_arriving_per_peer),
            {settings.io_threads, settings.max_pending_connections},
            {kStatusThreads, settings.max_pending_connections}},
      loop_([this](EventLoop::Id id,
                   Descriptor socket) { return std::make_unique<Client>(edge_, loop_, id, std::move(socket)); },
            most_connections()) {
  set_socket_options([](socket_t socket) {
    const int yes = 1;  // the library's default, SO_REUSEPORT, would let two services share a port unnoticed
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  set_pre_routing_handler([](const httplib::Request&, httplib::Response& response) {
    hand_over(current_->response, response);
    return HandlerResponse::Handled;
  });
  // Runs after the library has added headers of its own.
  set_post_routing_handler([](const httplib::Request&, httplib::Response& response) {
    for (const char* name : {"Keep-Alive", "Accept-Ranges", "Connection"}) response.headers.erase(name);
    const bool has_length = has_content(response.status) && current_->response.length_known;
    if (!has_length) response.headers.erase("Content-Length");  // RFC 9110 section 8.6
    if (current_->close) response.set_header("Connection", "close");
  });
}

std::optional<int> HttpGuard::bind() {
  int port = static_cast<int>(edge_.settings.port);
  if (port == 0) {
    port = bind_to_any_port(edge_.settings.host);
  } else if (!bind_to_port(edge_.settings.host, port)) {
    port = -1;
  }
  if (port < 0 || ::listen(svr_sock_, kBacklog) != 0) return std::nullopt;
  const int flags = ::fcntl(svr_sock_, F_GETFL);
  if (flags < 0 || ::fcntl(svr_sock_, F_SETFL, flags | O_NONBLOCK) != 0) return std::nullopt;
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

void HttpGuard::run() { loop_.run(Descriptor(svr_sock_)); }

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

std::string HttpGuard::write(const Exchange& exchange, bool close) {
  TextStream stream(exchange.head.method == "HEAD" ? "HEAD / HTTP/1.1\r\n\r\n" : "GET / HTTP/1.1\r\n\r\n");
  Current current{exchange.response, close};
  current_ = &current;
  process(stream);
  current_ = nullptr;
  return stream.take();
}

}  // namespace meshgauge::server
