#include "cli/mcp/calls.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <new>
#include <string>
#include <thread>

#include <doctest/doctest.h>

#include "eventually.h"

using namespace meshgauge;
using namespace meshgauge::mcp;

namespace {

constexpr Calls::Most kMost{3, 100};
constexpr std::chrono::minutes kLong{1};

// Runs until it is cancelled.
std::string spin(Control& control) {
  while (!control.cancelled()) std::this_thread::yield();
  return "not sent";
}

// For calls that have no answer.
void unwanted(const std::string& answer) { FAIL_CHECK(answer); }

bool runs(const Calls& calls, std::size_t number) {
  return eventually([&] { return calls.running() == number; });
}

}  // namespace

TEST_CASE("calls: when an answer is there, its id and its room are free") {
  std::atomic<int> sent{0};
  Calls calls(1, {1, 100}, [&](const std::string&) { ++sent; });
  for (int i = 1; i <= 100; ++i) {
    REQUIRE(calls.begin("x", 100, [](Control&) { return std::string("answer"); }) == Calls::Begun::yes);
    REQUIRE(eventually([&] { return sent == i; }));
  }
}

TEST_CASE("calls: they run beside each other") {
  std::atomic<int> ran{0}, sent{0};
  Calls calls(2, kMost, [&](const std::string&) { ++sent; });
  for (const char* id : {"a", "b"}) {
    calls.begin(id, 1, [&](Control&) {
      ++ran;
      while (ran < 2) std::this_thread::yield();
      return std::string("answer");
    });
  }
  CHECK(eventually([&] { return sent == 2; }));
}

TEST_CASE("calls: an id that is in use, too many calls and too many bytes are refused") {
  Calls calls(1, kMost, unwanted);
  CHECK(calls.begin("a", 40, spin) == Calls::Begun::yes);
  CHECK(calls.begin("a", 1, spin) == Calls::Begun::same_id);
  CHECK(calls.begin("b", 61, spin) == Calls::Begun::too_many);
  CHECK(calls.begin("b", 60, spin) == Calls::Begun::yes);
  CHECK(calls.begin("c", 1, spin) == Calls::Begun::too_many);
  CHECK(calls.begin("c", 0, spin) == Calls::Begun::yes);
  CHECK(calls.begin("d", 0, spin) == Calls::Begun::too_many);
  REQUIRE(runs(calls, 1));
  calls.cancel("a");  // its room is free when it has ended
  CHECK(eventually([&] { return calls.begin("d", 40, spin) == Calls::Begun::yes; }));
}

TEST_CASE("calls: one that is cancelled while it waits does not begin, and its room is free at once") {
  std::atomic<bool> ran{false};
  Calls calls(1, kMost, unwanted);
  calls.begin("a", 1, spin);
  REQUIRE(runs(calls, 1));
  calls.begin("b", 99, [&](Control&) {
    ran = true;
    return std::string();
  });
  calls.cancel("b");
  calls.cancel("none");
  CHECK(calls.begin("b", 99, spin) == Calls::Begun::yes);
  calls.cancel("a");
  CHECK(eventually([&] { return calls.begin("a", 1, spin) == Calls::Begun::yes; }));
  CHECK_FALSE(ran);
}

TEST_CASE("calls: what throws has no answer, and others go on") {
  std::atomic<int> sent{0};
  Calls calls(1, kMost, [&](const std::string&) { ++sent; });
  calls.begin("a", 1, [](Control&) -> std::string { throw std::bad_alloc(); });
  calls.begin("b", 1, [](Control&) { return std::string("answer"); });
  CHECK(eventually([&] { return sent == 1; }));
  CHECK(eventually([&] { return calls.begin("a", 1, spin) == Calls::Begun::yes; }));
}

TEST_CASE("calls: at the end all are cancelled, and what does not end is not waited for") {
  std::atomic<bool> go_on{false}, ran{false};
  Calls calls(1, kMost, unwanted);
  calls.begin("stubborn", 1, [&](Control&) {
    while (!go_on) std::this_thread::yield();
    return std::string("not sent");
  });
  calls.begin("later", 1, [&](Control&) {
    ran = true;
    return std::string();
  });
  CHECK(eventually([&] { return calls.running() == 1; }));
  CHECK_FALSE(calls.end(std::chrono::milliseconds(1)));
  go_on = true;
  CHECK(calls.end(kLong));
  CHECK_FALSE(ran);
}

TEST_CASE("calls: without threads begin() runs them") {
  std::string sent;
  Calls calls(0, kMost, [&](const std::string& answer) { sent = answer; });
  const auto begun = calls.begin("a", 1, [&](Control&) { return std::to_string(calls.running()); });
  CHECK(begun == Calls::Begun::yes);
  CHECK(sent == "1");
  CHECK(calls.running() == 0);
  CHECK(calls.end(kLong));
}
