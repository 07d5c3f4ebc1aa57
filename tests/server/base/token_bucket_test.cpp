#include "server/base/token_bucket.h"

#include <chrono>

#include <doctest/doctest.h>

using meshgauge::server::TokenBucket;

TEST_CASE("token bucket: a burst at once, then the rate") {
  const TokenBucket::Time start{std::chrono::hours(1)};
  TokenBucket bucket(10, 3, start);
  CHECK(bucket.is_full(start));
  for (int i = 0; i < 3; ++i) CHECK(bucket.take(start));
  CHECK(bucket.level() == 0);
  CHECK_FALSE(bucket.take(start));
  CHECK(bucket.wait().count() == doctest::Approx(0.1));
  CHECK_FALSE(bucket.take(start + std::chrono::milliseconds(99)));
  CHECK(bucket.take(start + std::chrono::milliseconds(101)));
  CHECK_FALSE(bucket.take(start + std::chrono::milliseconds(102)));
  int taken = 0;
  for (int ms = 102; ms < 10'102; ++ms) taken += bucket.take(start + std::chrono::milliseconds(ms)) ? 1 : 0;
  CHECK(taken >= 99);
  CHECK(taken <= 100);
}

TEST_CASE("token bucket: a pause fills it, and no more than that") {
  const TokenBucket::Time start{std::chrono::hours(1)};
  TokenBucket bucket(1, 2, start);
  CHECK(bucket.take(start));
  CHECK_FALSE(bucket.is_full(start + std::chrono::milliseconds(999)));
  CHECK(bucket.is_full(start + std::chrono::milliseconds(1001)));
  const auto later = start + std::chrono::hours(1);
  CHECK(bucket.take(later));
  CHECK(bucket.take(later));
  CHECK_FALSE(bucket.take(later));
}

TEST_CASE("token bucket: a change of the rate leaves what was used") {
  const TokenBucket::Time start{std::chrono::hours(1)};
  TokenBucket bucket(1, 10, start);
  for (int i = 0; i < 4; ++i) CHECK(bucket.take(start));
  bucket.change(100, 5, start);
  for (int i = 0; i < 5; ++i) CHECK(bucket.take(start));
  CHECK_FALSE(bucket.take(start));
  CHECK(bucket.take(start + std::chrono::milliseconds(11)));
}
