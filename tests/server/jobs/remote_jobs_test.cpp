// Jobs of front ends, which other processes run.
#include "server/jobs/jobs.h"

#include <fstream>
#include <set>

#include "shared_bench.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::got;
using store::JobState;

namespace {

store::Job row_in(Common& common, const store::JobKey& key) {
  const auto row = got(common.embedded.jobs().get(key));
  REQUIRE(row.has_value());
  return *row;
}

Submission keyed(const std::string& a, const std::string& key) { return submission(a, true, key); }

}  // namespace

TEST_CASE("front ends: an awaited comparison goes through the store with its deadline, and comes back unchanged") {
  Common common;
  common.jobs.ahead = std::chrono::hours(1);
  FrontEnd front(common);
  Hands hands(common);
  const auto job = begun(submit(*front.jobs, submission("a", false)));
  CHECK_FALSE(job->durable);
  CHECK(front.jobs->figures().awaited_slots == 1);
  const auto claimed = hands.claim();
  CHECK(claimed.job.key == job->key);
  CHECK(*claimed.job.deadline == claimed.job.created + job->request.timeout);
  CHECK(claimed.job.created > store::now() + std::chrono::minutes(50));  // by the store's clock
  CHECK(store::text_of(got(common.embedded.blobs().open({"", claimed.job.mesh_a})).value()) == "a");
  hands.finish(claimed);
  REQUIRE(job->wait_for_end(kLong));
  CHECK(front.jobs->figures().awaited_slots == 0);
  CHECK(job->view().row.document == Hands::document_of(job->key.id));
  CHECK(job->view().timing == "queue;dur=1.500, total;dur=2.250");
  CHECK(got(front.jobs->get(job->key))->row.document == job->view().row.document);
}

TEST_CASE("front ends: a problem comes back unchanged") {
  Common common;
  FrontEnd front(common);
  Hands hands(common);
  const auto job = begun(submit(*front.jobs, submission("a", false)));
  hands.finish(hands.claim(), JobState::failed, R"({"status":422})");
  REQUIRE(job->wait_for_end(kLong));
  CHECK(job->view().row.problem == R"({"status":422})");
  CHECK(job->view().row.document.empty());
}

TEST_CASE("front ends: each answers for the jobs of all") {
  Common common;
  FrontEnd one(common), other(common);
  Hands hands(common);
  const auto key = begun(submit(*one.jobs, keyed("a", "key")))->key;
  CHECK(got(other.jobs->get(key))->row.state == JobState::queued);
  CHECK_FALSE(got(other.jobs->get({"another", key.id})).has_value());
  const auto same = begun(submit(*other.jobs, keyed("a", "key")));
  CHECK(same->key == key);
  CHECK(refusal_of(submit(*other.jobs, keyed("b", "key"))) == api::ProblemKind::idempotency_key_reused);
  const auto claimed = hands.claim();
  hands.beat(claimed, {1, 2, "reduce"});
  const auto watched = other.jobs->watch(*got(other.jobs->get(key)));
  CHECK(watched == same);
  REQUIRE(eventually([&] { return same->view().row.progress.has_value(); }));
  hands.finish(claimed);
  REQUIRE(same->wait_for_end(kLong));
  CHECK(other.jobs->watch(*got(other.jobs->get(key))) == nullptr);
  const auto later = submit(*other.jobs, keyed("a", "key"));
  REQUIRE(std::holds_alternative<JobView>(later));
  CHECK(std::get<JobView>(later).row.state == JobState::done);
}

TEST_CASE("front ends: any of them cancels a queued job at once, and removes it at the next request") {
  Common common;
  FrontEnd one(common), other(common);
  const auto job = begun(submit(*one.jobs, submission("a", true)));
  CHECK(got(other.jobs->remove(job->key)) == Jobs::Deleted::asked_to_end);
  CHECK(row_in(common, job->key).state == JobState::cancelled);
  CHECK(other.counted_early(1));
  REQUIRE(job->wait_for_end(kLong));
  CHECK(got(one.jobs->remove(job->key)) == Jobs::Deleted::forgotten);
  CHECK(got(other.jobs->remove(job->key)) == Jobs::Deleted::unknown);
}

