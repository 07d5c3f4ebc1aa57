#include "server/worker/worker.h"

#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench_of_workers.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::got;
using store::JobState;

TEST_CASE("worker: queued jobs run, smallest first, and their ends are stored") {
  Kept kept;
  Stand stand;
  stand.released = true;
  std::vector<store::JobKey> keys;
  const auto now = store::now();  // one time for all: on a slow machine age would outweigh size
  for (const auto& [name, cost] : {std::pair("large", 30'000'000), {"small", 1000}, {"middle", 5'000'000}}) {
    auto job = job_named(name, "", static_cast<std::uint64_t>(cost));
    job.created = now;
    keys.push_back(put_job(kept, job));
  }
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  for (const auto& key : keys) CHECK(eventually([&] { return has_state(kept, key, JobState::done); }));
  CHECK(stand.order == std::vector<std::string>{"small", "middle", "large"});
  const auto row = row_of(kept, keys[0]);
  CHECK(nlohmann::json::parse(row.document)["meshes"]["a"]["bytes"] == std::string("large").size());
  CHECK(row.finished.has_value());
  CHECK(eventually([&] { return bench.worker.held() == 0; }));
  CHECK(bench.metric("meshgauge_worker_claimed_total") == 3);
}

TEST_CASE("worker: a signal announces later jobs") {
  Kept kept;
  Stand stand;
  stand.released = true;
  auto options = options_of("w");
  options.poll = std::chrono::hours(1);
  WorkerBench bench(kept.stores(), stand, options);
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
  for (int i = 0; i < 50; ++i) keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "batch")));
  WorkerBench one(kept.stores(), stand, options_of("one"), with_threads(2));
  WorkerBench two(kept.stores(), stand, options_of("two"), with_threads(2));
  one.worker.start();
  two.worker.start();
  for (const auto& key : keys) REQUIRE(eventually([&] { return has_state(kept, key, JobState::done); }));
  CHECK(stand.running == 50);
  CHECK(one.metric("meshgauge_worker_claimed_total") + two.metric("meshgauge_worker_claimed_total") == 50);
}

TEST_CASE("worker: an owner's cancel ends a running job with the interval reached") {
  Kept kept;
  Stand stand;
  const auto key = put_job(kept, job_named("long"));
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return stand.running == 1; }));
  got(kept.embedded.jobs().request_cancel(key, {store::now(), store::now() + seconds(60)}));
  SUBCASE("that is signalled") { bench.worker.cancel(key); }
  SUBCASE("that the next heartbeat tells of") {}
  REQUIRE(eventually([&] { return has_state(kept, key, JobState::cancelled); }));
  CHECK(nlohmann::json::parse(row_of(kept, key).document)["status"] == "cancelled");
}

TEST_CASE("worker: a cancel before the answer of the claim is remembered") {
  Kept kept;
  Stand stand;
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.cancel({"", "early"});
  const auto key = put_job(kept, job_named("early"));
  bench.worker.start();
  CHECK(eventually([&] { return has_state(kept, key, JobState::cancelled); }));
}

TEST_CASE("worker: an owner's cancel ends a job that waits for a thread, which another keeps") {
  Kept kept;
  Stand stand;
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  std::promise<void> released;
  const auto cancelled = [&](const store::JobKey& key) {
    got(kept.embedded.jobs().request_cancel(key, {store::now(), store::now() + seconds(60)}));
    SUBCASE("that is signalled") { bench.worker.cancel(key); }
    SUBCASE("that the next heartbeat tells of") {}
    CHECK(eventually([&] { return has_state(kept, key, JobState::cancelled); }));
  };
  SUBCASE("in the buffer") {
    std::vector<store::JobKey> keys;
    for (int i = 0; i < 5; ++i) keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "batch")));
    bench.worker.start();
    REQUIRE(eventually([&] { return stand.running == 1 && bench.worker.held() == 5; }));
    cancelled(keys[3]);
    CHECK(eventually([&] { return bench.worker.held() == 4; }));
    CHECK(row_of(kept, keys[0]).state == JobState::running);
  }
  SUBCASE("in the scheduler") {
    const auto control = std::make_shared<Control>();
    auto place = bench.scheduler.admit(Scheduler::Kind::awaited, "");
    bench.scheduler.submit(std::move(*place),
                           {"", 0, kLong, control, [&](Scheduler::Slot) { released.get_future().wait(); }});
    REQUIRE(eventually([&] { return bench.scheduler.figures().running == 1; }));
    const auto key = put_job(kept, job_named("waits"));
    bench.worker.start();
    REQUIRE(eventually([&] { return bench.scheduler.figures().waiting == 1; }));
    cancelled(key);
    CHECK(bench.scheduler.figures().waiting == 0);
    const auto next = put_job(kept, job_named("next"));
    REQUIRE(eventually([&] { return bench.scheduler.figures().waiting == 1; }));
    released.set_value();
    stand.released = true;
    CHECK(eventually([&] { return has_state(kept, next, JobState::done); }));
  }
}

