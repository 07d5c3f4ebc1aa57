#include "server/http/handshakes.h"

#include <sys/socket.h>

#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include <doctest/doctest.h>

#include "api/base/descriptor.h"
#include "server/main/checked.h"
#include "tests/eventually.h"

using meshgauge::Descriptor;
using meshgauge::eventually;
using meshgauge::server::checked;
using meshgauge::server::Handshake;
using meshgauge::server::HandshakeQueue;
using meshgauge::server::Handshakes;
using meshgauge::server::PeerRates;
using meshgauge::server::Settings;

namespace {

constexpr PeerRates::Time kSomeTime{std::chrono::hours(1)};

Handshake waiting_handshake(std::uint64_t id, double left) {
  Handshake handshake;
  handshake.id = id;
  handshake.left = left;
  return handshake;
}

std::uint64_t id_or_0(const std::optional<Handshake>& handshake) { return handshake ? handshake->id : 0; }

// One thread, and a rate that no test reaches.
Settings of_one_handshake_thread() {
  Settings settings;
  settings.handshake_threads = 1;
  settings.max_handshakes_per_second = 1'000'000;
  return checked(settings).value();
}

// Both ends of a connection: ours, the client's.
std::array<Descriptor, 2> connected_ends() {
  int ends[2] = {-1, -1};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

}  // namespace

TEST_CASE("peer rates: an address has a burst and a rate of its own") {
  PeerRates rates(2);
  for (int i = 9; i >= 0; --i) CHECK(rates.take("a", kSomeTime) == static_cast<double>(i));
  CHECK(!rates.take("a", kSomeTime));
  CHECK(rates.take("b", kSomeTime) == 9.0);
  CHECK(rates.take("a", kSomeTime + std::chrono::milliseconds(501)).has_value());
  CHECK(!rates.take("a", kSomeTime + std::chrono::milliseconds(502)));
}

TEST_CASE("peer rates: addresses whose bucket is full again are forgotten") {
  PeerRates rates(1);
  for (int i = 0; i < 2000; ++i) CHECK(rates.take(std::to_string(i), kSomeTime).has_value());
  CHECK(rates.size() == 2000);
  CHECK(rates.take("new", kSomeTime + std::chrono::seconds(2)) == 4.0);
  CHECK(rates.size() == 1);
}

TEST_CASE("peer rates: beyond a number of addresses the others share a bucket") {
  PeerRates rates(1);
  for (std::size_t i = 0; i < PeerRates::kMostPeers; ++i) rates.take(std::to_string(i), kSomeTime);
  for (int i = 0; i < 5; ++i) CHECK(rates.take("new " + std::to_string(i), kSomeTime).has_value());
  CHECK(!rates.take("another", kSomeTime));
  CHECK(rates.take("0", kSomeTime) == 3.0);
  CHECK(rates.size() == PeerRates::kMostPeers + 1);
}

TEST_CASE("handshake queue: the address with the most left is next, of equal ones the first") {
  HandshakeQueue queue(1000, 10, kSomeTime);
  CHECK(!queue.take(kSomeTime));
  const std::array<double, 5> left{5, 9, 9, 0, 5};
  for (std::size_t i = 0; i < left.size(); ++i) CHECK(!queue.add(waiting_handshake(i + 1, left[i])));
  CHECK(queue.remove(5));
  CHECK_FALSE(queue.remove(5));
  for (const std::uint64_t id : {2U, 3U, 1U, 4U}) CHECK(id_or_0(queue.take(kSomeTime)) == id);
  CHECK(queue.empty());
}

TEST_CASE("handshake queue: when it is full, the oldest of those with the least left gives way") {
  HandshakeQueue queue(1000, 2, kSomeTime);
  CHECK(!queue.add(waiting_handshake(1, 5)));
  CHECK(!queue.add(waiting_handshake(2, 0)));
  CHECK(id_or_0(queue.add(waiting_handshake(3, 7))) == 2);
  CHECK(id_or_0(queue.add(waiting_handshake(4, 0))) == 4);
  CHECK(id_or_0(queue.add(waiting_handshake(5, 5))) == 1);
  for (const std::uint64_t id : {3U, 5U, 0U}) CHECK(id_or_0(queue.take(kSomeTime)) == id);
}

TEST_CASE("handshake queue: the rate of all") {
  HandshakeQueue queue(2, 10, kSomeTime);
  for (const std::uint64_t id : {1U, 2U, 3U}) CHECK(!queue.add(waiting_handshake(id, 1)));
  CHECK(id_or_0(queue.take(kSomeTime)) == 1);
  CHECK(!queue.take(kSomeTime));
  CHECK(queue.wait().count() == doctest::Approx(0.5));
  CHECK_FALSE(queue.empty());
  CHECK(id_or_0(queue.take(kSomeTime + std::chrono::milliseconds(501))) == 2);
  CHECK(!queue.take(kSomeTime + std::chrono::milliseconds(502)));
  queue.give_back();
  CHECK(id_or_0(queue.take(kSomeTime + std::chrono::milliseconds(502))) == 3);
}

TEST_CASE("handshakes: the costly step is taken on another thread, and not for a client that has gone") {
  auto ends = connected_ends();
  std::atomic<int> run{0}, abandoned{0};
  std::atomic<bool> elsewhere{false};
  Handshakes handshakes(of_one_handshake_thread());
  const auto count = [&, here = std::this_thread::get_id()](Handshake::Turn turn) {
    elsewhere = std::this_thread::get_id() != here;
    ++(turn == Handshake::Turn::run ? run : abandoned);
  };
  handshakes.offer({1, ends[0].get(), 0, count});
  CHECK(eventually([&] { return run == 1; }));
  CHECK(elsewhere.load());
  ends[1].close();
  handshakes.offer({2, ends[0].get(), 0, count});
  CHECK(eventually([&] { return abandoned == 1; }));
  CHECK(run == 1);
  CHECK(handshakes.counts().begun == 1);
  CHECK(handshakes.counts().abandoned == 1);
  CHECK(handshakes.counts().refused == 0);
}

TEST_CASE("handshakes: what waits can be withdrawn, and is refused where others go first") {
  const auto ends = connected_ends();
  std::atomic<bool> busy{false}, released{false};
  std::atomic<int> run{0}, refused{0};
  Handshakes handshakes(of_one_handshake_thread());
  const auto count = [&](Handshake::Turn turn) { ++(turn == Handshake::Turn::run ? run : refused); };
  handshakes.offer({1, ends[0].get(), 0, [&](Handshake::Turn) {
                      busy = true;
                      while (!released) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                    }});
  REQUIRE(eventually([&] { return busy.load(); }));
  for (std::uint64_t i = 0; i < Handshakes::kMostWaiting; ++i) handshakes.offer({100 + i, ends[0].get(), 1, count});
  CHECK(refused == 0);
  handshakes.offer({10, ends[0].get(), 9, count});  // in place of the oldest
  CHECK(refused == 1);
  handshakes.offer({11, ends[0].get(), 0, count});  // itself
  CHECK(refused == 2);
  CHECK(handshakes.withdraw(10));
  CHECK_FALSE(handshakes.withdraw(10));
  CHECK_FALSE(handshakes.withdraw(100));
  CHECK_FALSE(handshakes.withdraw(1));
  CHECK(run == 0);
  released = true;
  CHECK(eventually([&] { return run == static_cast<int>(Handshakes::kMostWaiting) - 1; }));
  CHECK(handshakes.counts().refused == 3);  // with the one that was withdrawn
}

TEST_CASE("handshakes: clients that have gone take nothing of the rate of all") {
  Settings settings = of_one_handshake_thread();
  settings.max_handshakes_per_second = 1;
  auto gone = connected_ends();
  const auto there = connected_ends();
  std::atomic<int> run{0};
  Handshakes handshakes(settings);
  const auto count = [&](Handshake::Turn turn) { run += turn == Handshake::Turn::run ? 1 : 0; };
  gone[1].close();
  for (std::uint64_t i = 0; i < 200; ++i) handshakes.offer({i, gone[0].get(), 1, count});
  handshakes.offer({200, there[0].get(), 0, count});
  CHECK(eventually([&] { return run == 1; }));
  CHECK(handshakes.counts().abandoned == 200);
}

TEST_CASE("handshakes: an address that has none left is refused and counted") {
  Settings settings = of_one_handshake_thread();
  settings.max_handshakes_per_second_per_peer = 1;
  Handshakes handshakes(settings);
  std::uint64_t admitted = 0;
  for (int i = 0; i < 1000; ++i) admitted += handshakes.admit("a") ? 1U : 0U;
  CHECK(admitted >= 5);
  CHECK(handshakes.counts().refused == 1000 - admitted);
  CHECK(handshakes.admit("b").has_value());
}