TEST_CASE("front ends: a running job is cancelled by its worker") {
  Common common;
  FrontEnd one(common), other(common);
  Hands hands(common);
  const auto job = begun(submit(*one.jobs, submission("a", true)));
  const auto claimed = hands.claim();
  CHECK(got(other.jobs->remove(job->key)) == Jobs::Deleted::asked_to_end);
  CHECK(got(other.jobs->get(job->key))->row.cancel_requested);
  CHECK(hands.beat(claimed, {0, 1, ""}) == store::Heartbeat::cancel);
  hands.finish(claimed, JobState::cancelled);
  REQUIRE(job->wait_for_end(kLong));
  CHECK(job->view().row.state == JobState::cancelled);
  CHECK_FALSE(job->view().row.document.empty());
}

TEST_CASE("front ends: a client that disconnects ends a job that it alone waited for, and frees its place at once") {
  Common common;
  FrontEnd front(common);
  auto job = begun(submit(*front.jobs, submission("a", false)));
  const auto key = job->key;
  CHECK(front.jobs->abandon(job));
  CHECK(front.jobs->figures().awaited_slots == 0);
  job.reset();
  CHECK(eventually([&] { return row_in(common, key).state == JobState::cancelled; }));
  CHECK(eventually([&] { return front.counted_early(1); }));
}

TEST_CASE("front ends: each counts its waiting clients, all together count durable jobs") {
  Common common;
  Settings settings = of_front_end();
  settings.max_queued_jobs = 3;
  FrontEnd one(common, settings), other(common, settings);
  for (int i = 0; i < 2; ++i) begun(submit(*one.jobs, submission(std::to_string(i), true)));
  const auto last = one.jobs->admit(Jobs::Kind::durable, "");
  CHECK(last.has_value());
  CHECK_FALSE(one.jobs->admit(Jobs::Kind::durable, "").has_value());
  REQUIRE(eventually([&] { return other.jobs->figures().durable_slots == 2; }));
  begun(submit(*other.jobs, submission("2", true)));
  CHECK_FALSE(other.jobs->admit(Jobs::Kind::durable, "").has_value());
  REQUIRE(eventually([&] { return other.jobs->store_queue()->counts().queued == 3; }));
  std::vector<Scheduler::Slot> slots;
  for (int i = 0; i < 4; ++i) {
    auto slot = other.jobs->admit(Jobs::Kind::awaited, std::to_string(i));  // the share of one is three of them
    REQUIRE(slot.has_value());
    slots.push_back(std::move(*slot));
  }
  CHECK_FALSE(other.jobs->admit(Jobs::Kind::awaited, "").has_value());
  CHECK(one.jobs->admit(Jobs::Kind::awaited, "").has_value());
}

TEST_CASE("front ends: queued jobs of batches and waiting clients keep no durable job out") {
  Common common;
  Settings settings = of_front_end();
  settings.max_queued_jobs = 1;
  FrontEnd front(common, settings);
  store::NewJob item = store::new_job("", "item");
  item.batch = "batch";
  item.expires_if_never_run = common.jobs.time() + kLong;
  got(common.jobs.insert(item));
  begun(submit(*front.jobs, submission("awaited", false)));
  REQUIRE(eventually([&] { return front.jobs->store_queue()->counts().queued == 2; }));
  CHECK(front.jobs->figures().durable_slots == 0);
  CHECK(front.jobs->admit(Jobs::Kind::durable, "").has_value());
}

TEST_CASE("front ends: while the store is away they refuse without asking it, and then go on") {
  Common common;
  FrontEnd front(common);
  Hands hands(common);
  const auto job = begun(submit(*front.jobs, submission("a", false)));
  common.jobs.gone = true;
  REQUIRE(eventually([&] { return !front.jobs->available().ok(); }));
  CHECK(front.jobs->available().error().code == ErrorCode::storage_unavailable);
  CHECK(refusal_of(submit(*front.jobs, submission("b", false))) == api::ProblemKind::storage_unavailable);
  CHECK_FALSE(front.jobs->get(job->key).ok());
  CHECK_FALSE(front.jobs->give_up(*job).has_value());  // a waiting client may wait until its deadline
  common.jobs.gone = false;
  REQUIRE(eventually([&] { return front.jobs->available().ok(); }));
  hands.finish(hands.claim());
  CHECK(job->wait_for_end(kLong));
}

TEST_CASE("front ends: a client that waits in vain gets its answer soon after its deadline") {
  Common common;
  FrontEnd front(common);
  Submission asked = submission("a", false);
  asked.request.timeout = milliseconds(1);
  const auto job = begun(submit(*front.jobs, std::move(asked)));
  std::optional<api::Problem> problem;
  REQUIRE(eventually([&] { return (problem = front.jobs->give_up(*job)).has_value(); }));
  CHECK(problem->kind == api::ProblemKind::out_of_time);
  const auto durable = begun(submit(*front.jobs, submission("b", true)));
  CHECK_FALSE(front.jobs->give_up(*durable).has_value());
}

