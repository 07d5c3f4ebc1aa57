// Sweeps remove what is expired and unused, and leave alone what a lost database or a wrong clock makes look so.
#include "server/jobs/upkeep.h"

#include <filesystem>
#include <string>
#include <vector>

#include "bench_of_jobs.h"
#include "server/store/sqlite.h"

using namespace meshgauge;
using namespace meshgauge::server;
using namespace std::chrono_literals;
using std::chrono::milliseconds;
using store::got;

namespace {

struct Sweeps {
  // One service's first sweep. The clock is off by `jump` since the service began.
  void run(milliseconds jump = 0ms) {
    milliseconds behind{0};
    Upkeep upkeep(one_worker(), kept.stores(), store_errors, [&] { return system_uptime() - behind; });
    behind = jump;
    upkeep.tick();
    upkeep.tick();  // removes what the first has released
  }

  void put(const std::string& text, std::chrono::hours age) {
    const store::BlobKey key = store::key_of("", text);
    got(kept.embedded.blobs().put(key, store::bytes_of(text)));
    for (const auto& entry : std::filesystem::recursive_directory_iterator(kept.embedded.folder() / "data/blobs")) {
      if (entry.path().filename() == key.id) last_write_time(entry.path(), entry.last_write_time() - age);
    }
    keys.push_back(key);
  }

  int left() {
    int number = 0;
    for (const store::BlobKey& key : keys) number += got(kept.embedded.blobs().exists(key)) ? 1 : 0;
    return number;
  }

  void execute(const std::string& sql) {
    store::Connection(kept.embedded.folder() / "data/jobs.sqlite", store::Connection::Use::write).execute(sql.c_str());
  }

  Kept kept;
  Metrics metrics;
  StoreErrors store_errors{metrics};
  std::vector<store::BlobKey> keys;
};

constexpr const char* kBornLongAgo = "UPDATE origin SET born = born - 100 * 86400000";

}  // namespace

TEST_CASE("sweeps: unused files of a database that is not new are removed, young ones stay") {
  Sweeps sweeps;
  sweeps.execute(kBornLongAgo);
  sweeps.put("old", 2h);
  sweeps.put("young", 0h);
  sweeps.run();
  CHECK(sweeps.left() == 1);
}

TEST_CASE("sweeps: files older than their database stay for a day: it may have been lost") {
  Sweeps sweeps;
  for (int i = 0; i < 5; ++i) sweeps.put(std::to_string(i), 48h);
  sweeps.run();
  CHECK(sweeps.left() == 5);
  sweeps.execute("UPDATE origin SET born = born - 86400001");
  sweeps.run();
  CHECK(sweeps.left() == 0);
}

TEST_CASE("sweeps: a hundred files that no row knows stay for a day from when they were found") {
  Sweeps sweeps;
  sweeps.execute(kBornLongAgo);
  for (std::uint64_t i = 0; i < SweepGuard::kMostUnknown; ++i) sweeps.put(std::to_string(i), 48h);
  sweeps.run();
  REQUIRE(sweeps.left() == SweepGuard::kMostUnknown);
  CHECK(got(sweeps.kept.embedded.jobs().origin()).doubted.has_value());
  got(sweeps.kept.embedded.blobs().remove(sweeps.keys.front()));  // fewer than a hundred, and still in doubt
  sweeps.run();
  REQUIRE(sweeps.left() == SweepGuard::kMostUnknown - 1);
  sweeps.execute("UPDATE origin SET doubted = doubted - 86400001");
  sweeps.run();
  CHECK(sweeps.left() == 0);
  sweeps.run();
  CHECK_FALSE(got(sweeps.kept.embedded.jobs().origin()).doubted.has_value());
}

TEST_CASE("sweeps: a hundred files of ended jobs are removed at once") {
  Sweeps sweeps;
  sweeps.execute(kBornLongAgo);
  for (std::uint64_t i = 0; i < SweepGuard::kMostUnknown; ++i) {
    sweeps.put(std::to_string(i), 48h);
    store::Job job = store::ended_job("", std::to_string(i));
    job.mesh_a = job.mesh_b = sweeps.keys.back().id;
    job.expires = store::now() + 1h;
    sweeps.kept.jobs.record(job);
  }
  got(sweeps.kept.jobs.flush());
  sweeps.run();
  CHECK(sweeps.left() == 0);
}

TEST_CASE("sweeps: a hundred meshes that have expired are removed with their files") {
  Sweeps sweeps;
  sweeps.execute(kBornLongAgo);
  const auto then = store::now() - 1h;
  for (std::uint64_t i = 0; i < SweepGuard::kMostUnknown; ++i) {
    sweeps.put(std::to_string(i), 48h);
    got(sweeps.kept.embedded.meshes().put_mesh({sweeps.keys.back(), 1, "", "", then, then, then}, {1 << 20}));
  }
  sweeps.run();
  CHECK(sweeps.left() == 0);
}

TEST_CASE("sweeps: a clock that jumped forward removes nothing, and a clock that is right again everything") {
  Sweeps sweeps;
  sweeps.execute(kBornLongAgo);
  sweeps.put("unused", 48h);
  const auto then = store::now() - 1h;
  store::Job job = store::ended_job("", "expired");
  job.expires = then;
  sweeps.kept.jobs.record(job);
  got(sweeps.kept.jobs.flush());
  sweeps.run(2h);
  CHECK(sweeps.left() == 1);
  CHECK(got(sweeps.kept.jobs.get(job.key)).has_value());
  sweeps.run(30min);
  CHECK(sweeps.left() == 0);
  CHECK_FALSE(got(sweeps.kept.jobs.get(job.key)).has_value());
}

TEST_CASE("sweeps: a clock counts as right again when it is back, or after a day") {
  Kept kept;
  Metrics metrics;
  StoreErrors store_errors(metrics);
  milliseconds behind{0};
  SweepGuard guard(kept.stores(), store_errors, [&] { return system_uptime() - behind; });
  CHECK(guard.clock_is_steady());
  behind = 2h;
  CHECK_FALSE(guard.clock_is_steady());
  behind = 0h;
  CHECK(guard.clock_is_steady());
  behind = -2h;  // the clock was set back
  CHECK_FALSE(guard.clock_is_steady());
  behind = -2h - 23h;  // and has stood still for 23 hours
  CHECK_FALSE(guard.clock_is_steady());
  behind = -2h - 24h;
  CHECK(guard.clock_is_steady());
}
