#include "server/store/job_store.h"

#include <atomic>
#include <limits>
#include <set>
#include <thread>

#include "job_steps.h"

using meshgauge::Error;
using meshgauge::ErrorCode;
using meshgauge::Result;
using namespace meshgauge::server::store;

TEST_CASE_TEMPLATE("jobs: an inserted job is read back, also after a restart", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewJob job = new_job("ann", "1");
  job.idempotency_key = "k";
  job.hints = std::string("nothing is \0 special: ' \" \xff \n", 30);
  const Inserted inserted = got(stores.jobs().insert(job));
  CHECK_FALSE(inserted.existed);
  CHECK_FALSE(inserted.conflict);
  for (int restart = 0; restart < 2; ++restart) {
    for (const Job& read :
         {job_in(stores.jobs(), job.key), *got(stores.jobs().find_idempotent("ann", "k")), inserted.job}) {
      CHECK(read.key == job.key);
      CHECK(read.mesh_a == job.mesh_a);
      CHECK(read.mesh_b == job.mesh_b);
      CHECK(read.hints == job.hints);
      CHECK(read.options == job.options);
      CHECK(read.cost == 1000);
      CHECK(read.idempotency_key == "k");
      CHECK(read.fingerprint == job.fingerprint);
      CHECK(read.trace == job.trace);
      CHECK(read.created == at(0));
      CHECK(read.expires_if_never_run == at(3600));
      CHECK(read.state == JobState::queued);
      CHECK(read.tries == 0);
      CHECK_FALSE(read.cancel_requested);
      CHECK_FALSE(read.started.has_value());
      CHECK_FALSE(read.finished.has_value());
      CHECK_FALSE(read.expires.has_value());
      CHECK_FALSE(read.progress.has_value());
      CHECK(read.document.empty());
      CHECK(read.problem.empty());
    }
    stores.reopen();
  }
}

TEST_CASE_TEMPLATE("jobs: another owner's jobs are not visible", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewJob job = new_job("ann", "1");
  job.idempotency_key = "k";
  insert(stores.jobs(), job);
  for (const std::string owner : {"", "bob", "an"}) {
    const JobKey key{owner, "1"};
    CHECK_FALSE(got(stores.jobs().get(key)).has_value());
    CHECK_FALSE(got(stores.jobs().find_idempotent(owner, "k")).has_value());
    CHECK_FALSE(claim_one(stores.jobs(), key, "w", at(0), at(60)).has_value());
    CHECK_FALSE(got(stores.jobs().request_cancel(key, kNow)).has_value());
    CHECK_FALSE(got(stores.jobs().forget(key)));
  }
  CHECK(job_in(stores.jobs(), job.key).state == JobState::queued);
  insert(stores.jobs(), new_job("bob", "1"));  // the same id is another job
}

TEST_CASE_TEMPLATE("jobs: an idempotency key names one job with one content", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewJob first = new_job("ann", "1");
  first.idempotency_key = "k";
  insert(stores.jobs(), first);
  NewJob second = new_job("ann", "2");
  second.idempotency_key = "k";
  second.fingerprint = first.fingerprint;
  const Inserted same = got(stores.jobs().insert(second));
  CHECK(same.existed);
  CHECK_FALSE(same.conflict);
  CHECK(same.job.key.id == "1");
  second.fingerprint = "other";
  const Inserted other = got(stores.jobs().insert(second));
  CHECK(other.existed);
  CHECK(other.conflict);
  CHECK_FALSE(got(stores.jobs().get(second.key)).has_value());
  second.key.owner = "bob";
  insert(stores.jobs(), second);
  insert(stores.jobs(), new_job("ann", "3"));  // jobs without a key do not collide
  insert(stores.jobs(), new_job("ann", "4"));
  CHECK(got(stores.jobs().insert(new_job("ann", "4"))).existed);  // the same call once more
}