TEST_CASE("front ends: uploads of an ended comparison are removed if nothing else needs them") {
  Common common;
  FrontEnd front(common);
  Hands hands(common);
  const auto there = [&](const std::string& text) {
    return got(common.embedded.blobs().exists(store::key_of("", text)));
  };
  const auto first = begun(submit(*front.jobs, submission("first", false)));
  const auto second = begun(submit(*front.jobs, submission("second", true)));
  const auto claimed = hands.claim();
  const std::string ended = claimed.job.key == first->key ? "first" : "second";
  hands.finish(claimed);
  REQUIRE(eventually([&] { return !there(ended); }));
  CHECK(there(ended == "first" ? "second" : "first"));
  CHECK(there("the other"));
  hands.finish(hands.claim());
  CHECK(eventually([&] { return !there("first") && !there("second") && !there("the other"); }));
}

TEST_CASE("front ends: a shutdown ends what its clients wait for and leaves the rest to the others") {
  Common common;
  std::optional<FrontEnd> front(std::in_place, common);
  const auto awaited = begun(submit(*front->jobs, submission("awaited", false)));
  const auto durable = begun(submit(*front->jobs, submission("durable", true)));
  const store::JobKey keys[] = {awaited->key, durable->key};
  front->jobs->stop();
  for (const auto& job : {awaited, durable}) {
    REQUIRE(job->wait_for_end(kLong));
    CHECK(job->view().handed_back);
  }
  front.reset();
  CHECK(row_in(common, keys[0]).state == JobState::cancelled);
  CHECK(row_in(common, keys[1]).state == JobState::queued);
}

TEST_CASE("front ends: the one on duty requeues jobs that lost their worker") {
  Common common;
  Settings settings = of_front_end();
  settings.lease_ms = 100;
  settings.heartbeat_ms = 10;
  FrontEnd front(common, settings);
  const auto job = begun(submit(*front.jobs, submission("a", true)));
  const auto now = common.jobs.time();
  store::claim_one(common.jobs, job->key, "a worker that dies", now, now + milliseconds(1));
  REQUIRE(eventually([&] { return job->view().row.state == JobState::running; }));
  common.jobs.duty = true;
  CHECK(eventually([&] { return row_in(common, job->key).state == JobState::queued; }));
  CHECK(row_in(common, job->key).last_error == "its worker sent no heartbeat before its lease expired");
}

namespace {

// A file with one key, "ci", with a limit of jobs.
struct Keys {
  explicit Keys(int max_jobs) {
    std::ofstream(file()) << R"({"keys":[{"id":"ci","sha256":")" << std::string(64, 'a') << R"(","max_jobs":)"
                          << max_jobs << "}]}";
  }
  std::string file() const { return folder / "keys.json"; }

  store::TestFolder folder;
};

Submission of_ci(const std::string& a, const std::string& idempotency_key = "") {
  Submission asked = submission(a, true, idempotency_key);
  asked.key.owner = "ci";
  return asked;
}

}  // namespace

TEST_CASE("front ends: the limit of a key holds for all of them together") {
  Common common;
  const Keys keys(2);
  FrontEnd one(common, of_front_end(), keys.file()), other(common, of_front_end(), keys.file());
  Hands hands(common);
  begun(submit(*one.jobs, of_ci("a")));
  begun(submit(*other.jobs, of_ci("b")));
  for (FrontEnd* front : {&one, &other}) {
    CHECK(refusal_of(submit(*front->jobs, of_ci("c"))) == api::ProblemKind::too_many_requests);
  }
  CHECK_FALSE(got(common.embedded.blobs().exists(store::key_of("ci", "c"))));  // nothing of it is left
  CHECK(got(common.embedded.jobs().counts()).queued == 2);
  hands.finish(hands.claim());
  begun(submit(*other.jobs, of_ci("c")));
  CHECK(refusal_of(submit(*one.jobs, of_ci("d"))) == api::ProblemKind::too_many_requests);
  common.jobs.gone = true;
  CHECK(refusal_of(submit(*one.jobs, of_ci("e"))) == api::ProblemKind::storage_unavailable);
}

