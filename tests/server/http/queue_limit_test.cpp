#include "server/http/queue_limit.h"

#include <doctest/doctest.h>

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

TEST_CASE("patience: a burst may fill the queue, one that stands is cut short until it was empty") {
  Patience patience(80);
  const auto start = Patience::Clock::now();
  CHECK(patience.limit(0, start) == 80);
  CHECK(patience.limit(70, start + Patience::kBurst) == 80);
  CHECK(patience.limit(11, start + Patience::kBurst + milliseconds(1)) == 11);
  CHECK(patience.limit(1, start + milliseconds(5000)) == 11);
  CHECK(patience.limit(0, start + milliseconds(5001)) == 80);
  CHECK(patience.limit(79, start + milliseconds(5050)) == 80);
}

TEST_CASE("patience: never more than there may be, and after an idle hour as at the start") {
  for (const std::size_t most : {0U, 1U, 2U}) {
    Patience patience(most);
    const auto start = Patience::Clock::now();
    CHECK(patience.limit(1, start) <= most);
    CHECK(patience.limit(0, start + std::chrono::hours(1)) == most);
  }
}

}  // namespace
}  // namespace meshgauge::server
