#include "cli/mcp/calls.h"

#include <atomic>
#include <chrono>
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
void spin(Control& control) {
  while (!control.cancelled()) std::this_thread::yield();
}

}  // namespace

TEST_CASE("calls: they run beside each other, and a free id may be used again") {
  std::atomic<int> ran{0};
  Calls calls(2, kMost);
  for (int i = 0; i < 100; ++i) {
    const std::string id = std::to_string(i % 2);
    while (calls.begin(id, 1, [&](Control&) { ++ran; }) != Calls::Begun::yes) std::this_thread::yield();
  }
  CHECK(eventually([&] { return ran == 100; }));
}

TEST_CASE("calls: an id that is in use, too many calls and too many bytes are refused") {
  Calls calls(1, kMost);
  CHECK(calls.begin("a", 40, spin) == Calls::Begun::yes);
  CHECK(calls.begin("a", 1, spin) == Calls::Begun::same_id);
  CHECK(calls.begin("b", 61, spin) == Calls::Begun::too_many);
  CHECK(calls.begin("b", 60, spin) == Calls::Begun::yes);
  CHECK(calls.begin("c", 1, spin) == Calls::Begun::too_many);
  CHECK(calls.begin("c", 0, spin) == Calls::Begun::yes);
  CHECK(calls.begin("d", 0, spin) == Calls::Begun::too_many);
  calls.cancel("a");  // its room is free when it has ended
  CHECK(eventually([&] { return calls.begin("d", 40, spin) == Calls::Begun::yes; }));
}

TEST_CASE("calls: one that is cancelled while it waits does not begin") {
  std::atomic<bool> ran{false};
  Calls calls(1, kMost);
  calls.begin("a", 1, spin);
  calls.begin("b", 1, [&](Control&) { ran = true; });
  calls.cancel("b");
  calls.cancel("none");
  calls.cancel("a");
  CHECK(eventually([&] { return calls.begin("b", 1, spin) == Calls::Begun::yes; }));
  CHECK_FALSE(ran);
}

TEST_CASE("calls: at the end all are cancelled, and what does not end is not waited for") {
  std::atomic<bool> go_on{false}, ran{false};
  Calls calls(1, kMost);
  calls.begin("stubborn", 1, [&](Control&) {
    while (!go_on) std::this_thread::yield();
  });
  calls.begin("later", 1, [&](Control&) { ran = true; });
  CHECK(eventually([&] { return calls.running() == 1; }));
  CHECK_FALSE(calls.end(std::chrono::milliseconds(1)));
  go_on = true;
  CHECK(calls.end(kLong));
  CHECK_FALSE(ran);
}

TEST_CASE("calls: without threads begin() runs them") {
  bool ran = false;
  Calls calls(0, kMost);
  CHECK(calls.begin("a", 1, [&](Control&) { ran = calls.running() == 1; }) == Calls::Begun::yes);
  CHECK(ran);
  CHECK(calls.running() == 0);
  CHECK(calls.end(kLong));
}
