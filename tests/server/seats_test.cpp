#include "server/seats.h"

#include <vector>

#include <doctest/doctest.h>

using meshgauge::server::Seats;

TEST_CASE("seats: so many, half of them for one key, all without keys") {
  Seats seats(4);
  std::vector<std::shared_ptr<const void>> held;
  for (int i = 0; i < 2; ++i) held.push_back(seats.take("one"));
  CHECK(seats.take("one") == nullptr);
  for (int i = 0; i < 2; ++i) held.push_back(seats.take("two"));
  for (const auto& seat : held) CHECK(seat != nullptr);
  CHECK(seats.take("three") == nullptr);
  CHECK(seats.taken() == 4);
  held.erase(held.begin());
  CHECK(seats.take("two") == nullptr);
  CHECK(seats.take("three") != nullptr);
  held.clear();
  CHECK(seats.taken() == 0);
  for (int i = 0; i < 4; ++i) held.push_back(seats.take(""));
  CHECK(held.back() != nullptr);
  CHECK(seats.take("") == nullptr);
}
