#include "server/sandbox/memory_budget.h"

#include <atomic>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "engine/mesh.h"
#include "tests/eventually.h"

using namespace meshgauge;
using server::bytes_of_mesh;
using server::MemoryBudget;
using server::MemoryReservation;

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

// One job on a thread of its own, that reserves `bytes` in one step, again and again until it has them.
class Job {
 public:
  Job(MemoryBudget& budget, std::uint64_t bytes) : thread_([this, &budget, bytes] { run(budget, bytes); }) {}
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;
  ~Job() { end(); }

  bool waits() const { return waits_.load(); }
  bool has() const { return has_.load(); }
  bool was_refused() const { return refused_.load(); }
  void cancel() { control_.cancel(); }
  void end() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(MemoryBudget& budget, std::uint64_t bytes) {
    MemoryReservation memory(budget);
    for (;;) {
      if (!memory.begin(control_)) return refused_.store(true);
      const auto ok = memory.take_reader(bytes);
      if (ok) break;
      if (!memory.restart()) return refused_.store(true);
      waits_ = true;
    }
    has_ = true;
    while (!ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  Control control_;
  std::atomic<bool> waits_{false}, has_{false}, refused_{false}, ended_{false};
  std::thread thread_;
};

}  // namespace

TEST_CASE("memory: a job reserves step by step, and all is given back") {
  MemoryBudget budget(1024 * kMiB);
  Control control;
  {
    MemoryReservation memory(budget);
    REQUIRE(memory.begin(control).ok());
    CHECK(memory.take_reader(100 * kMiB).value() == 100 * kMiB);
    CHECK(budget.reserved() == 100 * kMiB);
    REQUIRE(memory.take_mesh(1000, 2000).ok());
    CHECK(budget.reserved() == 100 * kMiB + 1000 * sizeof(Vec3) + 2000 * sizeof(Triangle));
    memory.end_reader();
    CHECK(budget.reserved() == bytes_of_mesh(1000, 2000));
    REQUIRE(memory.take_reader(50 * kMiB).ok());
    REQUIRE(memory.take_mesh(500, 1000).ok());
    memory.end_reader();
    memory.keep_meshes();
    CHECK(budget.reserved() == bytes_of_mesh(1500, 3000));
    CHECK(!memory.restart());
    CHECK(memory.taken_meshes() == 2);
  }
  CHECK(budget.reserved() == 0);
}

TEST_CASE("memory: a file that is read again is counted once, beside the meshes before it") {
  MemoryBudget budget(1024 * kMiB);
  Control control;
  MemoryReservation memory(budget);
  REQUIRE(memory.begin(control).ok());
  REQUIRE(memory.take_mesh(100, 200).ok());  // of an earlier job: without a reader
  for (int attempt = 0; attempt < 2; ++attempt) {
    REQUIRE(memory.take_reader(100 * kMiB).ok());
    CHECK(budget.reserved() == 100 * kMiB + bytes_of_mesh(100, 200));
    REQUIRE(memory.take_mesh(1000, 2000).ok());
    CHECK(memory.taken_meshes() == 2);
  }
  memory.end_reader();
  CHECK(budget.reserved() == bytes_of_mesh(1100, 2200));
}

TEST_CASE("memory: what a job can never have is refused with the numbers, and a reader gets what there can be") {
  MemoryBudget budget(1000 * kMiB);
  Control control;
  MemoryReservation memory(budget);
  REQUIRE(memory.begin(control).ok());
  CHECK(memory.take_reader(5000 * kMiB).value() == 875 * kMiB);
  memory.end_reader();
  const auto refused = memory.take_mesh(10'000'000, 20'000'000);
  REQUIRE(!refused.ok());
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(refused.error().message ==
        "the comparison needs 3520000000 bytes of memory for 20000000 triangles, more than the "
        "917504000 that one may have here; send smaller meshes");
  CHECK(!memory.restart());
}

TEST_CASE("memory: a mesh that fits is not refused because its reader had all there was") {
  MemoryBudget budget(1000 * kMiB);  // a job gets 875
  Control control;
  MemoryReservation memory(budget);
  const auto read = [&](std::uint64_t triangles) {
    const auto granted = memory.take_reader(5000 * kMiB);
    const bool fits = granted.ok() && memory.take_mesh(0, triangles).ok();
    if (fits) memory.end_reader();
    return fits;
  };
  constexpr std::uint64_t kHalf = 430 * kMiB / 140;
  int attempts = 0;
  for (bool ready = false; !ready; ++attempts) {
    REQUIRE(memory.begin(control).ok());
    ready = read(kHalf) && read(kHalf);
    REQUIRE((ready || memory.restart()));
  }
  CHECK(attempts == 3);  // each of the two is read again by a process that leaves room for it
  memory.keep_meshes();
  CHECK(budget.reserved() == 2 * bytes_of_mesh(0, kHalf));
}

TEST_CASE("memory: a job that does not fit gives all back, waits for all it knows, and then has it") {
  MemoryBudget budget(1000 * kMiB);
  Control control;
  std::optional<MemoryReservation> first(std::in_place, budget);
  REQUIRE(first->begin(control).ok());
  REQUIRE(first->take_reader(600 * kMiB).ok());
  MemoryReservation second(budget);
  REQUIRE(second.begin(control).ok());
  REQUIRE(second.take_reader(200 * kMiB).ok());
  CHECK(!second.take_mesh(0, 300 * kMiB / 140).ok());
  CHECK(second.restart());
  std::thread later([&] {
    while (budget.reserved() != 600 * kMiB) std::this_thread::yield();  // the second has given its own back
    first.reset();
  });
  REQUIRE(second.begin(control).ok());
  later.join();
  CHECK(budget.reserved() > 299 * kMiB);
  REQUIRE(second.take_reader(200 * kMiB).ok());
  REQUIRE(second.take_mesh(0, 300 * kMiB / 140).ok());
  CHECK(!second.restart());
}

TEST_CASE("memory: jobs that wait have their turn in order") {
  MemoryBudget budget(1000 * kMiB);
  Job first(budget, 800 * kMiB);
  REQUIRE(eventually([&] { return first.has(); }));
  Job third(budget, 700 * kMiB);
  REQUIRE(eventually([&] { return third.waits(); }));
  Job fourth(budget, 100 * kMiB);  // would fit, and is behind the third
  REQUIRE(eventually([&] { return fourth.waits(); }));
  first.end();
  CHECK(eventually([&] { return third.has() && fourth.has(); }));
}

TEST_CASE("memory: small jobs pass a large one that waits, within an eighth, and do not keep it waiting") {
  MemoryBudget budget(1000 * kMiB);
  Job running(budget, 500 * kMiB);
  REQUIRE(eventually([&] { return running.has(); }));
  Job waiting(budget, 600 * kMiB);
  REQUIRE(eventually([&] { return waiting.waits(); }));
  Job small(budget, 60 * kMiB), another(budget, 60 * kMiB);
  CHECK(eventually([&] { return small.has() && another.has(); }));
  Job third(budget, 60 * kMiB);
  CHECK(eventually([&] { return third.waits(); }));
  running.end();
  CHECK(eventually([&] { return waiting.has(); }));
}

TEST_CASE("memory: a job that waits can be cancelled") {
  MemoryBudget budget(1000 * kMiB);
  Job running(budget, 800 * kMiB);
  REQUIRE(eventually([&] { return running.has(); }));
  Job waiting(budget, 800 * kMiB);
  REQUIRE(eventually([&] { return waiting.waits(); }));
  waiting.cancel();
  CHECK(eventually([&] { return waiting.was_refused(); }));
  CHECK(budget.reserved() == 800 * kMiB);
}

TEST_CASE("memory: a job takes over what its second file has reserved") {
  MemoryBudget budget(1024 * kMiB);
  Control control;
  {
    MemoryReservation first(budget), second(&first);
    REQUIRE(first.begin(control).ok());
    REQUIRE(first.take_reader(100 * kMiB).ok());
    REQUIRE(second.take_reader(200 * kMiB).ok());
    CHECK(budget.reserved() == 300 * kMiB);
    REQUIRE(first.take_mesh(1000, 2000).ok());
    REQUIRE(second.take_mesh(500, 1000).ok());
    first.end_reader();
    second.end_reader();
    REQUIRE(first.take_over(second).ok());
    CHECK(first.taken_meshes() == 2);
    CHECK(budget.reserved() == bytes_of_mesh(1500, 3000));
    REQUIRE(first.take_mesh(1, 2).ok());  // as of the mesh of an alignment
    first.keep_meshes();
    CHECK(budget.reserved() == bytes_of_mesh(1501, 3002));
  }
  CHECK(budget.reserved() == 0);
}

TEST_CASE("memory: a second file takes what is spare, waits for nothing, and is never refused for good") {
  MemoryBudget budget(1024 * kMiB);
  Control control;
  MemoryReservation first(budget);
  REQUIRE(first.begin(control).ok());
  REQUIRE(first.take_reader(500 * kMiB).ok());
  CHECK(first.wait_for_turn().ok());
  {
    MemoryReservation second(&first);
    REQUIRE(second.take_reader(268 * kMiB).ok());  // up to the last quarter
    REQUIRE(!second.take_mesh(0, (200 * kMiB) / 12).ok());
    CHECK(second.restart());
  }
  CHECK(budget.reserved() == 500 * kMiB);
  MemoryReservation large(&first);
  CHECK(!large.take_mesh(0, 100 * kMiB).ok());  // more than one job can ever have
  CHECK(large.restart());
  MemoryReservation turn(&first);
  CHECK(!turn.wait_for_turn().ok());
  CHECK(turn.restart());
  Job waiting(budget, 600 * kMiB);
  REQUIRE(eventually([&] { return waiting.waits(); }));
  MemoryReservation small(&first);
  CHECK(!small.take_reader(32 * kMiB).ok());  // not before a job that waits
  CHECK(!first.restart());
  waiting.cancel();
}

TEST_CASE("memory: two meshes that one job can never have are refused when it takes over the second") {
  MemoryBudget budget(1024 * kMiB);
  Control control;
  MemoryReservation first(budget), second(&first);
  REQUIRE(first.begin(control).ok());
  REQUIRE(second.take_mesh(0, (60 * kMiB) / 140).ok());
  REQUIRE(first.take_mesh(0, (880 * kMiB) / 140).ok());
  const auto both = first.take_over(second);
  REQUIRE(!both.ok());
  CHECK(both.error().code == ErrorCode::too_large);
  CHECK(!first.restart());
}

TEST_CASE("memory: many jobs of all sizes all have their turn, and never more than there is") {
  MemoryBudget budget(1000 * kMiB);
  std::atomic<int> done{0};
  std::atomic<std::uint64_t> held{0};
  std::atomic<bool> too_much{false};
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 8; ++seed) {
    threads.emplace_back([&, seed] {
      std::mt19937 dice(seed);
      for (int i = 0; i < 50; ++i) {
        const std::uint64_t reader = (1 + dice() % 300) * kMiB, triangles = (1 + dice() % 250) * kMiB / 140;
        Control control;
        MemoryReservation memory(budget);
        for (bool ready = false; !ready;) {
          const bool begun = memory.begin(control).ok();
          ready = begun && memory.take_reader(reader).ok() && memory.take_mesh(0, triangles).ok();
          if (ready) memory.end_reader();
          ready = ready && memory.take_mesh(0, triangles).ok();
          if (!ready && !memory.restart()) return;
        }
        memory.keep_meshes();
        const std::uint64_t mine = 2 * bytes_of_mesh(0, triangles);
        if (held.fetch_add(mine) + mine > budget.bytes()) too_much = true;
        held -= mine;
        ++done;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(done == 8 * 50);
  CHECK(!too_much);
  CHECK(budget.reserved() == 0);
}
