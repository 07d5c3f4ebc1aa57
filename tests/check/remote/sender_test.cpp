#include "check/remote/sender.h"

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using check::service::LazyMap;

namespace {

const Error kError{ErrorCode::internal, "it failed", "", ""};

}  // namespace

TEST_CASE("lazy map: one thread computes a value for all") {
  LazyMap<int> map;
  std::atomic<int> made{0}, right{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      Control control;
      const auto found = map.get("x", control, [&]() -> Result<int> {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return ++made * 7;
      });
      if (found && *found == 7) ++right;
    });
  }
  for (auto& thread : threads) thread.join();
  CHECK(made == 1);
  CHECK(right == 8);
}

TEST_CASE("lazy map: after an error or an exception the next caller tries again") {
  LazyMap<int> map;
  Control control;
  CHECK_FALSE(map.get("x", control, []() -> Result<int> { return kError; }).ok());
  CHECK_THROWS((void)map.get("x", control, []() -> Result<int> { throw std::runtime_error("thrown"); }));
  const auto found = map.get("x", control, []() -> Result<int> { return 5; });
  REQUIRE(found.ok());
  CHECK(*found == 5);
}

TEST_CASE("lazy map: each name has its value, computed again after forget_all()") {
  LazyMap<int> map;
  Control control;
  int made = 0;
  const auto make = [&]() -> Result<int> { return ++made; };
  CHECK(*map.get("x", control, make) == 1);
  CHECK(*map.get("y", control, make) == 2);
  CHECK(*map.get("x", control, make) == 1);
  map.forget_all();
  CHECK(*map.get("x", control, make) == 3);
  CHECK(*map.get("y", control, make) == 4);
}

TEST_CASE("lazy map: a waiting thread can be cancelled") {
  LazyMap<int> map;
  Control patient, hurried;
  hurried.cancel();
  bool ended = false;
  const auto outer = map.get("x", patient, [&]() -> Result<int> {
    std::thread waiting([&] {
      const auto found = map.get("x", hurried, []() -> Result<int> { return 1; });
      ended = !found && found.error().code == ErrorCode::out_of_time;
    });
    waiting.join();  // would wait for ever if it could not be cancelled
    return 2;
  });
  CHECK(ended);
  CHECK(*outer == 2);
}
