#include "check/remote/adaptive_limit.h"

#include <doctest/doctest.h>

using meshgauge::Control;
using meshgauge::check::service::AdaptiveLimit;

namespace {

// A cancelled caller takes what is free and waits for nothing.
unsigned free_places(AdaptiveLimit& limit) {
  Control hurried;
  hurried.cancel();
  unsigned free = 0;
  while (limit.take(hurried)) ++free;
  return free;
}

}  // namespace

TEST_CASE("adaptive limit: starts with all places") {
  AdaptiveLimit limit(3);
  CHECK(limit.most() == 3);
  CHECK(free_places(limit) == 3);
  limit.give_back();
  CHECK(free_places(limit) == 1);
  CHECK(AdaptiveLimit(0).most() == 1);
}

TEST_CASE("adaptive limit: a refusal leaves one place less than were taken, at least one") {
  AdaptiveLimit limit(4);
  Control control;
  for (int i = 0; i < 3; ++i) REQUIRE(limit.take(control));
  limit.refused();
  limit.refused();  // of the same request, tried again
  CHECK(free_places(limit) == 0);
  limit.give_back();
  CHECK(free_places(limit) == 0);
  AdaptiveLimit last(4);
  REQUIRE(last.take(control));
  last.refused();
  CHECK(free_places(last) == 0);
}

TEST_CASE("adaptive limit: grows by one while nothing is refused") {
  AdaptiveLimit limit(4);
  Control control;
  REQUIRE(limit.take(control));
  limit.refused();
  limit.give_back();  // one served at a limit of one: the limit is two
  REQUIRE(limit.take(control));
  REQUIRE(limit.take(control));
  CHECK(free_places(limit) == 0);
  limit.give_back();
  CHECK(free_places(limit) == 1);
  limit.give_back();  // two served at a limit of two: the limit is three
  CHECK(free_places(limit) == 2);
}
