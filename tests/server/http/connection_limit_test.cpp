#include "server/http/connection_limit.h"

#include <vector>

#include <doctest/doctest.h>

using meshgauge::server::ConnectionLimit;

TEST_CASE("connection limit: half of the places for one key, all of them without keys") {
  ConnectionLimit limit = ConnectionLimit::shared(4);
  std::vector<std::shared_ptr<const void>> held;
  for (int i = 0; i < 2; ++i) held.push_back(limit.take("one"));
  CHECK(limit.take("one") == nullptr);
  for (int i = 0; i < 2; ++i) held.push_back(limit.take("two"));
  for (const auto& place : held) CHECK(place != nullptr);
  CHECK(limit.take("three") == nullptr);
  CHECK(limit.taken() == 4);
  held.erase(held.begin());
  CHECK(limit.take("two") == nullptr);
  CHECK(limit.take("three") != nullptr);
  held.clear();
  CHECK(limit.taken() == 0);
  for (int i = 0; i < 4; ++i) held.push_back(limit.take(""));
  CHECK(held.back() != nullptr);
  CHECK(limit.take("") == nullptr);
}

TEST_CASE("connection limit: an address gets a place back for each one it releases") {
  ConnectionLimit peers(2);
  auto first = peers.take("x");
  {
    const auto second = peers.take("x");
    CHECK(second);
    CHECK(!peers.take("x"));
    CHECK(peers.take("y"));
  }
  CHECK(peers.take("x"));
  const auto moved = std::move(first);
  const auto third = peers.take("x");
  CHECK(third);
  CHECK(!peers.take("x"));
}
