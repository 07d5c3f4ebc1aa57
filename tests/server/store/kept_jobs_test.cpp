#include "server/store/job_store.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <set>
#include <thread>

#include "implementations.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

const Moment kNow{at(100), at(1100)};

Job job_in(JobStore& jobs, const JobKey& key) {
  const std::optional<Job> job = got(jobs.get(key));
  REQUIRE(job.has_value());
  return *job;
}

Token claimed_token(JobStore& jobs, const JobKey& key, const std::string& worker = "w1") {
  const std::optional<Claimed> claimed = got(jobs.claim(key, worker, at(50), at(110)));
  REQUIRE(claimed.has_value());
  return claimed->token;
}

void insert(JobStore& jobs, const NewJob& job) { REQUIRE(!got(jobs.insert(job)).existed); }

Ending ending(JobState state = JobState::done) { return {state, "{\"d\":1}", "", at(120), at(1120)}; }

}  // namespace

TEST_CASE_TEMPLATE("jobs: recorded ones are known at once and durable after flush", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  Job job = ended_job("ann", "1");
  job.progress = Progress{1, 2, "certify"};
  job.problem = "{}";
  stores.jobs().record(job);
  CHECK(got(stores.jobs().request_cancel(job.key, kNow)) == JobState::done);
  for (int round = 0; round < 3; ++round) {
    const Job read = job_in(stores.jobs(), job.key);
    CHECK(read.state == JobState::done);
    CHECK(read.document == job.document);
    CHECK(read.problem == "{}");
    CHECK(read.started == at(5));
    CHECK(read.finished == at(10));
    CHECK(read.expires == at(1000));
    CHECK(read.progress == job.progress);
    CHECK(read.tries == 1);
    CHECK_FALSE(got(stores.jobs().get({"bob", "1"})).has_value());
    if (round == 0) got(stores.jobs().flush());
    if (round == 1) stores.reopen();
  }
  CHECK(got(stores.jobs().counts()).done == 1);
  CHECK(got(stores.jobs().counts()).unrecorded == 0);
  stores.jobs().record(ended_job("ann", "2"));
  CHECK(got(stores.jobs().forget({"ann", "2"})));  // though it may not be written yet
  stores.jobs().record(ended_job("ann", "3"));
  stores.reopen();  // an end in good order writes it
  CHECK_FALSE(got(stores.jobs().get({"ann", "2"})).has_value());
  CHECK(got(stores.jobs().get({"ann", "3"})).has_value());
}

TEST_CASE_TEMPLATE("jobs: counts and what they refer to", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  for (int i = 0; i < 6; ++i) {
    NewJob job = new_job(i < 5 ? "ann" : "bob", std::to_string(i));
    job.mesh_a = "a" + std::to_string(i);
    job.mesh_b = "shared";
    insert(jobs, job);
  }
  claimed_token(jobs, {"ann", "0"});
  got(jobs.finish(claimed_token(jobs, {"ann", "1"}), ending()));
  got(jobs.finish(claimed_token(jobs, {"ann", "2"}), ending(JobState::failed)));
  got(jobs.request_cancel({"ann", "3"}, kNow));
  const Counts counts = got(jobs.counts());
  CHECK(counts.queued == 2);
  CHECK(counts.running == 1);
  CHECK(counts.done == 1);
  CHECK(counts.failed == 1);
  CHECK(counts.cancelled == 1);
  MeshRow mesh;
  mesh.key = {"ann", "mesh"};
  got(stores.meshes().put_mesh(mesh, 1000));
  std::set<std::string> used;
  const std::vector<BlobKey> keys = got(jobs.used_blobs());
  for (const BlobKey& key : keys) used.insert(key.owner + " " + key.id);
  CHECK(used == std::set<std::string>{"ann a0", "ann a4", "ann shared", "bob a5", "bob shared", "ann mesh"});
  CHECK(keys.size() == used.size());
}

TEST_CASE_TEMPLATE("jobs: the sweep removes what is over, and the oldest beyond the cap", Stores,
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

TEST_CASE_TEMPLATE("jobs: a check writes", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  got(stores.jobs().check());
  got(stores.jobs().check());
  got(stores.blobs().check());
}
