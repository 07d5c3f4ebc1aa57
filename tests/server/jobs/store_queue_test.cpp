#include "server/jobs/store_queue.h"

#include <doctest/doctest.h>

using namespace meshgauge;
using server::EndRate;
using server::store::Counts;

namespace {

Counts counts(std::uint64_t queued, std::uint64_t done, std::uint64_t failed = 0, std::uint64_t cancelled = 0) {
  Counts all;
  all.queued = queued;
  all.done = done;
  all.failed = failed;
  all.cancelled = cancelled;
  return all;
}

}  // namespace

TEST_CASE("store queue: the rate is of seconds in which jobs wait, and the first one counts fully") {
  EndRate rate;
  rate.learn(counts(0, 0), counts(0, 1), 1);
  rate.learn(counts(0, 1), counts(5, 1), 1);
  rate.learn(counts(5, 1), counts(0, 6), 1);
  CHECK_FALSE(rate.per_second().has_value());
  rate.learn(counts(90, 6), counts(80, 13, 2, 1), 2);
  CHECK(rate.per_second() == doctest::Approx(5));
  for (int i = 0; i < 100; ++i) rate.learn(counts(0, 16), counts(0, 16), 1);
  CHECK(rate.per_second() == doctest::Approx(5));
  rate.learn(counts(80, 1000), counts(80, 1), 1);  // a sweep
  rate.learn(counts(80, 1), counts(80, 2), 0);
  CHECK(rate.per_second() == doctest::Approx(5));
}

TEST_CASE("store queue: the rate follows the last readings") {
  EndRate rate;
  for (int i = 0; i < 10; ++i) rate.learn(counts(9, 0), counts(9, 100), 1);
  for (int i = 0; i < 30; ++i) rate.learn(counts(9, 0), counts(9, 1), 1);
  CHECK(*rate.per_second() < 1.5);
  CHECK(*rate.per_second() >= 1);
}
