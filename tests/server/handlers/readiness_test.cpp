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
  for (const auto& [part, text] : readiness.seen()) defects.push_back(std::string(part) + ": " + text);
  return defects;
}

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("readiness: what two parts say alike is said once") {
  Readiness readiness;
  readiness.watch("database", [] { return std::string("the database cannot be reached"); });
  readiness.watch("blobs", [] { return std::string("the database cannot be reached"); });
  readiness.watch("sandbox", [] { return std::string("no process"); });
  CHECK(defects_of(readiness) == Texts{"database: the database cannot be reached", "sandbox: no process"});
}

TEST_CASE("readiness: a look that throws has ended, and the next one may find all well") {
  std::atomic<int> asked{0};
  std::string told;
  Readiness readiness(60s);
  SUBCASE("an exception") {
    told = "service: it could not look";
    readiness.watch("store", [&] { return ++asked == 1 ? throw std::runtime_error("secret path") : std::string(); });
  }
  SUBCASE("for want of memory") {
    told = "service: memory ran out";
    readiness.watch("store", [&] { return ++asked == 1 ? throw std::bad_alloc() : std::string(); });
  }
  REQUIRE(defects_of(readiness) == Texts{told});
  while (!defects_of(readiness).empty()) std::this_thread::sleep_for(5ms);
  CHECK(asked == 2);
}

TEST_CASE("readiness: a part that does not answer is named, and asked no more before it does") {
  std::promise<void> let_go;
  std::atomic<int> asked{0};
  Readiness readiness(50ms);
  readiness.watch("store", [] { return std::string(); });
  readiness.watch("disk", [&, gone = let_go.get_future().share()] {
    if (++asked == 1) gone.wait();
    return std::string();
  });
  static_cast<void>(readiness.seen());  // its thread may still be on its way to the disk
  while (asked == 0) std::this_thread::sleep_for(1ms);
  for (int i = 0; i < 3; ++i) CHECK(defects_of(readiness) == Texts{"disk: it does not answer in time"});
  CHECK(asked == 1);
  let_go.set_value();
  while (!defects_of(readiness).empty()) std::this_thread::sleep_for(5ms);
}
