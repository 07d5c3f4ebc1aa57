#include "server/store/s3/owner_sums.h"

#include <atomic>
#include <new>
#include <thread>

#include <doctest/doctest.h>

#include "tests/server/store/store_text.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;

namespace {}  // namespace

TEST_CASE("sums of owners: listed once, then kept up") {
  std::atomic<int> listings{0};
  OwnerSums sums([&](const std::string& owner) -> Result<std::uint64_t> {
    ++listings;
    return owner == "ann" ? 100 : 7;
  });
  sums.add("ann", 5);  // the next listing has it
  CHECK(got(sums.of("ann")) == 100);
  sums.add("ann", 20);
  sums.remove("ann", 50);
  CHECK(got(sums.of("ann")) == 70);
  CHECK(got(sums.of("bob")) == 7);
  sums.remove("bob", 8);
  CHECK(got(sums.of("bob")) == 0);
  CHECK(listings == 2);
}

TEST_CASE("sums of owners: a failed listing is repeated") {
  std::atomic<bool> down{true};
  OwnerSums sums([&](const std::string&) -> Result<std::uint64_t> {
    if (down) return Error{ErrorCode::storage_unavailable, "down", "", ""};
    return 3;
  });
  CHECK_FALSE(sums.of("ann").ok());
  down = false;
  CHECK(got(sums.of("ann")) == 3);
}

TEST_CASE("sums of owners: a listing that throws blocks neither waiting nor later calls") {
  std::atomic<int> listings{0};
  OwnerSums sums(
      [&](const std::string&) -> Result<std::uint64_t> {
        const int listing = ++listings;
        if (listing == 1 || listing == 3) throw std::bad_alloc();
        return static_cast<std::uint64_t>(listing);
      },
      0ms);
  CHECK_FALSE(sums.of("ann").ok());
  CHECK(got(sums.of("ann")) == 2);
  std::uint64_t now = 2;
  while (now == 2) now = got(sums.of("ann"));  // after the third listing, which fails in the background
  CHECK(now >= 4);
}

TEST_CASE("sums of owners: an old sum is returned during a new listing, and puts meanwhile count") {
  std::atomic<bool> go_on{true};
  std::atomic<int> listings{0};
  OwnerSums sums(
      [&](const std::string&) -> Result<std::uint64_t> {
        ++listings;
        while (!go_on) std::this_thread::sleep_for(1ms);
        return listings == 1 ? 10 : 1000;
      },
      0ms);
  CHECK(got(sums.of("ann")) == 10);
  go_on = false;
  while (listings < 2) {
    const std::uint64_t now = got(sums.of("ann"));  // begins a listing at some time
    CHECK(now == 10);
  }
  sums.add("ann", 5);
  CHECK(got(sums.of("ann")) == 15);
  go_on = true;
  std::uint64_t now = 15;
  while (now == 15) now = got(sums.of("ann"));
  CHECK(now == 1005);
}
