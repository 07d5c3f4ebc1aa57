// Workers that do harm, each time with a look whether the next file is read. A test that cancels waits for what it
// cancelled: none depends on how fast the machine is.
#include <signal.h>

#include <algorithm>

#include "server/sandbox/sandbox.h"

using namespace meshgauge;
using namespace meshgauge::server;
using namespace meshgauge::server::sandbox;

using std::chrono::milliseconds;

TEST_CASE("hostile: an abnormal end fails that reading only") {
  Sandbox sandbox;
  sandbox.start();
  std::uint64_t crashed = 0;
  for (const std::string_view misdeed : {"crash", "stop", "leave"}) {
    check_refused(sandbox.read(misdeed), ErrorCode::unreadable_mesh);
    CHECK(sandbox.pool.counters()[End::crashed] == ++crashed);
    CHECK(sandbox.works());
  }
  CHECK(sandbox.logged().find("the reader of 'a' ended with exit code 0\n") != std::string::npos);
  if (!kSanitized) CHECK(sandbox.logged().find("was ended by signal 11 (") != std::string::npos);
}

TEST_CASE("hostile: a forbidden system call kills the worker" * doctest::skip(kSanitized)) {
  Sandbox sandbox;
  const auto lacks = sandbox.pool.start();
  REQUIRE(lacks.ok());
  REQUIRE(lacks->empty());
  std::uint64_t crashed = 0;
  for (const std::string_view misdeed :
       {"open file", "open socket", "start process", "run program", "kill parent", "write log", "make code",
        "make code of window", "write input", "write file", "shorten window", "outlive parent"}) {
    CAPTURE(misdeed);
    check_refused(sandbox.read(misdeed), ErrorCode::unreadable_mesh);
    CHECK(sandbox.pool.counters()[End::crashed] == ++crashed);
    CHECK(sandbox.works());
  }
  std::string expected;
  for (; crashed > 0; --crashed) expected += "the reader of 'a' was ended by signal 31 (Bad system call)\n";
  CHECK(sandbox.logged() == expected);
}

TEST_CASE("hostile: an endless reading blocks no other and ends when it is cancelled or late") {
  Sandbox sandbox;
  sandbox.start();
  Endless endless(sandbox);
  REQUIRE(eventually([] { return !running().empty(); }));
  for (int i = 0; i < 5; ++i) CHECK(sandbox.works());
  endless.control().cancel();
  const auto cancelled = endless.result();
  REQUIRE(!cancelled.ok());
  CHECK(cancelled.error().code == ErrorCode::out_of_time);
  CHECK(cancelled.error().message == "cancelled before 'a' was read");

  Control late(Control::Clock::now() + milliseconds(100));
  CHECK(sandbox.read("loop", late).error().message == "timed out before 'a' was read");
  CHECK(eventually([] { return running().empty(); }));
  CHECK(sandbox.pool.counters()[End::cancelled] == 1);
  CHECK(sandbox.pool.counters()[End::overdue] == 1);
  CHECK(sandbox.works());
}

TEST_CASE("hostile: idle workers that are killed fail no reading") {
  Sandbox sandbox;
  sandbox.start();
  REQUIRE(eventually([] { return workers().size() == 2; }));
  for (const Process& worker : workers()) ::kill(worker.pid, SIGKILL);
  REQUIRE(eventually([] { return workers().empty(); }));
  CHECK(sandbox.works());
}

TEST_CASE("hostile: a reading that uses up its processor time counts as crashed") {
  Sandbox sandbox({hostile_program()}, 1, 1);
  sandbox.start();
  check_refused(sandbox.read("loop"), ErrorCode::unreadable_mesh);
  CHECK(sandbox.pool.counters()[End::crashed] == 1);
  CHECK(sandbox.logged().find("was ended by signal 24 (") != std::string::npos);
  CHECK(sandbox.works());
}

TEST_CASE("hostile: no process has a capability") {
  Sandbox sandbox;
  sandbox.start();
  REQUIRE(eventually([] { return workers().size() == 2; }));
  auto all = workers();
  all.push_back(spawners().front());
  constexpr unsigned long long kMayReduceBounds = 1ULL << 8;  // CAP_SETPCAP
  const bool all_bounds = (std::stoull(status_line(::getpid(), "CapEff"), nullptr, 16) & kMayReduceBounds) != 0;
  for (const Process& process : all) {
    for (const std::string set : {"CapInh", "CapPrm", "CapEff", "CapAmb", "CapBnd"}) {
      CAPTURE(set);
      if (set != "CapBnd" || all_bounds) CHECK(status_line(process.pid, set) == "0000000000000000");
    }
  }
  CHECK(sandbox.works());
}

TEST_CASE("hostile: memory is limited, in one piece and in many" * doctest::skip(kSanitized)) {
  Sandbox sandbox;
  sandbox.start();
  check_refused(sandbox.read("greedy"), ErrorCode::too_large);
  CHECK(sandbox.pool.counters()[End::out_of_memory] == 1);
  const auto hoarded = sandbox.read("hoard");
  REQUIRE(!hoarded.ok());
  const int taken_mib = std::stoi(hoarded.error().message);
  CHECK(taken_mib > 0);
  CHECK(taken_mib < static_cast<int>(kMemoryMiB));
  CHECK(sandbox.pool.counters()[End::failed] == 1);  // what a reader says of itself, not of the file
  CHECK(sandbox.logged().ends_with("the reader of 'a' failed: " + hoarded.error().message + "\n"));
  CHECK(sandbox.works());
}

