#include "check/remote/client.h"

#include <set>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::check::service;
using net::Trouble;
using namespace std::chrono_literals;

namespace {

constexpr Retries::Clock::time_point kStart{};

net::HttpAnswer lost(Trouble trouble = Trouble::broken) {
  net::HttpAnswer answer;
  answer.trouble = trouble;
  return answer;
}

net::HttpAnswer refused(int status, std::optional<std::chrono::seconds> after = {}) {
  net::HttpAnswer answer;
  answer.status = status;
  answer.retry_after = after;
  return answer;
}

}  // namespace

TEST_CASE("retry: only transient failures are retried") {
  const std::set<int> may_pass{408, 429, 500, 502, 503, 504, 507};
  for (int status = 200; status < 600; ++status) {
    CAPTURE(status);
    CHECK(Retries(1h, 1h).after(refused(status), true, kStart, 0).has_value() == may_pass.contains(status));
  }
  CHECK(retried_statuses().size() == may_pass.size());
  CHECK(Retries(1h, 1h).after(lost(Trouble::no_contact), true, kStart, 0));
  CHECK(Retries(1h, 1h).after(lost(Trouble::broken), true, kStart, 0));
  CHECK_FALSE(Retries(1h, 1h).after(lost(Trouble::hopeless), true, kStart, 0));
  CHECK_FALSE(Retries(1h, 1h).after(lost(Trouble::cancelled), true, kStart, 0));
}

TEST_CASE("retry: the pause doubles up to its cap") {
  Retries retries(1h, 1h);
  for (const auto expected : {100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 6400ms, 7500ms, 7500ms}) {
    CHECK(retries.after(lost(), true, kStart, 0) == expected);
  }
  Retries largest(1h, 1h);
  for (const auto expected : {200ms, 400ms, 800ms}) CHECK(largest.after(lost(), true, kStart, 1) == expected);
  for (int i = 0; i < 100; ++i) CHECK(largest.after(lost(), true, kStart, 1) <= Retries::kMost);
}

TEST_CASE("retry: Retry-After is respected") {
  Retries retries(1h, 1h);
  CHECK(retries.after(refused(503, 7s), true, kStart, 0) == 7s);
  CHECK(retries.after(refused(429, 60s), true, kStart, 0) == 60s);
  for (int i = 0; i < 10; ++i) (void)retries.after(refused(429, 1s), true, kStart, 0);
  CHECK(retries.after(refused(429, 1s), true, kStart, 0) == 7500ms);  // the pause has grown beyond it
}

TEST_CASE("retry: retries end after the retry time") {
  Retries retries(10s, 2s);
  CHECK(retries.after(lost(), true, kStart, 0));
  CHECK(retries.after(lost(), true, kStart + 9s, 0));
  CHECK_FALSE(retries.after(lost(), true, kStart + 10s, 0));
  CHECK_FALSE(Retries(10s, 2s).after(refused(503, 11s), true, kStart, 0));  // it would be over before
  CHECK_FALSE(Retries(10s, 2s).after(refused(503, 86400s), true, kStart, 0));
}

TEST_CASE("retry: a service that was never reached has a shorter time") {
  Retries retries(1h, 2s);
  CHECK(retries.after(lost(Trouble::no_contact), false, kStart, 0));
  CHECK_FALSE(retries.after(lost(Trouble::no_contact), false, kStart + 2s, 0));
  CHECK(retries.after(lost(Trouble::no_contact), true, kStart + 2s, 0));
}

TEST_CASE("retry: the time counts from the first failure") {
  Retries retries(10s, 10s);
  CHECK(retries.after(lost(), true, kStart + 1h, 0));
  CHECK(retries.after(lost(), true, kStart + 1h + 5s, 0));
}

TEST_CASE("retry: rarely transient failures are retried a few times") {
  for (const RetriedStatus& row : retried_statuses()) {
    CAPTURE(row.status);
    Retries retries(24h, 24h);
    int tries = 1;
    while (tries < 100 && retries.after(refused(row.status), true, kStart, 0)) ++tries;
    CHECK(tries == (row.tries ? row.tries : 100));
  }
}
