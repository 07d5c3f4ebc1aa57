// Recovery, counts and sweeps.
#include <set>

#include "batch_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

TEST_CASE_TEMPLATE("jobs: recovery requeues the jobs of dead workers alone", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  for (const char* id : {"dead", "late", "alive", "waits", "poison", "cancelled"}) {
    NewJob job = new_job("ann", id);
    if (job.key.id == "waits") job.created = at(-10);
    insert(jobs, job);
  }
  for (unsigned i = 1; i < kMaxTries; ++i) got(jobs.hand_back(claimed_token(jobs, {"ann", "poison"}), "x", kNow));
  claimed_token(jobs, {"ann", "dead"}, "host-a/1");
  claimed_token(jobs, {"ann", "poison"}, "host-a/2");
  claimed_token(jobs, {"ann", "cancelled"}, "host-a/3");
  claimed_token(jobs, {"ann", "late"}, "host-b/1");
  const Token alive = claimed_token(jobs, {"ann", "alive"}, "host-b/2");
  got(heartbeat(jobs, alive, at(500), {}));
  got(jobs.request_cancel({"ann", "cancelled"}, kNow));
  const unsigned tries = job_in(jobs, {"ann", "dead"}).tries;

  stores.reopen();
  const Moment moment{at(200), at(1200)};
  std::vector<std::string> again;
  for (const Job& job : got(stores.jobs().recover("host-a/", "the service ended while it ran", moment))) {
    CHECK(job.state == JobState::queued);
    again.push_back(job.key.id);
  }
  if (Stores::kListsRecovered) CHECK(again == std::vector<std::string>{"waits", "dead"});
  CHECK(job_in(stores.jobs(), {"ann", "late"}).state == JobState::running);  // another worker's, whatever its lease
  got(stores.jobs().recover(std::nullopt, "its lease was over", moment));
  for (const char* id : {"waits", "dead", "late"}) CHECK(job_in(stores.jobs(), {"ann", id}).state == JobState::queued);
  CHECK(job_in(stores.jobs(), {"ann", "dead"}).tries == tries);
  CHECK(job_in(stores.jobs(), {"ann", "alive"}).state == JobState::running);
  CHECK(job_in(stores.jobs(), {"ann", "cancelled"}).state == JobState::cancelled);
  const Job poison = job_in(stores.jobs(), {"ann", "poison"});
  CHECK(poison.state == JobState::failed);
  CHECK(poison.last_error == "the service ended while it ran");
  CHECK(poison.finished == at(200));
  CHECK(poison.expires == at(1200));

  got(stores.jobs().recover(std::nullopt, "x", moment));  // no worker is dead, no lease has expired
  CHECK(got(stores.jobs().counts()).queued == 3);
  CHECK(job_in(stores.jobs(), {"ann", "alive"}).state == JobState::running);
  got(stores.jobs().recover("", "x", moment));  // all workers are dead
  CHECK(got(stores.jobs().counts()).queued == 4);
}

TEST_CASE_TEMPLATE("jobs: counts, and the blobs in use", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  for (int i = 0; i < 6; ++i) {
    NewJob job = new_job(i < 5 ? "ann" : "bob", std::to_string(i));
    job.mesh_a = "a" + std::to_string(i);
    job.mesh_b = "shared";
    insert(jobs, job);
  }
  claimed_token(jobs, {"ann", "0"});
  got(finish(jobs, claimed_token(jobs, {"ann", "1"}), ending()));
  got(finish(jobs, claimed_token(jobs, {"ann", "2"}), ending(JobState::failed)));
  got(jobs.request_cancel({"ann", "3"}, kNow));
  const Counts counts = got(jobs.counts());
  CHECK(counts.queued == 2);
  CHECK(counts.running == 1);
  CHECK(counts.done == 1);
  CHECK(counts.failed == 1);
  CHECK(counts.cancelled == 1);
  MeshRow mesh;
  mesh.key = {"ann", "mesh"};
  got(stores.meshes().put_mesh(mesh, {1000}));
  std::set<std::string> used;
  const std::vector<BlobKey> keys = got(jobs.used_blobs());
  for (const BlobKey& key : keys) used.insert(key.owner + " " + key.id);
  CHECK(used == std::set<std::string>{"ann a0", "ann a4", "ann shared", "bob a5", "bob shared", "ann mesh"});
  CHECK(keys.size() == used.size());
  for (const BlobKey& key : keys) CHECK(got(jobs.uses_blob(key)));
  for (const BlobKey& key : {BlobKey{"ann", "a1"}, {"ann", "a3"}, {"bob", "mesh"}, {"", "shared"}}) {
    CHECK_FALSE(got(jobs.uses_blob(key)));
  }
}