TEST_CASE("hostile: an untrue reply is refused") {
  Sandbox sandbox;
  sandbox.start();
  std::uint64_t untrue = 0;
  for (const std::string_view lie :
       {"wrong index", "not finite", "no triangles", "nothing", "too many", "overflow", "format", "error code",
        "out of time", "bad request", "rubbish", "long message", "wrong groups", "far too long groups"}) {
    CAPTURE(lie);
    check_refused(sandbox.read(lie), ErrorCode::unreadable_mesh);
    CHECK(sandbox.pool.counters()[End::untrue] == ++untrue);
    CHECK(sandbox.works());
  }
  check_refused(sandbox.read("too few and gone"), ErrorCode::unreadable_mesh);
  Control late(Control::Clock::now() + milliseconds(50));
  CHECK(sandbox.read("too few", late).error().code == ErrorCode::out_of_time);
  CHECK(sandbox.read("many messages").ok());  // the first was true
  const auto blamed = sandbox.read("other part");
  REQUIRE(!blamed.ok());
  CHECK(blamed.error().part == "a");
  CHECK(sandbox.works());
}

TEST_CASE("hostile: descriptors sent with a reply are not accepted") {
  Sandbox sandbox;
  sandbox.start();
  REQUIRE(sandbox.works());
  const std::size_t before = open_files();
  for (int i = 0; i < 10; ++i) CHECK(sandbox.read("descriptors").ok());
  CHECK(eventually([before] { return open_files() <= before; }));
}

TEST_CASE("hostile: a worker cannot change arrays that were copied") {
  Sandbox sandbox;
  sandbox.start();
  for (int i = 0; i < 50; ++i) {
    const auto mesh = sandbox.read("scribble");
    if (!mesh) {
      check_refused(mesh, ErrorCode::unreadable_mesh);  // some of the scribble was copied, and found to be no mesh
      continue;
    }
    const Vec3 position = mesh->mesh.positions[1];
    const Triangle triangle = mesh->mesh.triangles[0];
    CHECK(validate(mesh->mesh, {}, "a").ok());
    std::this_thread::sleep_for(milliseconds(1));
    CHECK(mesh->mesh.positions[1] == position);
    CHECK(mesh->mesh.triangles[0] == triangle);
  }
  CHECK(sandbox.works());
}

TEST_CASE("hostile: no process or descriptor is left over") {
  std::size_t before = 0;
  {
    Sandbox sandbox;
    sandbox.start();
    REQUIRE(sandbox.works());
    before = open_files();
    for (int i = 0; i < 10; ++i) {
      for (const std::string_view file : {"crash", "leave", "rubbish", "too few and gone", "other part"}) {
        CHECK(!sandbox.read(file).ok());
      }
      Control late(Control::Clock::now());
      CHECK(!sandbox.read("loop", late).ok());
    }
    CHECK(open_files() == before);
    // The two that wait; none that has ended and was not asked for.
    CHECK(eventually([] {
      const auto all = workers();
      return all.size() == 2 && std::ranges::none_of(all, [](const Process& p) { return p.state == 'Z'; });
    }));
    CHECK(sandbox.pool.counters().started >= 61);
  }
  CHECK(spawners().empty());
  CHECK(open_files() < before);
}

TEST_CASE("hostile: many at a time") {
  Sandbox sandbox;
  sandbox.start();
  std::vector<std::future<bool>> readings;
  readings.reserve(8);
  for (int i = 0; i < 8; ++i) {
    readings.push_back(std::async(std::launch::async, [&sandbox, i] {
      bool well = true;
      for (int k = 0; k < 10; ++k) well = well && (i % 2 == 0 ? sandbox.works() : !sandbox.read("crash").ok());
      return well;
    }));
  }
  for (auto& reading : readings) CHECK(reading.get());
  CHECK(sandbox.pool.counters()[End::read] == 40);
  CHECK(sandbox.pool.counters()[End::crashed] == 40);
}

TEST_CASE("hostile: without the filter the start reports it, and the other limits hold") {
  Sandbox sandbox({beside_this_program("without"), "seccomp", hostile_program()});
  const auto lacks = sandbox.pool.start();
  REQUIRE(lacks.ok());
  REQUIRE(lacks->size() == 1);
  CHECK(lacks->front().starts_with("seccomp is not in force: "));
  CHECK(sandbox.works());
  check_refused(sandbox.read("crash"), ErrorCode::unreadable_mesh);
  Control late(Control::Clock::now() + milliseconds(100));
  CHECK(sandbox.read("close and live", late).error().code == ErrorCode::out_of_time);
  CHECK(sandbox.pool.counters()[End::overdue] == 1);
  CHECK(eventually([] { return running().empty(); }));
  if (!kSanitized) {
    CHECK(std::stoi(sandbox.read("hoard").error().message) < static_cast<int>(kMemoryMiB));
  }
  for (int i = 0; i < 10; ++i) {
    const auto mesh = sandbox.read("shorten for ever");  // the seal holds
    REQUIRE(mesh.ok());
    CHECK(mesh->mesh.positions[1] == Vec3(1, 0, 0));
  }
  CHECK(sandbox.works());
}
