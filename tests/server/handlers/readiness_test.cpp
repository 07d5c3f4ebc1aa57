#include "server/handlers/readiness.h"

#include <doctest/doctest.h>

#include <atomic>
#include <future>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

using namespace meshgauge::server;
using namespace std::chrono_literals;

namespace {

// As "PART: TEXT".
std::vector<std::string> defects_of(Readiness& readiness) {
  std::vector<std::string> defects;
  for (const auto& [part, text] : readiness.last_defects()) defects.push_back(std::string(part) + ": " + text);
  return defects;
}

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("readiness: a message that two parts share is reported once") {
  Readiness readiness;
  readiness.add_check("database", [] { return std::string("the database cannot be reached"); });
  readiness.add_check("blobs", [] { return std::string("the database cannot be reached"); });
  readiness.add_check("sandbox", [] { return std::string("no process"); });
  CHECK(defects_of(readiness) == Texts{"database: the database cannot be reached", "sandbox: no process"});
}

TEST_CASE("readiness: a check that throws counts as ended, and the next one may succeed") {
  std::atomic<int> checks{0};
  std::string expected;
  Readiness readiness(60s);
  SUBCASE("an exception") {
    expected = "service: a check failed unexpectedly";
    readiness.add_check("store",
                        [&] { return ++checks == 1 ? throw std::runtime_error("secret path") : std::string(); });
  }
  SUBCASE("out of memory") {
    expected = "service: out of memory during a check";
    readiness.add_check("store", [&] { return ++checks == 1 ? throw std::bad_alloc() : std::string(); });
  }
  REQUIRE(defects_of(readiness) == Texts{expected});
  while (!defects_of(readiness).empty()) std::this_thread::sleep_for(5ms);
  CHECK(checks == 2);
}

TEST_CASE("readiness: a part whose check hangs is named, and not checked again before it ends") {
  std::promise<void> release;
  std::atomic<int> checks{0};
  Readiness readiness(50ms);
  readiness.add_check("store", [] { return std::string(); });
  readiness.add_check("disk", [&, released = release.get_future().share()] {
    if (++checks == 1) released.wait();
    return std::string();
  });
  static_cast<void>(readiness.last_defects());  // its thread may still be on its way to the disk
  while (checks == 0) std::this_thread::sleep_for(1ms);
  for (int i = 0; i < 3; ++i)
    CHECK(defects_of(readiness) == Texts{"disk: the check of 'disk' did not end within 50 ms"});
  CHECK(checks == 1);
  release.set_value();
  while (!defects_of(readiness).empty()) std::this_thread::sleep_for(5ms);
}

TEST_CASE("readiness: one client waits for the checks, others are answered meanwhile") {
  std::promise<void> release;
  std::atomic<int> checks{0};
  Readiness readiness(1h);
  readiness.add_check("disk", [&, released = release.get_future().share()] {
    ++checks;
    released.wait();
    return std::string("full");
  });
  auto first = std::async(std::launch::async, [&] { return defects_of(readiness); });
  while (checks == 0) std::this_thread::sleep_for(1ms);
  CHECK(defects_of(readiness).empty());  // or it would wait for what only the next line ends
  release.set_value();
  CHECK(first.get() == Texts{"disk: full"});
}