TEST_CASE_TEMPLATE("jobs: the sweep removes expired ones, and the oldest beyond the cap", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  for (int i = 0; i < 1300; ++i) {
    Job job = ended_job("ann", std::to_string(i), at(1300 - i));  // the last one is the oldest
    job.expires = i < 20 ? at(2000) : at(3000);
    jobs.record(job);
    if (i % 50 == 49) got(jobs.flush());
  }
  got(jobs.flush());
  insert(jobs, new_job("ann", "stale"));
  NewJob fresh = new_job("ann", "fresh");
  fresh.expires_if_never_run = at(9000);
  insert(jobs, fresh);
  NewJob runs = new_job("ann", "runs");
  insert(jobs, runs);
  claimed_token(jobs, runs.key);

  const Moment moment{at(4000), at(9000)};
  const SweptJobs none = got(jobs.sweep_jobs({at(1999), at(9000)}, 1300));
  CHECK(none.expired == 0);
  CHECK(none.over_cap == 0);
  CHECK(none.given_up == 0);
  const SweptJobs some = got(jobs.sweep_jobs({at(2000), at(9000)}, 1270));
  CHECK(some.expired == 20);
  CHECK(some.over_cap == 10);
  CHECK_FALSE(got(jobs.get({"ann", "0"})).has_value());
  CHECK_FALSE(got(jobs.get({"ann", "1299"})).has_value());
  CHECK(got(jobs.get({"ann", "1289"})).has_value());
  const SweptJobs given_up = got(jobs.sweep_jobs(moment, 5));
  CHECK(given_up.given_up == 1);
  CHECK(given_up.expired == 1270);
  const Job stale = job_in(jobs, {"ann", "stale"});
  CHECK(stale.state == JobState::failed);
  CHECK(stale.finished == at(4000));
  CHECK_FALSE(stale.last_error.empty());
  CHECK(job_in(jobs, {"ann", "fresh"}).state == JobState::queued);
  CHECK(job_in(jobs, {"ann", "runs"}).state == JobState::running);
  CHECK(got(jobs.sweep_jobs(moment, 0)).over_cap == 1);
}

TEST_CASE_TEMPLATE("jobs: owners lose what is beyond their share, and owners below it lose nothing", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  const auto record = [&](const std::string& owner, int number, int first_second) {
    for (int i = 0; i < number; ++i) jobs.record(ended_job(owner, std::to_string(i), at(first_second + i)));
    got(jobs.flush());
  };
  const auto has = [&](const std::string& owner, int i) {
    return got(jobs.get({owner, std::to_string(i)})).has_value();
  };
  record("little", 10, 0);  // the oldest of all
  record("some", 30, 50);
  record("much", 40, 100);
  CHECK(got(jobs.sweep_jobs({at(500), at(600)}, 80)).over_cap == 0);
  CHECK(got(jobs.sweep_jobs({at(500), at(600)}, 60)).over_cap == 20);  // 10, 25 and 25 are left
  for (int i = 0; i < 10; ++i) CHECK(has("little", i));
  for (int i = 0; i < 30; ++i) CHECK(has("some", i) == (i >= 5));
  for (int i = 0; i < 40; ++i) CHECK(has("much", i) == (i >= 15));
  CHECK(got(jobs.sweep_jobs({at(500), at(600)}, 9)).over_cap == 51);  // three each
  for (const char* owner : {"little", "some", "much"}) {
    int left = 0;
    for (int i = 0; i < 40; ++i) left += has(owner, i);
    CHECK(left == 3);
  }
}

TEST_CASE_TEMPLATE("jobs: a check writes", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  got(stores.jobs().check());
  got(stores.jobs().check());
  got(stores.blobs().check());
}

TEST_CASE_TEMPLATE("jobs: an owner's unended jobs are counted", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  const auto unended = [&](const std::string& owner) { return got(jobs.unended(owner, at(50))); };
  CHECK(unended("ann") == 0);
  for (const std::string id : {"1", "2", "3", "4"}) insert(jobs, new_job("ann", id));
  insert(jobs, new_job("bob", "1"));
  insert(stores.batches(), new_batch("ann", "b", 3));
  NewJob awaited = new_job("ann", "in time");
  awaited.deadline = at(51);
  insert(jobs, awaited);
  awaited.key.id = "too late";
  awaited.deadline = at(50);
  insert(jobs, awaited);
  jobs.record(ended_job("ann", "recorded"));
  CHECK(unended("ann") == 5);
  CHECK(unended("bob") == 1);
  const Token running = claimed_token(jobs, {"ann", "1"});
  CHECK(unended("ann") == 5);
  end(jobs, {"ann", "2"}, ending());
  CHECK(unended("ann") == 4);
  got(jobs.request_cancel({"ann", "3"}, kNow));
  CHECK(unended("ann") == 3);
  got(jobs.request_cancel({"ann", "1"}, kNow));  // runs, and is to be cancelled
  CHECK(unended("ann") == 2);
  CHECK(got(finish(jobs, running, ending(JobState::cancelled))));
  CHECK(unended("ann") == 2);
}