TEST_CASE("front ends: concurrent submissions pass the limit by less than one for each front end") {
  Common common;
  const Keys keys(4);
  Settings settings = of_front_end();
  settings.max_queued_jobs = 1000;
  FrontEnd one(common, settings, keys.file()), two(common, settings, keys.file()), three(common, settings, keys.file());
  std::vector<std::thread> clients;
  std::atomic<int> refused{0};
  for (FrontEnd* front : {&one, &two, &three}) {
    for (int client = 0; client < 6; ++client) {
      clients.emplace_back([front, client, &refused] {
        auto slot = front->jobs->admit(Jobs::Kind::durable, "");
        if (!slot) return;
        const auto submitted = front->jobs->submit(std::move(*slot), of_ci("mesh " + std::to_string(client)));
        if (std::holds_alternative<Denial>(submitted)) ++refused;
      });
    }
  }
  for (std::thread& client : clients) client.join();
  const auto queued = got(common.embedded.jobs().counts()).queued;
  CHECK(queued >= 4);
  CHECK(queued <= 4 + 2);
  CHECK(queued + static_cast<std::uint64_t>(refused) == 18);
}

TEST_CASE("front ends: a repetition finds its job though that fills the key's limit") {
  Common common;
  const Keys keys(1);
  FrontEnd one(common, of_front_end(), keys.file()), other(common, of_front_end(), keys.file());
  const auto first = begun(submit(*one.jobs, of_ci("a", "k")));
  for (FrontEnd* front : {&one, &other}) {
    CHECK(begun(submit(*front->jobs, of_ci("a", "k")))->key == first->key);
    CHECK(refusal_of(submit(*front->jobs, of_ci("b", "k"))) == api::ProblemKind::idempotency_key_reused);
    CHECK(refusal_of(submit(*front->jobs, of_ci("a", "l"))) == api::ProblemKind::too_many_requests);
    CHECK(refusal_of(submit(*front->jobs, of_ci("a"))) == api::ProblemKind::too_many_requests);
  }
  CHECK(got(common.embedded.jobs().counts()).queued == 1);
}

TEST_CASE("front ends: a repetition before the job is stored finds it, though that fills the limit") {
  Common common;
  const Keys keys(1);
  FrontEnd front(common, of_front_end(), keys.file());
  std::mutex mutex;
  std::multiset<std::string> ids;
  std::vector<std::thread> clients;
  for (int client = 0; client < 8; ++client) {
    clients.emplace_back([&] {
      auto slot = front.jobs->admit(Jobs::Kind::durable, "");
      if (!slot) return;
      const auto submitted = front.jobs->submit(std::move(*slot), of_ci("a", "k"));
      const auto* job = std::get_if<std::shared_ptr<LiveJob>>(&submitted);
      const std::lock_guard lock(mutex);
      ids.insert(job ? (*job)->key.id : "denied");
    });
  }
  for (std::thread& client : clients) client.join();
  REQUIRE(ids.size() == 8);
  CHECK(ids.count(*ids.begin()) == 8);
  CHECK(*ids.begin() != "denied");
}

TEST_CASE("front ends: upkeep goes on while many meshes are removed") {
  constexpr int kJobs = 40;
  Common common;
  Settings settings = of_front_end();
  settings.lease_ms = 100;
  settings.heartbeat_ms = 10;
  FrontEnd front(common, settings);
  Hands hands(common);
  std::vector<std::shared_ptr<LiveJob>> jobs;
  for (int i = 0; i < kJobs; ++i) {
    jobs.push_back(begun(submit(*front.jobs, submission("mesh " + std::to_string(i), true))));
  }
  common.jobs.look_takes = milliseconds(200);
  for (int i = 0; i < kJobs; ++i) hands.finish(hands.claim());
  for (const auto& job : jobs) REQUIRE(job->wait_for_end(kLong));
  const auto lost = begun(submit(*front.jobs, submission("of a worker that dies", true)));
  const auto now = common.jobs.time();
  store::claim_one(common.jobs, lost->key, "a worker that dies", now, now + milliseconds(1));
  REQUIRE(eventually([&] { return common.jobs.looks >= 4; }));
  common.jobs.duty = true;
  REQUIRE(eventually([&] { return row_in(common, lost->key).state == JobState::queued; }));
  CHECK(common.jobs.looks < 2 * kJobs);
  common.jobs.look_takes = milliseconds(0);
  CHECK(eventually([&] { return common.jobs.looks >= 2 * kJobs; }));
}
