#include "server/worker/worker.h"

#include <nlohmann/json.hpp>

#include "bench_of_workers.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::got;
using store::JobState;

TEST_CASE("worker: what is in the queue is run, smallest first, and its end is stored") {
  Kept kept;
  Stand stand;
  stand.released = true;
  std::vector<store::JobKey> keys;
  for (const auto& [name, cost] : {std::pair("large", 30'000'000), {"small", 1000}, {"middle", 5'000'000}}) {
    keys.push_back(put_job(kept, job_named(name, "", static_cast<std::uint64_t>(cost))));
  }
  WorkerBench bench(kept.stores(), stand.compare(), options_of("w"));
  bench.worker.start();
  for (const auto& key : keys) CHECK(eventually([&] { return has_state(kept, key, JobState::done); }));
  CHECK(stand.order == std::vector<std::string>{"small", "middle", "large"});
  const auto row = row_of(kept, keys[0]);
  CHECK(nlohmann::json::parse(row.document)["meshes"]["a"]["bytes"] == std::string("large").size());
  CHECK(row.finished.has_value());
  CHECK(eventually([&] { return bench.worker.held() == 0; }));
  CHECK(bench.metric("meshgauge_worker_claimed_total") == 3);
}

TEST_CASE("worker: it is told of what comes later") {
  Kept kept;
  Stand stand;
  stand.released = true;
  auto options = options_of("w");
  options.poll = std::chrono::hours(1);
  WorkerBench bench(kept.stores(), stand.compare(), options);
  bench.worker.start();
  const auto key = put_job(kept, job_named("late"));
  bench.worker.wake();
  CHECK(eventually([&] { return has_state(kept, key, JobState::done); }));
}

TEST_CASE("worker: two share a batch, each job is run once") {
  Kept kept;
  Stand stand;
  stand.released = true;
  std::vector<store::JobKey> keys;
  for (int i = 0; i < 80; ++i) keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "batch")));
  WorkerBench one(kept.stores(), stand.compare(), options_of("one"), with_threads(2));
  WorkerBench two(kept.stores(), stand.compare(), options_of("two"), with_threads(2));
  one.worker.start();
  two.worker.start();
  for (const auto& key : keys) REQUIRE(eventually([&] { return has_state(kept, key, JobState::done); }));
  CHECK(stand.running == 80);
  CHECK(one.metric("meshgauge_worker_claimed_total") + two.metric("meshgauge_worker_claimed_total") == 80);
}
