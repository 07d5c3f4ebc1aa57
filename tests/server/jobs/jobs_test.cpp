#include "server/jobs/jobs.h"

#include <future>
#include <nlohmann/json.hpp>

#include "bench_of_jobs.h"
#include "server/measure/live_job.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::got;
using store::JobState;

TEST_CASE("jobs: an awaited job is visible while it runs and after its end") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto job = begun(submit(bench.jobs, submission("a", false)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  CHECK(got(bench.jobs.get(job->key))->row.state == JobState::running);
  CHECK_FALSE(got(bench.jobs.get({"another", job->key.id})).has_value());
  stand.released = true;
  REQUIRE(job->wait_for_end(kLong));
  CHECK(job->view().row.state == JobState::done);
  CHECK(got(bench.jobs.get(job->key))->row.document == job->view().row.document);
  CHECK(eventually([&] { return bench.jobs.figures().awaited_slots == 0; }));
}

TEST_CASE("jobs: with areas, the bounds that their search notes are reserved") {
  const auto is_too_much = [](std::uint64_t bytes, const std::string& options) {
    Settings settings = one_worker();
    settings.max_memory_bytes = settings.max_heap_bytes * (settings.workers + kGuests) + bytes;
    Kept kept;
    Stand stand;
    stand.released = true;
    Bench bench(kept, stand, settings);
    Submission asked = submission("a", false);
    asked.request = got(api::parse_options(options));
    const auto job = begun(submit(bench.jobs, std::move(asked)));
    REQUIRE(job->wait_for_end(kLong));
    return job->view().row.problem.find("the comparison needs 24 bytes of memory") != std::string::npos;
  };
  CHECK_FALSE(is_too_much(23, "{}"));  // of them a job gets 21
  CHECK(is_too_much(23, R"({"areas": {"mean": true}})"));
  CHECK(is_too_much(23, R"({"gate": {"max_share_beyond": {"distance": 0.5, "share": 0.1}}})"));
  CHECK_FALSE(is_too_much(28, R"({"areas": {"mean": true}})"));
}

TEST_CASE("jobs: a durable job waits in the store alone, and its bytes exist when it runs") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto first = begun(submit(bench.jobs, submission("first", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  Submission second = submission("second", true);
  const std::weak_ptr<const void> bytes = second.a.holder;
  const auto waiting = begun(submit(bench.jobs, std::move(second)));
  CHECK(bytes.expired());
  CHECK(row_of(kept, waiting->key).state == JobState::queued);
  stand.released = true;
  REQUIRE(waiting->wait_for_end(kLong));
  const auto result = nlohmann::json::parse(row_of(kept, waiting->key).document);
  CHECK(result["meshes"]["a"]["bytes"] == std::string("second").size());
  CHECK(stand.order == std::vector<std::string>{"first.obj", "second.obj"});
}

TEST_CASE("jobs: the time of a durable job begins with its run, of an awaited one with its submission") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto first = begun(submit(bench.jobs, submission("first", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  const auto durable = begun(submit(bench.jobs, submission("durable", true)));
  const auto awaited = begun(submit(bench.jobs, submission("awaited", false)));
  std::this_thread::sleep_for(milliseconds(5));
  const auto released = Control::Clock::now();
  stand.released = true;
  REQUIRE(durable->wait_for_end(kLong));
  REQUIRE(awaited->wait_for_end(kLong));
  REQUIRE(stand.order.size() == 3);
  const std::size_t of_durable = stand.order[1] == "durable.obj" ? 1 : 2;
  CHECK(stand.deadlines[of_durable] >= released + durable->request.timeout);
  CHECK(stand.deadlines[3 - of_durable] < released + awaited->request.timeout);
}

TEST_CASE("jobs: one that waits for a thread ends when its time is over or its client has left, and frees its place") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto running = begun(submit(bench.jobs, submission("running", false)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  Submission hurried = submission("late", false);
  hurried.request.timeout = milliseconds(1);
  const auto late = begun(submit(bench.jobs, std::move(hurried)));
  CHECK(eventually([&] {
    bench.jobs.end_if_over(*late);
    return late->wait_for_end(milliseconds(0));
  }));
  CHECK(late->view().row.problem.find("timed out before a thread was free") != std::string::npos);
  CHECK(bench.jobs.figures().awaited_slots == 1);

  const auto left = begun(submit(bench.jobs, submission("left", false)));
  bench.jobs.end_if_over(*left);
  CHECK_FALSE(left->wait_for_end(milliseconds(0)));
  bench.jobs.abandon(left);
  bench.jobs.end_if_over(*left);
  CHECK(left->wait_for_end(milliseconds(0)));
  CHECK(bench.jobs.figures().awaited_slots == 1);
  CHECK(row_of(kept, left->key).state == JobState::failed);

  bench.jobs.end_if_over(*running);
  CHECK_FALSE(running->wait_for_end(milliseconds(0)));
  stand.released = true;
  REQUIRE(running->wait_for_end(kLong));
  CHECK(running->view().row.state == JobState::done);
  CHECK(stand.order == std::vector<std::string>{"running.obj"});
}

TEST_CASE("jobs: stored meshes are counted once, however many jobs name them") {
  Kept kept;
  Stand stand;
  Settings settings = one_worker();
  settings.max_stored_bytes = 1500 + 2 * kMeshOverhead;
  Bench bench(kept, stand, settings);
  for (int i = 0; i < 5; ++i) {
    Submission by_id = submission("", true);
    by_id.a = stored(kept, "a", std::string(500, 'a'));
    by_id.b = stored(kept, "b", std::string(500, 'b'));
    begun(submit(bench.jobs, std::move(by_id)));
  }
  begun(submit(bench.jobs, submission(std::string(400, 'c'), true)));  // and nine bytes of b
  CHECK(refusal_of(submit(bench.jobs, submission(std::string(400, 'd'), true))) == api::ProblemKind::quota_exceeded);
  stand.released = true;
}

TEST_CASE("jobs: a cancelled queued job gives its place back at once") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto first = begun(submit(bench.jobs, submission("first", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  const auto key = begun(submit(bench.jobs, submission("second", true)))->key;
  CHECK(bench.jobs.figures().durable_slots == 2);
  CHECK(got(bench.jobs.remove(key)) == Jobs::Deleted::asked_to_end);
  CHECK(bench.jobs.figures().durable_slots == 1);
  CHECK(bench.jobs.waiting() == 0);
  CHECK(got(bench.jobs.get(key))->row.state == JobState::cancelled);
  CHECK(got(bench.jobs.remove(key)) == Jobs::Deleted::forgotten);
  CHECK(got(bench.jobs.remove(key)) == Jobs::Deleted::unknown);
  CHECK(bench.metrics.text().find(R"(meshgauge_jobs_total{state="cancelled",status="early",strategy="auto"} 1)") !=
        std::string::npos);
  stand.released = true;
  CHECK(first->wait_for_end(kLong));
  CHECK(stand.running == 1);
}

TEST_CASE("jobs: a cancelled running job ends with its interval") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto job = begun(submit(bench.jobs, submission("a", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  CHECK(got(bench.jobs.remove(job->key)) == Jobs::Deleted::asked_to_end);
  REQUIRE(job->wait_for_end(kLong));
  CHECK(row_of(kept, job->key).state == JobState::cancelled);
  CHECK_FALSE(row_of(kept, job->key).document.empty());
}

TEST_CASE("jobs: an idempotency key is one job, also for concurrent requests") {
  Kept kept;
  Stand stand;
  Settings settings = one_worker();
  settings.workers = 4;
  Bench bench(kept, stand, settings);
  std::vector<std::future<std::string>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::async(std::launch::async, [&] {
      auto slot = bench.jobs.admit(Jobs::Kind::durable, "");
      const auto submitted = bench.jobs.submit(std::move(*slot), submission("a", true, "key"));
      const auto* job = std::get_if<std::shared_ptr<LiveJob>>(&submitted);
      return job ? (*job)->key.id : "";
    }));
  }
  std::set<std::string> ids;
  for (auto& client : clients) ids.insert(client.get());
  CHECK(ids.size() == 1);
  CHECK(refusal_of(submit(bench.jobs, submission("b", true, "key"))) == api::ProblemKind::idempotency_key_reused);
  stand.released = true;
  REQUIRE(eventually([&] { return bench.jobs.figures().durable_slots == 0; }));
  CHECK(stand.running == 1);
  const auto later = submit(bench.jobs, submission("a", true, "key"));
  REQUIRE(std::holds_alternative<JobView>(later));
  CHECK(std::get<JobView>(later).row.key.id == *ids.begin());
  CHECK(std::get<JobView>(later).row.state == JobState::done);
}

TEST_CASE("jobs: a full store refuses durable jobs and serves others") {
  Kept kept;
  Stand stand;
  stand.released = true;
  Bench bench(kept, stand);
  kept.jobs.full = true;
  CHECK(refusal_of(submit(bench.jobs, submission("a", true))) == api::ProblemKind::storage_full);
  const auto awaited = begun(submit(bench.jobs, submission("b", false)));
  REQUIRE(awaited->wait_for_end(kLong));
  CHECK(awaited->view().row.state == JobState::done);
  kept.jobs.full = false;
  CHECK(begun(submit(bench.jobs, submission("a", true)))->wait_for_end(kLong));
}

TEST_CASE("jobs: an end that cannot be stored is stored later") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto job = begun(submit(bench.jobs, submission("a", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  kept.jobs.full = true;
  stand.released = true;
  REQUIRE(eventually([&] { return kept.jobs.unfinished >= 1; }));
  CHECK(eventually([&] { return bench.jobs.figures().running == 0; }));
  CHECK(job->view().row.state == JobState::running);  // clients do not see an end that may be lost
  CHECK(row_of(kept, job->key).state == JobState::running);
  CHECK(bench.jobs.figures().durable_slots == 1);  // and its place is not free
  kept.jobs.full = false;
  REQUIRE(job->wait_for_end(kLong));
  CHECK(row_of(kept, job->key).state == JobState::done);
  CHECK(bench.jobs.figures().durable_slots == 0);
  CHECK(stand.running == 1);
}

TEST_CASE("jobs: a job that cannot begin while the store is full begins later, with its whole timeout") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto first = begun(submit(bench.jobs, submission("first", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  const auto second = begun(submit(bench.jobs, submission("second", true)));
  kept.jobs.full = true;
  stand.released = true;
  REQUIRE(eventually([&] { return kept.jobs.unfinished >= 1; }));
  CHECK(eventually([&] { return bench.jobs.figures().running == 0; }));
  CHECK(bench.jobs.figures().durable_slots == 2);  // both keep their places
  CHECK(second->view().row.state == JobState::queued);
  const auto room = Control::Clock::now();
  kept.jobs.full = false;
  REQUIRE(second->wait_for_end(kLong));
  CHECK(row_of(kept, second->key).state == JobState::done);
  CHECK(stand.deadlines[1] >= room + second->request.timeout);
}

TEST_CASE("jobs: a failing store is asked once a second, not once for each job") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  begun(submit(bench.jobs, submission("first", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  for (int i = 0; i < 20; ++i) begun(submit(bench.jobs, submission(std::to_string(i), true)));
  kept.jobs.full = true;
  stand.released = true;
  REQUIRE(eventually([&] { return kept.jobs.unfinished >= 1; }));
  const int before = kept.jobs.refused;
  REQUIRE(eventually([&] { return kept.jobs.refused >= before + 2; }));
  CHECK(kept.jobs.refused < before + 20);
  kept.jobs.full = false;
  CHECK(eventually([&] { return bench.jobs.figures().durable_slots == 0; }));
  CHECK(stand.running == 21);
}

TEST_CASE("jobs: the end of the service leaves running, queued and parked jobs to the next start") {
  Kept kept;
  Stand stand;
  std::vector<store::JobKey> keys;
  {
    Bench bench(kept, stand);
    keys.push_back(begun(submit(bench.jobs, submission("parked", true)))->key);
    REQUIRE(eventually([&] { return stand.running == 1; }));
    kept.jobs.full = true;
    stand.released = true;
    REQUIRE(eventually([&] { return kept.jobs.unfinished >= 1; }));
    stand.released = false;
    kept.jobs.full = false;
    // The parked job is stored before the end or runs again: it is not lost.
    keys.push_back(begun(submit(bench.jobs, submission("running", true)))->key);
    const auto waiting = begun(submit(bench.jobs, submission("waiting", true)));
    keys.push_back(waiting->key);
    REQUIRE(eventually([&] { return stand.running == 2; }));
    bench.jobs.stop();
    CHECK(waiting->wait_for_end(kLong));
    CHECK(waiting->view().handed_back);
    CHECK_FALSE(store::has_ended(waiting->view().row.state));
  }
  for (std::size_t i = 1; i < 3; ++i) CHECK(row_of(kept, keys[i]).state == JobState::queued);
  stand.released = true;
  Bench next(kept, stand);
  for (const auto& key : keys) {
    REQUIRE(eventually([&] { return row_of(kept, key).state == JobState::done; }));
  }
}

TEST_CASE("jobs: an end on a full disk loses no accepted job") {
  Kept kept;
  Stand stand;
  store::JobKey key;
  {
    Bench bench(kept, stand);
    key = begun(submit(bench.jobs, submission("a", true)))->key;
    REQUIRE(eventually([&] { return stand.running == 1; }));
    kept.jobs.full = true;
    bench.jobs.stop();
  }
  CHECK(row_of(kept, key).state == JobState::running);
  kept.jobs.full = false;
  stand.released = true;
  Bench next(kept, stand);
  REQUIRE(eventually([&] { return row_of(kept, key).state == JobState::done; }));
}

TEST_CASE("jobs: a job that ends during the shutdown is done, and not run again") {
  Kept kept;
  Stand stand;
  stand.deaf = true;
  store::JobKey key;
  {
    Bench bench(kept, stand);
    Submission content_with_any = submission("a", true);  // it converges before it notices the cancel
    content_with_any.options = R"({"tolerance":{"absolute":100}})";
    key = begun(submit(bench.jobs, std::move(content_with_any)))->key;
    REQUIRE(eventually([&] { return stand.running == 1; }));
    std::thread end([&] { bench.jobs.stop(); });
    CHECK(eventually([&] { return bench.jobs.stopping(); }));
    stand.released = true;
    end.join();
  }
  CHECK(row_of(kept, key).state == JobState::done);
}

TEST_CASE("jobs: a job runs again within the limits of the settings, and with the cached mesh") {
  Kept kept;
  Stand stand;
  Settings settings = one_worker();
  settings.max_heap_bytes = 3 << 20;
  std::shared_ptr<LiveJob> first;
  std::string simd;
  {
    Bench bench(kept, stand, settings);
    first = begun(submit(bench.jobs, submission("a", true)));
    simd = first->request.options.simd;  // borrowed from the bench
    REQUIRE(eventually([&] { return stand.running == 1; }));
  }
  const auto again = live_job_of(row_of(kept, first->key), settings);
  CHECK(again->request.options.max_memory_bytes == first->request.options.max_memory_bytes);
  CHECK(again->request.options.simd == simd);
  stand.released = true;
  Bench next(kept, stand, settings);
  REQUIRE(eventually([&] { return stand.running == 2; }));
  CHECK(eventually([&] { return next.jobs.figures().durable_slots == 0; }));
}

TEST_CASE("jobs: a job with unusable meshes or options fails, and says why") {
  Kept kept;
  const auto now = store::now();
  for (const char* options : {"{}", R"({"no such option": 1})"}) {
    store::NewJob row = store::new_job("", std::string("job ") + options);
    row.options = options;
    row.created = now;
    row.expires_if_never_run = now + kLong;
    got(kept.embedded.jobs().insert(row));
  }
  Stand stand;
  stand.released = true;
  Bench bench(kept, stand);
  const auto problem = [&](const std::string& options) {
    const store::JobKey key{"", "job " + options};
    REQUIRE(eventually([&] { return row_of(kept, key).state == JobState::failed; }));
    return nlohmann::json::parse(row_of(kept, key).problem)["detail"].get<std::string>();
  };
  CHECK(problem("{}").find("was removed before it could run") != std::string::npos);
  CHECK(problem(R"({"no such option": 1})").find("no such option") != std::string::npos);
  CHECK(stand.running == 0);
}

TEST_CASE("jobs: a job that ends its process five times fails with its last error") {
  Kept kept;
  const auto now = store::now();
  store::NewJob row = store::new_job("", "poison");
  row.expires_if_never_run = now + kLong;
  got(kept.embedded.jobs().insert(row));
  for (unsigned i = 0; i < store::kMaxTries; ++i) {
    if (i > 0) got(kept.embedded.jobs().recover("", "it was killed", {now, now + kLong}));
    REQUIRE(store::claim_one(kept.embedded.jobs(), row.key, "a process that dies", now, now + kLong).has_value());
  }
  Stand stand;
  Bench bench(kept, stand);
  CHECK(bench.jobs.waiting() == 0);
  CHECK(stand.running == 0);
  CHECK(got(bench.jobs.get(row.key))->row.state == JobState::failed);
  CHECK(row_of(kept, row.key).last_error == "the service ended while it ran");
}
