#include "server/http/http_guard.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <memory>
#include <utility>

namespace meshgauge::server {
namespace {

constexpr int kBacklog = SOMAXCONN;  // with the library's own, 5, the kernel would refuse a burst
constexpr std::size_t kStatusThreads = 2;
// Seconds after which a silent peer is asked whether it is still there, and how often: what a client waits for is ended
// 45 s after its machine or the network has gone without a word.
constexpr int kProbeAfter = 20, kProbeEvery = 5, kProbes = 5;

bool is_loopback(const sockaddr& address) {
  if (address.sa_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    return ntohl(v4.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
  }
  if (address.sa_family != AF_INET6) return false;
  const in6_addr& v6 = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  return IN6_IS_ADDR_LOOPBACK(&v6) || (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == IN_LOOPBACKNET);
}

}  // namespace

bool stands_for_loopback(const std::string& host) {
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), "0", &hints, &found) != 0) return true;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> all(found, ::freeaddrinfo);
  for (const addrinfo* one = found; one; one = one->ai_next) {
    if (is_loopback(*one->ai_addr)) return true;
  }
  return false;
}

HttpGuard::HttpGuard(const Settings& settings, RequestHandler& handler, const Tls* tls, std::size_t connections,
                     std::chrono::milliseconds write_time)
    : edge_{settings,
            write_time,
            tls,
            handler,
            ConnectionLimit(settings.max_arriving_per_peer),
            {settings.io_threads, settings.max_pending_connections},
            {kStatusThreads, settings.max_pending_connections},
            tls ? std::make_unique<Handshakes>(settings) : nullptr},
      loop_([this](EventLoop::Id id,
                   Descriptor socket) { return std::make_unique<Client>(edge_, loop_, id, std::move(socket)); },
            connections) {
  set_socket_options([](socket_t socket) {
    const auto set = [socket](int level, int option, int value) {
      ::setsockopt(socket, level, option, &value, sizeof value);
    };
    // The library's default, SO_REUSEPORT, would let two services share a port unnoticed.
    set(SOL_SOCKET, SO_REUSEADDR, 1);
    // Connections inherit the rest. Without the first, responses wait for the client's delayed acknowledgement.
    set(IPPROTO_TCP, TCP_NODELAY, 1);
    set(SOL_SOCKET, SO_KEEPALIVE, 1);
    set(IPPROTO_TCP, TCP_KEEPIDLE, kProbeAfter);
    set(IPPROTO_TCP, TCP_KEEPINTVL, kProbeEvery);
    set(IPPROTO_TCP, TCP_KEEPCNT, kProbes);
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
  return ::getsockname(svr_sock_, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
         is_loopback(reinterpret_cast<const sockaddr&>(address));
}

Handshakes::Counts HttpGuard::handshakes() const {
  return edge_.handshakes ? edge_.handshakes->counts() : Handshakes::Counts{};
}

void HttpGuard::run() { loop_.run(Descriptor(svr_sock_)); }

}  // namespace meshgauge::server
