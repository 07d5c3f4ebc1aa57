#include "server/http/connection.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::address_tag;
using server::Connection;
using server::peer_of;
using Step = server::Transport::Step;

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

TEST_CASE("address tag: one for each address, which it does not show") {
  const std::string tag = address_tag("192.0.2.1");
  CHECK(tag == address_tag("192.0.2.1"));
  CHECK(tag != address_tag("192.0.2.2"));
  CHECK(tag.size() == 32);
  CHECK(tag.find_first_not_of("0123456789abcdef") == std::string::npos);
}

TEST_CASE("connection: a place of its address is kept until release_place()") {
  server::ConnectionLimit peers{1};
  const Pair a = ipv4(), b = ipv4();
  Connection slow(a.ends[0]), other(b.ends[0]);
  CHECK(slow.take_place(peers));
  CHECK(slow.take_place(peers));
  CHECK_FALSE(other.take_place(peers));
  slow.release_place();
  CHECK(other.take_place(peers));
  CHECK_FALSE(slow.take_place(peers));
}

TEST_CASE("connection: what has arrived is kept until it is consumed") {
  const Pair pair = ipv4();
  Connection connection(pair.ends[0]);
  CHECK(connection.receive(10) == Step::wants_read);
  REQUIRE(::send(pair.ends[1], "hello", 5, 0) == 5);
  pollfd arrived{pair.ends[0], POLLIN, 0};
  REQUIRE(::poll(&arrived, 1, 10'000) == 1);
  CHECK(connection.receive(3) == Step::done);
  CHECK(connection.buffered() == "hel");
  connection.consume(2);
  CHECK(connection.receive(10) == Step::done);
  CHECK(connection.buffered() == "llo");
  REQUIRE(::shutdown(pair.ends[1], SHUT_WR) == 0);
  REQUIRE(::poll(&arrived, 1, 10'000) == 1);
  CHECK(connection.receive(10) == Step::closed);
}
