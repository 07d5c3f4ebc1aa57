// The event loop with silent connections: which of them give way when there are too many.
#include "server/http/event_loop.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "api/base/descriptor.h"
#include "tests/eventually.h"

using meshgauge::Descriptor;
using meshgauge::eventually;
using meshgauge::server::EventLoop;

namespace {

// A connection that waits for nothing, and has shaken hands or never will.
class SilentSource final : public EventLoop::Source {
 public:
  SilentSource(EventLoop& loop, EventLoop::Id id, Descriptor socket, bool unfinished)
      : Source(loop, id, std::move(socket)), unfinished_(unfinished) {}

  void start() override { set_unfinished(unfinished_); }
  void ready() override {}
  void late() override {}
  void take(EventLoop::Message) override {}
  void stop() override { close(); }
  bool spare() const override { return true; }

 private:
  const bool unfinished_;
};

// A listening socket on this machine. Sets its address.
Descriptor listening_socket(sockaddr_in& address) {
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const plain = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const bool listens = ::bind(socket.get(), plain, size) == 0 && ::listen(socket.get(), SOMAXCONN) == 0 &&
                       ::getsockname(socket.get(), plain, &size) == 0;
  REQUIRE(listens);
  return socket;
}

}  // namespace

TEST_CASE("event loop: connections that have not shaken hands give way first while they are more than a quarter") {
  constexpr std::size_t kFinished = 8, kUnfinished = 5;
  sockaddr_in address{};
  Descriptor listener = listening_socket(address);
  std::vector<Descriptor> clients;
  for (std::size_t i = 0; i < kFinished + kUnfinished; ++i) {
    clients.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    REQUIRE(::connect(clients.back().get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  std::size_t made = 0;
  EventLoop loop(
      [&](EventLoop::Id id, Descriptor socket) {
        return std::make_unique<SilentSource>(loop, id, std::move(socket), made++ >= kFinished);
      },
      kFinished);
  std::thread runs([&] { loop.run(std::move(listener)); });
  const auto open = [&] {
    std::string all;
    char byte = 0;
    for (const Descriptor& client : clients) all += ::recv(client.get(), &byte, 1, MSG_DONTWAIT) == 0 ? '-' : '+';
    return all;
  };
  CHECK(eventually([&] { return open() == "---+++++--+++"; }));
  loop.stop();
  runs.join();
}
