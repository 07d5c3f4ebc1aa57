#include "check/remote/once.h"

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using check::service::Once;

namespace {

const Error kError{ErrorCode::internal, "it failed", "", ""};

}  // namespace

TEST_CASE("once: made by one, had by all") {
  Once<int> once;
  std::atomic<int> made{0}, right{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      Control control;
      const auto found = once.get("x", control, [&]() -> Result<int> {
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

TEST_CASE("once: an error or an exception is its maker's alone") {
  Once<int> once;
  Control control;
  CHECK_FALSE(once.get("x", control, []() -> Result<int> { return kError; }).ok());
  CHECK_THROWS(once.get("x", control, []() -> Result<int> { throw std::runtime_error("thrown"); }));
  const auto found = once.get("x", control, []() -> Result<int> { return 5; });
  REQUIRE(found.ok());
  CHECK(*found == 5);
}

TEST_CASE("once: names are apart, and what is forgotten is made again") {
  Once<int> once;
  Control control;
  int made = 0;
  const auto make = [&]() -> Result<int> { return ++made; };
  CHECK(*once.get("x", control, make) == 1);
  CHECK(*once.get("y", control, make) == 2);
  CHECK(*once.get("x", control, make) == 1);
  once.forget("x");
  CHECK(*once.get("x", control, make) == 3);
}

TEST_CASE("once: who waits can be cancelled") {
  Once<int> once;
  Control patient, hurried;
  hurried.cancel();
  bool ended = false;
  const auto outer = once.get("x", patient, [&]() -> Result<int> {
    std::thread waiting([&] {
      const auto found = once.get("x", hurried, []() -> Result<int> { return 1; });
      ended = !found && found.error().code == ErrorCode::out_of_time;
    });
    waiting.join();  // would wait for ever for what this makes
    return 2;
  });
  CHECK(ended);
  CHECK(*outer == 2);
}
