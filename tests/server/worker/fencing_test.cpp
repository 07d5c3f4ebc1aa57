// Workers that are taken for dead, and a store that is away.
#include <atomic>
#include <thread>

#include <nlohmann/json.hpp>

#include "bench_of_workers.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::got;
using store::JobState;

namespace {

// Like the upkeep of the process on duty.
void take_from_all(Kept& kept) {
  const auto now = store::now();
  got(kept.embedded.jobs().recover("", "its worker went away", {now, now + seconds(60)}));
}

// A worker that was stopped past its lease: it sends and receives nothing.
WorkerOptions silent(const std::string& name) {
  auto options = options_of(name);
  options.heartbeat = std::chrono::hours(1);
  options.progress = std::chrono::hours(1);
  return options;
}

}  // namespace

TEST_CASE("worker: the result of a worker taken for dead is refused, another one's stays") {
  Kept kept;
  Stand late;
  Stand quick;
  quick.released = true;
  const auto key = put_job(kept, job_named("contested"));
  WorkerBench stopped(kept.stores(), late, silent("stopped"));
  stopped.worker.start();
  REQUIRE(eventually([&] { return late.running == 1; }));
  take_from_all(kept);
  // The stopped worker's next claim must not come first.
  stopped.worker.drain();
  WorkerBench other(kept.stores(), quick, options_of("other"));
  other.worker.start();
  REQUIRE(eventually([&] { return has_state(kept, key, JobState::done); }));
  const auto row = row_of(kept, key);
  late.released = true;
  REQUIRE(eventually([&] { return stopped.worker.held() == 0; }));
  CHECK(stopped.metric("meshgauge_worker_leases_lost_total") == 1);
  const auto after = row_of(kept, key);
  CHECK(after.tries == 2);
  CHECK(after.document == row.document);
  CHECK(after.finished == row.finished);
}

TEST_CASE("worker: a lost job is ended, and its result is not stored") {
  Kept kept;
  Stand stand;
  const auto key = put_job(kept, job_named("lost"));
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return stand.running == 1; }));
  const auto now = store::now();
  got(kept.embedded.jobs().recover("", "its worker went away", {now, now + seconds(60)}));
  REQUIRE(eventually([&] { return bench.metric("meshgauge_worker_leases_lost_total") == 1; }));
  REQUIRE(eventually([&] { return stand.running == 2; }));  // it has claimed it again
  CHECK(row_of(kept, key).tries == 2);
  CHECK(row_of(kept, key).last_error == "its worker went away");
  stand.released = true;
  REQUIRE(eventually([&] { return has_state(kept, key, JobState::done); }));
}

TEST_CASE("worker: it goes on while the store is away, and stores results afterwards") {
  Kept kept;
  Stand stand;
  std::vector<store::JobKey> keys;
  for (int i = 0; i < 10; ++i) keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "batch")));
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return stand.running == 1 && bench.worker.held() == 10; }));
  kept.jobs.full = true;
  stand.released = true;
  REQUIRE(eventually([&] { return stand.running == 10 && bench.worker.deliveries_waiting() == 10; }));
  CHECK(bench.worker.held() == 10);
  CHECK(bench.metric("meshgauge_worker_deliveries_waiting") == 10);
  REQUIRE(eventually([&] { return kept.jobs.unfinished > 0; }));
  kept.jobs.full = false;
  bench.worker.wake();
  for (const auto& key : keys) REQUIRE(eventually([&] { return has_state(kept, key, JobState::done); }));
  CHECK(stand.running == 10);
  const auto later = put_job(kept, job_named("later"));
  CHECK(eventually([&] { return has_state(kept, later, JobState::done); }));
}

TEST_CASE("worker: a stop while the store is away ends in time, and the job is requeued later") {
  Kept kept;
  Stand stand;
  const auto key = put_job(kept, job_named("long"));
  {
    WorkerBench bench(kept.stores(), stand, options_of("w"));
    bench.worker.start();
    REQUIRE(eventually([&] { return stand.running == 1; }));
    kept.jobs.full = true;
    bench.worker.stop(milliseconds(50));
    CHECK(bench.worker.held() == 1);
  }
  kept.jobs.full = false;
  CHECK(row_of(kept, key).state == JobState::running);
  take_from_all(kept);
  CHECK(row_of(kept, key).state == JobState::queued);
}

TEST_CASE("worker: jobs of a claim during a stop are handed back") {
  Kept kept;
  Stand stand;
  const auto key = put_job(kept, job_named("late"));
  std::atomic<bool> claimed{false};
  kept.jobs.answers_claim = [&](const std::vector<store::Claimed>& some) {
    claimed = claimed || !some.empty();
    std::this_thread::sleep_for(milliseconds(300));  // a stop that does not wait for the claim has returned by then
    return true;
  };
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return claimed.load(); }));
  bench.worker.stop(seconds(60));
  CHECK(bench.worker.held() == 0);
  const auto row = row_of(kept, key);
  CHECK(row.state == JobState::queued);
  CHECK_FALSE(row.suspected);
}

TEST_CASE("worker: jobs of an unanswered claim are handed back, also while draining") {
  Kept kept;
  Stand stand;
  const auto key = put_job(kept, job_named("unheard"));
  std::atomic<bool> claimed{false};
  kept.jobs.answers_claim = [&](const std::vector<store::Claimed>& some) {
    if (some.empty()) return true;
    kept.jobs.full = true;  // until it drains
    claimed = true;
    return false;
  };
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return claimed.load(); }));
  CHECK(row_of(kept, key).state == JobState::running);
  bench.worker.drain();
  kept.jobs.full = false;
  SUBCASE("in the time of its grace") {
    CHECK(eventually([&] { return has_state(kept, key, JobState::queued); }));
  }
  SUBCASE("before it has stopped") {
    bench.worker.stop(seconds(60));
    CHECK(row_of(kept, key).state == JobState::queued);
  }
  CHECK_FALSE(row_of(kept, key).suspected);
  CHECK(stand.running == 0);
}
