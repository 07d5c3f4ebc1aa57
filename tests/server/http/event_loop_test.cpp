// The event loop with silent connections: which of them give way when there are too many.
#include "server/http/event_loop.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
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
using namespace std::chrono_literals;

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

// A connection that serves a request, whose client has taken nothing since then.
class StalledSource final : public EventLoop::Source {
 public:
  StalledSource(EventLoop& loop, EventLoop::Id id, Descriptor socket, EventLoop::Clock::time_point since,
                std::atomic<int>& gave_way)
      : Source(loop, id, std::move(socket)), since_(since), gave_way_(gave_way) {}

  void start() override {}
  void ready() override {}
  void late() override {}
  void take(EventLoop::Message) override {}
  void stop() override { close(); }
  bool spare() const override { return false; }
  EventLoop::Clock::time_point stalled_since() const override { return since_; }
  void give_way() override { ++gave_way_; }

 private:
  const EventLoop::Clock::time_point since_;
  std::atomic<int>& gave_way_;
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

// A loop of at most `most` connections, made by `make`, to which `clients` connect one after the other.
class Crowd {
 public:
  using Make = std::function<std::unique_ptr<EventLoop::Source>(EventLoop&, EventLoop::Id, Descriptor)>;

  Crowd(const Make& make, std::size_t most, std::size_t clients)
      : loop_([this, make](EventLoop::Id id, Descriptor socket) { return make(loop_, id, std::move(socket)); }, most) {
    sockaddr_in address{};
    Descriptor listener = listening_socket(address);
    for (std::size_t i = 0; i < clients; ++i) {
      clients_.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
      REQUIRE(::connect(clients_.back().get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    }
    runs_ = std::thread([this, listener = std::move(listener)]() mutable { loop_.run(std::move(listener)); });
  }
  ~Crowd() {
    loop_.stop();
    runs_.join();
  }

  // Whether each client's connection is open: + or -.
  std::string open() const {
    std::string all;
    char byte = 0;
    for (const Descriptor& client : clients_) all += ::recv(client.get(), &byte, 1, MSG_DONTWAIT) == 0 ? '-' : '+';
    return all;
  }

 private:
  EventLoop loop_;
  std::vector<Descriptor> clients_;
  std::thread runs_;
};

}  // namespace

TEST_CASE("event loop: connections that have not shaken hands give way first while they are more than a quarter") {
  constexpr std::size_t kFinished = 8, kUnfinished = 5;
  std::size_t made = 0;
  const Crowd crowd(
      [&](EventLoop& loop, EventLoop::Id id, Descriptor socket) {
        return std::make_unique<SilentSource>(loop, id, std::move(socket), made++ >= kFinished);
      },
      kFinished, kFinished + kUnfinished);
  CHECK(eventually([&] { return crowd.open() == "---+++++--+++"; }));
}

TEST_CASE("event loop: where all serve a request, the one whose client has stalled for longest gives way") {
  constexpr auto kNever = EventLoop::Clock::time_point::max();
  const auto now = EventLoop::Clock::now();
  const std::vector<EventLoop::Clock::time_point> since{now - 5s, kNever, now - 9s, kNever, kNever, kNever};
  std::size_t made = 0;
  std::atomic<int> gave_way = 0;
  const Crowd crowd(
      [&](EventLoop& loop, EventLoop::Id id, Descriptor socket) {
        return std::make_unique<StalledSource>(loop, id, std::move(socket), since.at(made++), gave_way);
      },
      4, 7);
  CHECK(eventually([&] { return crowd.open() == "-+-+++-"; }));
  CHECK(gave_way == 2);
}
