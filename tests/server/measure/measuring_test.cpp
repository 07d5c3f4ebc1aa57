#include "server/measure/measuring.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "tests/eventually.h"
#include "tests/server/stand_in.h"

using namespace meshgauge;
using namespace meshgauge::server;

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

// Reads with a number of readers, as the pool does.
struct Readers final : MeshLoader {
  explicit Readers(int number) : free(number) {}

  Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation& memory, Control& control) override {
    if (auto ok = taken(memory); !ok) return ok.error();
    auto mesh = read(source, memory, control);
    const std::lock_guard lock(mutex);
    ++free;
    changed.notify_all();
    return mesh;
  }

  Result<Done> taken(MemoryReservation& memory) {
    std::unique_lock lock(mutex);
    if (free == 0) {
      if (auto ok = memory.wait_for_turn(); !ok) return ok;
    }
    changed.wait(lock, [this] { return free > 0; });
    --free;
    return Done{};
  }

  Result<api::SharedMesh> read(const MeshSource& source, MemoryReservation& memory, Control& control) {
    if (auto granted = memory.take_reader(reader_bytes); !granted) return granted.error();
    ++readings;
    most = std::max(most.load(), ++now);
    if (together > 0) CHECK(eventually([this] { return readings >= together; }));
    if (source.input.part == endless) eventually([&] { return control.check() != Interruption::none; });
    if (source.input.part == "a" && until) CHECK(eventually(until));
    --now;
    if (source.input.part == refused) return Error{ErrorCode::unreadable_mesh, "wrong", refused, ""};
    if (auto ok = memory.take_mesh(source.input.part == "b" ? vertices_of_b : 3, 1); !ok) return ok.error();
    memory.end_reader();
    return stand_in(source);
  }

  std::mutex mutex;  // guards free
  std::condition_variable changed;
  int free;
  std::uint64_t reader_bytes = 32 * kMiB;
  int together = 0;  // readings that wait for each other
  std::string refused, endless;
  std::uint64_t vertices_of_b = 3;
  std::function<bool()> until;  // before a is read
  std::atomic<int> readings{0}, now{0}, most{0};
};

MeshSource source(const char* part) {
  static const std::vector<std::byte> large(api::kLeastBytesBeside);
  return MeshSource{{part, large, "", "", -1}, nullptr, "", {}};
}

Result<api::SharedMeshes> loaded(Readers& readers, MemoryReservation& memory, unsigned threads = 2) {
  Control control;
  api::StageTimes times;
  REQUIRE(memory.begin(control).ok());
  return load_both(readers, source("a"), source("b"), threads, memory, control, times);
}

}  // namespace

TEST_CASE("measuring: both meshes are loaded side by side, and reserved by the job") {
  MemoryBudget budget(1024 * kMiB);
  Readers readers(2);
  readers.together = 2;
  MemoryReservation memory(budget);
  const auto both = loaded(readers, memory);
  REQUIRE(both.ok());
  CHECK(both->a->mesh.mesh().positions[0].z() == 0);
  CHECK(both->b->mesh.mesh().positions[0].z() == 1);
  CHECK(memory.taken_meshes() == 2);
  CHECK(budget.reserved() == 2 * bytes_of_mesh(3, 1));
}

TEST_CASE("measuring: b is loaded after a with one thread, one reader, or memory for one") {
  MemoryBudget budget(1024 * kMiB);
  for (const char* why : {"thread", "reader", "memory"}) {
    Readers readers(why == std::string("reader") ? 1 : 2);
    if (why == std::string("memory")) readers.reader_bytes = 500 * kMiB;
    MemoryReservation memory(budget);
    const auto both = loaded(readers, memory, why == std::string("thread") ? 1 : 2);
    REQUIRE(both.ok());
    CHECK(readers.most == 1);
    CHECK(memory.taken_meshes() == 2);
    CHECK(!memory.restart());
    CHECK(budget.reserved() == 2 * bytes_of_mesh(3, 1));
  }
}

TEST_CASE("measuring: a b that does not fit beside a gives its memory back before a is read") {
  MemoryBudget budget(1024 * kMiB);
  Readers readers(2);
  readers.together = 2;
  constexpr std::uint64_t kMillion = 1'000'000;
  readers.vertices_of_b = kMillion * (760 * kMiB / bytes_of_mesh(kMillion, 1));
  readers.until = [&] { return readers.readings == 2 && budget.reserved() == readers.reader_bytes; };
  MemoryReservation memory(budget);
  const auto both = loaded(readers, memory);
  REQUIRE(both.ok());
  CHECK(readers.readings == 3);
  CHECK(!memory.restart());
}

TEST_CASE("measuring: a refused a stops the reader of b") {
  MemoryBudget budget(1024 * kMiB);
  Readers readers(2);
  readers.together = 2;
  readers.refused = "a";
  readers.endless = "b";
  MemoryReservation memory(budget);
  CHECK(loaded(readers, memory).error().part == "a");
  CHECK(budget.reserved() == 32 * kMiB);  // of a, until the job ends
}

TEST_CASE("measuring: jobs that share few readers and little memory all end") {
  MemoryBudget budget(1024 * kMiB);
  for (const int number : {1, 2, 3}) {
    Readers readers(number);
    readers.reader_bytes = 300 * kMiB;
    std::atomic<int> done{0};
    std::vector<std::thread> jobs;
    for (int job = 0; job < 4; ++job) {
      jobs.emplace_back([&] {
        for (int i = 0; i < 50; ++i) {
          Control control;
          done += within(budget, control, [&](MemoryReservation& memory) {
                    api::StageTimes times;
                    return load_both(readers, source("a"), source("b"), 2, memory, control, times);
                  }).ok();
        }
      });
    }
    for (std::thread& job : jobs) job.join();
    CHECK(done == 4 * 50);
    CHECK(readers.most <= number);
    CHECK(budget.reserved() == 0);
  }
}