TEST_CASE("worker: draining hands back jobs that have not begun, without blame, and lets others end") {
  Kept kept;
  Stand stand;
  std::vector<store::JobKey> keys;
  for (int i = 0; i < 10; ++i) keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "batch")));
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return stand.running == 1 && bench.worker.held() == 10; }));
  bench.worker.drain();
  REQUIRE(eventually([&] { return bench.worker.held() == 1; }));
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const auto row = row_of(kept, keys[i]);
    CHECK(row.state == JobState::queued);
    CHECK(row.last_error.empty());
    CHECK_FALSE(row.suspected);
  }
  CHECK(row_of(kept, keys[0]).state == JobState::running);
  stand.released = true;
  CHECK(eventually([&] { return has_state(kept, keys[0], JobState::done); }));
  CHECK(stand.running == 1);
}

TEST_CASE("worker: stopping hands back running jobs with their intervals") {
  Kept kept;
  Stand stand;
  const auto key = put_job(kept, job_named("long"));
  {
    WorkerBench bench(kept.stores(), stand, options_of("w"));
    bench.worker.start();
    REQUIRE(eventually([&] { return stand.running == 1; }));
    bench.worker.stop();
    CHECK(bench.worker.held() == 0);
  }
  const auto row = row_of(kept, key);
  CHECK(row.state == JobState::queued);
  CHECK(row.last_error.empty());
  CHECK_FALSE(row.suspected);
  REQUIRE(row.progress.has_value());
  stand.released = true;
  WorkerBench next(kept.stores(), stand, options_of("next"));
  next.worker.start();
  CHECK(eventually([&] { return has_state(kept, key, JobState::done); }));
}

namespace {

// Counts the comparisons that run while the one of "suspect" does.
struct CountsBesideSuspect final : MeshLoader {
  Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation&, Control&) override {
    if (source.input.part == "b") return stand_in(source);
    ++running;
    std::this_thread::sleep_for(milliseconds(5));
    if (source.input.filename == "suspect") beside_suspect = running - 1;
    std::this_thread::sleep_for(milliseconds(1));
    if (source.input.filename == "suspect") beside_suspect += running - 1;
    --running;
    return stand_in(source);
  }

  std::atomic<int> running{0};
  std::atomic<int> beside_suspect{0};
};

}  // namespace

TEST_CASE("worker: a suspected job runs alone") {
  Kept kept;
  const auto key = put_job(kept, job_named("suspect", "", 95'000'000));  // in the middle
  const auto now = store::now();
  store::claim_one(kept.embedded.jobs(), key, "dead", now, now + seconds(60));
  got(kept.embedded.jobs().recover("dead", "it went away", {now, now + seconds(60)}));
  REQUIRE(row_of(kept, key).suspected);
  std::vector<store::JobKey> keys{key};
  for (unsigned i = 0; i < 20; ++i)
    keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "", i * 10'000'000U)));
  CountsBesideSuspect counting;
  WorkerBench bench(kept.stores(), counting, options_of("w"), with_threads(4));
  bench.worker.start();
  for (const auto& each : keys) REQUIRE(eventually([&] { return has_state(kept, each, JobState::done); }));
  CHECK(counting.beside_suspect == 0);
}

namespace {

// A job that another worker runs, and loses.
store::JobKey put_running(Kept& kept, const std::string& name) {
  const auto key = put_job(kept, job_named(name));
  const auto now = store::now();
  REQUIRE(store::claim_one(kept.embedded.jobs(), key, "other", now, now + std::chrono::hours(1)));
  return key;
}

void lose(Kept& kept, const std::string& worker) {
  const auto now = store::now();
  got(kept.embedded.jobs().recover(worker, "it went away", {now, now + seconds(60)}));
}

// The comparison "long" lasts until it is released, all others end at once.
struct Lasting final : MeshLoader {
  Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation&, Control& control) override {
    while (source.input.filename == "long" && !released && control.check() == Interruption::none) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    return stand_in(source);
  }

  std::atomic<bool> released{false};
};

}  // namespace

TEST_CASE("worker: a suspected job blocks no other while something runs") {
  Kept kept;
  Lasting lasting;
  const auto suspect = put_running(kept, "suspect");
  auto options = options_of("w");
  options.pass_over = std::chrono::hours(1);
  WorkerBench bench(kept.stores(), lasting, options, with_threads(2));
  bench.worker.start();
  const auto longest = put_job(kept, job_named("long"));
  REQUIRE(eventually([&] { return bench.worker.running() == 1; }));
  lose(kept, "other");
  for (const std::string name : {"x", "y", "z"}) {
    const auto key = put_job(kept, job_named(name));
    REQUIRE(eventually([&] { return has_state(kept, key, JobState::done); }));
  }
  CHECK(row_of(kept, suspect).suspected);
  CHECK(has_state(kept, suspect, JobState::queued));  // other workers may claim it
  CHECK(has_state(kept, longest, JobState::running));
  lasting.released = true;
  CHECK(eventually([&] { return has_state(kept, suspect, JobState::done); }));
}