TEST_CASE_TEMPLATE("jobs: of concurrent inserts with one idempotency key one succeeds", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  std::atomic<int> created{0};
  std::vector<std::string> ids(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    threads.emplace_back([&, i] {
      NewJob job = new_job("ann", std::to_string(i));
      job.idempotency_key = "k";
      const Result<Inserted> inserted = stores.jobs().insert(job);
      if (!inserted) return;
      if (!inserted->existed) created.fetch_add(1);
      ids[i] = inserted->job.key.id;
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(created.load() == 1);
  CHECK(std::set<std::string>(ids.begin(), ids.end()).size() == 1);
}

TEST_CASE_TEMPLATE("jobs: claimed, kept alive, finished", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.jobs(), new_job("ann", "1"));
  const std::optional<Claimed> claimed = claim_one(stores.jobs(), {"ann", "1"}, "w1", at(50), at(110));
  REQUIRE(claimed.has_value());
  CHECK(claimed->token.worker == "w1");
  CHECK(claimed->token.tries == 1);
  CHECK(claimed->job.state == JobState::running);
  CHECK(claimed->job.started == at(50));
  CHECK(claimed->job.options == new_job("ann", "1").options);
  CHECK_FALSE(claim_one(stores.jobs(), {"ann", "1"}, "w2", at(50), at(110)).has_value());

  const meshgauge::server::store::Progress progress{0.25, std::numeric_limits<double>::infinity(), "traverse"};
  CHECK(got(heartbeat(stores.jobs(), claimed->token, at(170), progress)) == Heartbeat::go_on);
  CHECK(job_in(stores.jobs(), {"ann", "1"}).progress == progress);

  CHECK_FALSE(got(stores.jobs().forget({"ann", "1"})));
  CHECK(got(finish(stores.jobs(), claimed->token, {JobState::failed, "{}", "{\"p\":1}", at(120), at(1120)})));
  stores.reopen();
  const Job job = job_in(stores.jobs(), {"ann", "1"});
  CHECK(job.state == JobState::failed);
  CHECK(job.document == "{}");
  CHECK(job.problem == "{\"p\":1}");
  CHECK(job.finished == at(120));
  CHECK(job.expires == at(1120));
  CHECK(got(stores.jobs().forget({"ann", "1"})));
  CHECK_FALSE(got(stores.jobs().get({"ann", "1"})).has_value());
  CHECK_FALSE(got(stores.jobs().forget({"ann", "1"})));
}

TEST_CASE_TEMPLATE("jobs: only the newest token can write", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(jobs, new_job("ann", "1"));
  const Token old = claimed_token(jobs, {"ann", "1"});
  got(jobs.recover("w1", "its worker died", kNow));
  const Token newer = claimed_token(jobs, {"ann", "1"}, "w1");  // even of the same worker
  CHECK(newer.tries == 2);
  CHECK(got(heartbeat(jobs, old, at(170), {})) == Heartbeat::lost);
  CHECK_FALSE(got(finish(jobs, old, ending())));
  CHECK_FALSE(got(jobs.hand_back(old, "late", kNow)).has_value());
  CHECK_FALSE(got(finish(jobs, {newer.key, "w2", newer.tries}, ending())));
  CHECK(job_in(jobs, {"ann", "1"}).state == JobState::running);
  CHECK(got(finish(jobs, newer, ending())));
  CHECK(got(finish(jobs, newer, ending())));  // the same call once more
  Ending other = ending(JobState::cancelled);
  other.finished = at(121);
  CHECK_FALSE(got(finish(jobs, newer, other)));
  CHECK_FALSE(got(finish(jobs, old, ending())));
  CHECK(got(heartbeat(jobs, newer, at(170), {})) == Heartbeat::lost);
  CHECK(job_in(jobs, {"ann", "1"}).state == JobState::done);
}

TEST_CASE_TEMPLATE("jobs: the owner with the fewest running is next, then its smallest job", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  const auto add = [&](const std::string& owner, const std::string& id, std::uint64_t cost, std::int64_t seconds) {
    NewJob job = new_job(owner, id);
    job.cost = cost;
    job.created = at(seconds);
    insert(stores.jobs(), job);
  };
  add("ann", "large", 900'000'000, 0);
  add("ann", "small", 1'000, 0);
  add("ann", "medium", 400'000'000, 0);
  add("ann", "later", 1'000, 10);  // has waited 10 s less than `medium`, worth 500 MB
  add("bob", "only", 990'000'000, 9);
  add("bob", "huge", std::numeric_limits<std::uint64_t>::max() / 2, 9);
  std::vector<std::string> order;
  while (true) {
    const auto claimed = got(stores.jobs().claim_some("w", at(20), at(80), 10));
    if (claimed.empty()) break;
    REQUIRE(claimed.size() == 1);  // they are in no batch
    order.push_back(claimed.front().job.key.owner + " " + claimed.front().job.key.id);
  }
  CHECK(order == std::vector<std::string>{"ann small", "bob only", "ann medium", "bob huge", "ann later", "ann large"});
}

TEST_CASE_TEMPLATE("jobs: workers that claim at the same time get different ones", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  for (int i = 0; i < 40; ++i) insert(stores.jobs(), new_job("ann", std::to_string(i)));
  std::vector<std::vector<std::string>> claimed(4);
  std::vector<std::thread> threads;
  for (auto& mine : claimed) {
    threads.emplace_back([&] {
      while (true) {
        const auto next = stores.jobs().claim_some("w", at(20), at(80), 1);
        if (!next || next->empty()) return;
        mine.push_back(next->front().job.key.id);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::set<std::string> all;
  std::size_t number = 0;
  for (const auto& mine : claimed) {
    all.insert(mine.begin(), mine.end());
    number += mine.size();
  }
  CHECK(number == 40);
  CHECK(all.size() == 40);
}

TEST_CASE_TEMPLATE("jobs: the fifth hand-back fails a job", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.jobs(), new_job("ann", "1"));
  for (unsigned tries = 1; tries <= kMaxTries; ++tries) {
    const Token token = claimed_token(stores.jobs(), {"ann", "1"});
    CHECK(token.tries == tries);
    const std::optional<JobState> state = got(stores.jobs().hand_back(token, "reason " + std::to_string(tries), kNow));
    CHECK(state == (tries < kMaxTries ? JobState::queued : JobState::failed));
    CHECK(job_in(stores.jobs(), {"ann", "1"}).last_error == "reason " + std::to_string(tries));
  }
  const Job job = job_in(stores.jobs(), {"ann", "1"});
  CHECK(job.state == JobState::failed);
  CHECK(job.finished == kNow.now);
  CHECK(job.expires == kNow.keep_until);
  CHECK_FALSE(claim_one(stores.jobs(), {"ann", "1"}, "w", at(0), at(60)).has_value());
  CHECK(got(stores.jobs().forget({"ann", "1"})));
}

TEST_CASE_TEMPLATE("jobs: an excused try does not count", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.jobs(), new_job("ann", "1"));
  for (unsigned i = 0; i < 3 * kMaxTries; ++i) {
    CHECK(got(stores.jobs().hand_back(claimed_token(stores.jobs(), {"ann", "1"}), "", kNow)) == JobState::queued);
  }
  for (unsigned i = 1; i < kMaxTries; ++i) {
    CHECK(got(stores.jobs().hand_back(claimed_token(stores.jobs(), {"ann", "1"}), "x", kNow)) == JobState::queued);
  }
  CHECK(got(stores.jobs().hand_back(claimed_token(stores.jobs(), {"ann", "1"}), "x", kNow)) == JobState::failed);
}

TEST_CASE_TEMPLATE("jobs: cancelled, before and while they run", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  for (const char* id : {"queued", "running", "handed back"}) insert(jobs, new_job("ann", id));
  CHECK(got(jobs.request_cancel({"ann", "queued"}, kNow)) == JobState::cancelled);
  const Job queued = job_in(jobs, {"ann", "queued"});
  CHECK(queued.finished == kNow.now);
  CHECK(queued.expires == kNow.keep_until);
  CHECK_FALSE(claim_one(jobs, {"ann", "queued"}, "w", at(0), at(60)).has_value());

  const Token running = claimed_token(jobs, {"ann", "running"});
  CHECK(got(jobs.request_cancel({"ann", "running"}, kNow)) == JobState::running);
  CHECK(job_in(jobs, {"ann", "running"}).cancel_requested);
  CHECK(got(heartbeat(jobs, running, at(170), {})) == Heartbeat::cancel);
  CHECK(got(finish(jobs, running, ending(JobState::cancelled))));
  CHECK(got(jobs.request_cancel({"ann", "running"}, kNow)) == JobState::cancelled);
  CHECK(job_in(jobs, {"ann", "running"}).finished == at(120));

  const Token back = claimed_token(jobs, {"ann", "handed back"});
  CHECK(got(jobs.request_cancel({"ann", "handed back"}, kNow)) == JobState::running);
  CHECK(got(jobs.hand_back(back, "gone", kNow)) == JobState::cancelled);
  CHECK_FALSE(got(jobs.request_cancel({"ann", "unknown"}, kNow)).has_value());
}

TEST_CASE_TEMPLATE("jobs: records are visible at once and durable after flush", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  Job job = ended_job("ann", "1");
  job.progress = meshgauge::server::store::Progress{1, 2, "certify"};
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
  stores.reopen();  // an orderly end writes it
  CHECK_FALSE(got(stores.jobs().get({"ann", "2"})).has_value());
  CHECK(got(stores.jobs().get({"ann", "3"})).has_value());
}
