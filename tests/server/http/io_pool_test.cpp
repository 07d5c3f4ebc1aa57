#include "server/http/io_pool.h"

#include <doctest/doctest.h>

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

TEST_CASE("queue limit: a burst may fill the queue, a standing queue is limited until it was empty") {
  QueueLimit limit(80);
  const auto start = QueueLimit::Clock::now();
  CHECK(limit.limit(0, start) == 80);
  CHECK(limit.limit(70, start + QueueLimit::kBurst) == 80);
  CHECK(limit.limit(11, start + QueueLimit::kBurst + milliseconds(1)) == 11);
  CHECK(limit.limit(1, start + milliseconds(5000)) == 11);
  CHECK(limit.limit(0, start + milliseconds(5001)) == 80);
  CHECK(limit.limit(79, start + milliseconds(5050)) == 80);
}

TEST_CASE("queue limit: never above the maximum, and reset after an idle hour") {
  for (const std::size_t most : {0U, 1U, 2U}) {
    QueueLimit limit(most);
    const auto start = QueueLimit::Clock::now();
    CHECK(limit.limit(1, start) <= most);
    CHECK(limit.limit(0, start + std::chrono::hours(1)) == most);
  }
}

}  // namespace
}  // namespace meshgauge::server