TEST_CASE("worker: a suspected job has its turn on a busy worker") {
  Kept kept;
  Lasting lasting;
  const auto suspect = put_running(kept, "suspect");
  auto options = options_of("w");
  options.pass_over = milliseconds(50);
  WorkerBench bench(kept.stores(), lasting, options, with_threads(2));
  bench.worker.start();
  put_job(kept, job_named("long"));
  REQUIRE(eventually([&] { return bench.worker.running() == 1; }));
  lose(kept, "other");
  REQUIRE(eventually([&] { return has_state(kept, suspect, JobState::running); }));
  const auto later = put_job(kept, job_named("later"));
  CHECK(bench.worker.running() == 1);  // it waits for that
  CHECK(has_state(kept, later, JobState::queued));
  lasting.released = true;
  CHECK(eventually([&] { return has_state(kept, suspect, JobState::done); }));
  CHECK(eventually([&] { return has_state(kept, later, JobState::done); }));
}

TEST_CASE("worker: when it is lost, the jobs that it ran are suspected, those in its buffer are not") {
  Kept kept;
  Stand stand;
  std::vector<store::JobKey> keys;
  for (int i = 0; i < 10; ++i) keys.push_back(put_job(kept, job_named("j" + std::to_string(i), "batch")));
  auto options = options_of("w");
  options.heartbeat = std::chrono::hours(1);  // it does not learn that it has lost them
  options.poll = std::chrono::hours(1);       // and does not claim them again
  std::atomic<bool> found_none{false};
  kept.jobs.answers_claim = [&](const std::vector<store::Claimed>& some) {
    found_none = found_none || some.empty();
    return true;
  };
  WorkerBench bench(kept.stores(), stand, options);
  bench.worker.start();
  REQUIRE(eventually([&] { return stand.running == 1 && bench.worker.held() == 10 && found_none; }));
  REQUIRE(eventually([&] { return row_of(kept, keys[0]).progress.has_value(); }));  // soon, though it is of a batch
  lose(kept, "w");
  CHECK(row_of(kept, keys[0]).suspected);
  for (std::size_t i = 1; i < keys.size(); ++i) {
    CHECK(has_state(kept, keys[i], JobState::queued));
    CHECK_FALSE(row_of(kept, keys[i]).suspected);
  }
}

TEST_CASE("worker: the time of a job begins with its run, and ends with its client's deadline") {
  Kept kept;
  Stand stand;
  stand.released = true;
  store::NewJob waiting = job_named("awaited");
  waiting.deadline = store::now() + seconds(7);
  const auto awaited = put_job(kept, waiting);
  store::NewJob patient = job_named("patient");
  patient.created -= std::chrono::hours(1);
  const auto durable = put_job(kept, patient);
  const auto start = Control::Clock::now();
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return has_state(kept, awaited, JobState::done); }));
  REQUIRE(eventually([&] { return has_state(kept, durable, JobState::done); }));
  REQUIRE(stand.order == std::vector<std::string>{"patient", "awaited"});
  CHECK(stand.deadlines[0] >= start + milliseconds(bench.settings.default_timeout_ms));
  CHECK(stand.deadlines[1] < start + seconds(8));
  CHECK(nlohmann::json::parse(row_of(kept, durable).document)["timings_ms"]["queue"] >= 3'600'000);
}

TEST_CASE("worker: a job that times out before its meshes are read has ended, and is not tried again") {
  Kept kept;
  const auto key = put_job(kept, job_named("late"));
  struct TooLate final : MeshLoader {
    Result<api::SharedMesh> load(const MeshSource&, MemoryReservation&, Control&) override {
      return Error{ErrorCode::out_of_time, "the time was over", "", ""};
    }
  };
  TooLate too_late;
  WorkerBench bench(kept.stores(), too_late, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return has_state(kept, key, JobState::failed); }));
  CHECK(row_of(kept, key).tries == 1);
  CHECK(row_of(kept, key).problem.find("the time was over") != std::string::npos);
}

TEST_CASE("worker: a job without its meshes fails, and says why") {
  Kept kept;
  Stand stand;
  stand.released = true;
  const auto key = job_named("gone").key;
  got(kept.embedded.jobs().insert(job_named("gone")));
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return has_state(kept, key, JobState::failed); }));
  const auto row = row_of(kept, key);
  CHECK(row.tries == 1);
  CHECK(row.problem.find("was removed before it could run") != std::string::npos);
  CHECK(stand.running == 0);
}

TEST_CASE("worker: a job whose options this version does not know fails, and says why") {
  Kept kept;
  Stand stand;
  store::NewJob job = job_named("strange");
  job.options = R"({"of_later":1})";
  const auto key = put_job(kept, job);
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return has_state(kept, key, JobState::failed); }));
  CHECK(row_of(kept, key).problem.find("of_later") != std::string::npos);
}

TEST_CASE("worker: blobs are removed with the last job that needs them") {
  Kept kept;
  Stand stand;
  stand.released = true;
  const auto job = job_named("last", "batch");  // blobs of single jobs are removed by Jobs
  const auto key = put_job(kept, job);
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return bench.worker.held() == 0 && has_state(kept, key, JobState::done); }));
  CHECK_FALSE(got(kept.embedded.blobs().exists({"", job.mesh_a})));
}
