#include "check/remote/seats.h"

#include <doctest/doctest.h>

using meshgauge::Control;
using meshgauge::check::service::Seats;

namespace {

// A cancelled caller takes what is free and waits for nothing.
unsigned free_seats(Seats& seats) {
  Control hurried;
  hurried.cancel();
  unsigned free = 0;
  while (seats.take(hurried)) ++free;
  return free;
}

}  // namespace

TEST_CASE("seats: as many as there are") {
  Seats seats(3);
  CHECK(seats.most() == 3);
  CHECK(free_seats(seats) == 3);
  seats.give_back();
  CHECK(free_seats(seats) == 1);
  CHECK(Seats(0).most() == 1);
}

TEST_CASE("seats: one less than were taken after a refusal, and never none") {
  Seats seats(4);
  Control control;
  for (int i = 0; i < 3; ++i) REQUIRE(seats.take(control));
  seats.refused();
  seats.refused();  // of the same request, tried again
  CHECK(free_seats(seats) == 0);
  seats.give_back();
  CHECK(free_seats(seats) == 0);
  Seats last(4);
  REQUIRE(last.take(control));
  last.refused();
  CHECK(free_seats(last) == 0);
}

TEST_CASE("seats: they come back one by one while nothing is refused") {
  Seats seats(4);
  Control control;
  REQUIRE(seats.take(control));
  seats.refused();
  seats.give_back();  // one served with one seat: the second comes back
  REQUIRE(seats.take(control));
  REQUIRE(seats.take(control));
  CHECK(free_seats(seats) == 0);
  seats.give_back();
  CHECK(free_seats(seats) == 1);
  seats.give_back();  // two served with two seats: the third comes back
  CHECK(free_seats(seats) == 2);
}
