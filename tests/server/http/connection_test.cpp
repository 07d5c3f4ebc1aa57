#include "server/http/connection.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::Connection;
using server::Io;
using server::peer_of;

namespace {

// Both ends of a connection over loopback; -1 if this machine has no address of the family.
struct Pair {
  std::array<int, 2> ends{-1, -1};  // ours, the client's

  template <class Address>
  explicit Pair(Address address) {
    auto* plain = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = sizeof address;
    const int listener = ::socket(plain->sa_family, SOCK_STREAM, 0);
    const bool listening =
        ::bind(listener, plain, size) == 0 && ::listen(listener, 1) == 0 && ::getsockname(listener, plain, &size) == 0;
    if (listening) {
      ends[1] = ::socket(plain->sa_family, SOCK_STREAM, 0);
      REQUIRE(::connect(ends[1], plain, size) == 0);
      ends[0] = ::accept(listener, nullptr, nullptr);
    }
    ::close(listener);
  }
  ~Pair() {
    for (const int end : ends) ::close(end);
  }
};

Pair ipv4() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return Pair(address);
}

server::Clock::time_point soon() { return server::Clock::now() + std::chrono::milliseconds(100); }

// Two connections of one address with a limit of one place.
struct TwoOfOneAddress {
  server::ConnectionLimit peers{1};
  std::atomic<bool> aborted{false};
  Pair a = ipv4();
  Pair b = ipv4();
  Connection slow{a.ends[0], aborted, &peers};
  Connection other{b.ends[0], aborted, &peers};
};

}  // namespace

TEST_CASE("connection: the address of a connection") {
  const Pair pair = ipv4();
  CHECK(peer_of(pair.ends[0]) == std::string("\x7f\0\0\1", 4));
  sockaddr_in6 address{};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  if (const Pair six(address); six.ends[0] >= 0) CHECK(peer_of(six.ends[0]) == std::string(8, '\0'));
  CHECK(peer_of(-1).empty());
}

TEST_CASE("connection: waiting for bytes takes a place and keeps it until release_place()") {
  TwoOfOneAddress two;
  Connection &slow = two.slow, &other = two.other;
  CHECK(slow.idle(soon(), [] { return true; }) == Io::timeout);
  CHECK(slow.fill(soon()) == Io::timeout);
  CHECK(other.fill(soon()) == Io::peer_limit);
  REQUIRE(::send(two.b.ends[1], "x", 1, 0) == 1);
  pollfd arrived{two.b.ends[0], POLLIN, 0};
  REQUIRE(::poll(&arrived, 1, 10'000) == 1);
  CHECK(other.fill(soon()) == Io::ok);  // its bytes had arrived
  CHECK(other.fill(soon()) == Io::peer_limit);
  slow.release_place();
  CHECK(other.fill(soon()) == Io::timeout);
  CHECK(slow.fill(soon()) == Io::peer_limit);
}

TEST_CASE("connection: waiting for a client that does not read takes a place as well") {
  TwoOfOneAddress two;
  Connection &slow = two.slow, &other = two.other;
  const std::string much(std::size_t{64} << 20, 'x');
  CHECK(slow.write("a little", soon()) == Io::ok);
  CHECK(other.fill(soon()) == Io::timeout);
  CHECK(slow.write(much, soon()) == Io::peer_limit);
  other.release_place();
  CHECK(slow.write(much, soon()) == Io::timeout);
}
