// Breaking connections, a database that goes away and comes back, and many callers at once.
#include <atomic>
#include <functional>
#include <random>
#include <set>
#include <thread>

#include "batch_steps.h"

using meshgauge::Error;
using meshgauge::ErrorCode;
using meshgauge::Result;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

// Runs work(number of the thread, turn) on so many threads until the time is over, and enough is done.
template <class Work>
void for_a_while(
    std::chrono::milliseconds time, int threads, Work work, const std::function<bool()>& enough = [] { return true; }) {
  std::vector<std::thread> all;
  const auto end = Clock::now() + time;
  for (int thread = 0; thread < threads; ++thread) {
    all.emplace_back([&, thread] {
      for (int turn = 0; Clock::now() < end || !enough(); ++turn) work(thread, turn);
    });
  }
  for (std::thread& thread : all) thread.join();
}

std::string name_of(const std::string& database) { return database.substr(database.rfind('=') + 1); }

std::int64_t number_in(const std::string& database, const char* sql) {
  PgRows row = PgConnection::open(database)->query(sql);
  REQUIRE(row.next());
  return row.number(0);
}

// From then on no commit is acknowledged.
void demand_standby(const std::string& database) {
  PostgresServer::shared().execute("ALTER SYSTEM SET synchronous_standby_names = 'absent'");
  PostgresServer::shared().execute("SELECT pg_reload_conf()");
  while (number_in(database,
                   "SELECT (setting = 'absent')::int FROM pg_settings WHERE name = 'synchronous_standby_names'") == 0) {
    std::this_thread::sleep_for(10ms);
  }
  std::this_thread::sleep_for(200ms);  // until our connections get the setting, too
}

void demand_no_standby() {
  PostgresServer::shared().execute("ALTER SYSTEM RESET synchronous_standby_names");
  PostgresServer::shared().execute("SELECT pg_reload_conf()");
}

void end_waiting() {
  PostgresServer::shared().execute("SELECT pg_cancel_backend(pid) FROM pg_stat_activity WHERE wait_event = 'SyncRep'");
}

// Claims some jobs and ends them, like a worker. Returns the ids of those whose end was acknowledged.
void work_once(JobStore& jobs, const std::string& worker, std::mutex& mutex, std::multiset<std::string>& ended) {
  const auto claimed = jobs.claim_some(worker, at(50), at(110), 3);
  if (!claimed) return;
  std::vector<Finished> endings;
  for (const Claimed& one : *claimed) endings.push_back({one.token, ending()});
  const auto stored = jobs.finish_all(endings);
  if (!stored) return;
  const std::lock_guard lock(mutex);
  for (std::size_t i = 0; i < endings.size(); ++i) {
    if ((*stored)[i]) ended.insert(endings[i].token.key.id);
  }
}

}  // namespace

TEST_CASE("trouble: breaking connections lose nothing and repeat nothing") {
  PostgresForTests stores;
  const auto other = stores.open("other");
  std::mutex mutex;
  std::set<std::string> promised;
  std::multiset<std::string> ended;
  std::atomic<int> failed{0};
  std::atomic<bool> over{false};
  std::thread breaker([&] {
    std::minstd_rand random(7);
    while (!over) {
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 40));
      PostgresServer::shared().execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '" +
                                       name_of(stores.database()) +
                                       "' AND backend_type = 'client backend' AND random() < 0.4");
    }
  });
  const auto enough = [&] {
    const std::lock_guard lock(mutex);
    return promised.size() > 20;
  };
  for_a_while(
      600ms, 6,
      [&](int thread, int turn) {
        JobStore& jobs = thread % 2 == 0 ? stores.jobs() : other->jobs();
        if (thread < 3) {
          const std::string id = std::to_string(thread) + "-" + std::to_string(turn);
          const Result<Inserted> inserted = jobs.insert(new_job("ann", id));
          if (!inserted) ++failed;
          const std::lock_guard lock(mutex);
          if (inserted) promised.insert(id);
        } else {
          work_once(jobs, "w" + std::to_string(thread), mutex, ended);
        }
      },
      enough);
  over = true;
  breaker.join();
  // No connection was given up for good: calls with a call_timeout are answered.
  CHECK(failed == 0);
  got(stores.jobs().recover("", "the test is over", {at(200), at(1200)}));
  while (got(stores.jobs().counts()).queued > 0) work_once(stores.jobs(), "last", mutex, ended);
  MESSAGE(promised.size(), " jobs");
  std::vector<JobKey> keys;
  for (const std::string& id : promised) keys.push_back({"ann", id});
  const std::vector<Job> kept = got(stores.jobs().get_many(keys));
  CHECK(kept.size() == promised.size());
  for (const Job& job : kept) CHECK(job.state == JobState::done);
  CHECK(std::set<std::string>(ended.begin(), ended.end()).size() == ended.size());
}

TEST_CASE("trouble: a claim whose answer is lost is found again, not repeated") {
  PostgresForTests stores;
  for (int i = 0; i < 40; ++i) insert(stores.jobs(), new_job("ann", std::to_string(i)));
  std::atomic<bool> over{false};
  std::thread breaker([&] {
    while (!over) {
      PostgresServer::shared().execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '" +
                                       name_of(stores.database()) + "' AND query LIKE 'WITH RECURSIVE%'");
    }
  });
  std::set<std::string> claimed;
  for (int i = 0; i < 40; ++i) {
    const auto some = stores.jobs().claim_some("w", at(50), at(110), 1);
    if (some) {
      for (const Claimed& one : *some) CHECK(claimed.insert(one.token.key.id).second);
    }
  }
  over = true;
  breaker.join();
  CHECK(claimed.size() > 0);
  CHECK(static_cast<std::size_t>(number_in(stores.database(), "SELECT count(*) FROM jobs WHERE state = 1")) ==
        claimed.size());
}

TEST_CASE("trouble: calls wait for a stopped database for the call_timeout, and recover") {
  PostgresForTests all;
  PostgresServer& server = PostgresServer::shared();
  DistributedSettings settings = all.settings("impatient");
  settings.call_timeout = 1500ms;
  settings.duty_grace = 0ms;
  const auto stores = got(AllStores::open_distributed(settings));
  insert(stores->jobs(), new_job("ann", "before"));
  SUBCASE("stopped") { server.stop(); }
  SUBCASE("killed") { server.kill(); }
  const Result<Inserted> during = stores->jobs().insert(new_job("ann", "during"));
  REQUIRE_FALSE(during.ok());
  CHECK(during.error().code == ErrorCode::storage_unavailable);
  std::this_thread::sleep_for(1500ms);
  for (int i = 0; i < 1000; ++i) CHECK_FALSE(stores->jobs().get({"ann", "before"}).ok());  // at once, by now
  CHECK_FALSE(stores->jobs().on_duty());
  CHECK_FALSE(stores->blobs().put(key_of("ann", "x"), bytes_of("x")).ok());
  CHECK_FALSE(stores->jobs().check().ok());
  stores->meshes().touch_mesh({"ann", "m"}, at(1), at(2));  // does not block
  server.start();
  while (!stores->jobs().check().ok()) std::this_thread::sleep_for(20ms);
  CHECK(job_in(stores->jobs(), {"ann", "before"}).state == JobState::queued);
  insert(stores->jobs(), new_job("ann", "after"));
}

TEST_CASE("trouble: a commit without the standby is not acknowledged") {
  PostgresForTests all;
  DistributedSettings settings = all.settings("impatient");
  settings.call_timeout = 1500ms;
  const auto stores = got(AllStores::open_distributed(settings));
  demand_standby(all.database());
  CHECK_FALSE(stores->jobs().insert(new_job("ann", "1")).ok());
  CHECK(got(stores->jobs().counts()).queued == 0);  // it is invisible, and reading does not block
  const auto claimed = stores->jobs().claim_some("w", at(50), at(110), 1);
  CHECK(got(claimed).empty());
  // An operator ends the waiting: it is committed here alone. That a call finds it does not prove that it is safe.
  end_waiting();
  CHECK_FALSE(stores->jobs().insert(new_job("ann", "1")).ok());
  demand_no_standby();
  Result<Inserted> at_last = stores->jobs().insert(new_job("ann", "1"));
  while (!at_last) at_last = stores->jobs().insert(new_job("ann", "1"));
  CHECK(at_last->existed);
  CHECK_FALSE(at_last->conflict);
}

TEST_CASE("trouble: nor to another process that finds it") {
  PostgresForTests all;
  std::vector<std::unique_ptr<AllStores>> stores;
  for (const char* name : {"one", "other"}) {
    DistributedSettings settings = all.settings(name);
    settings.call_timeout = 250ms;
    stores.push_back(got(AllStores::open_distributed(settings)));
  }
  // Once acknowledged: whether it existed.
  const auto found = [](AllStores& there) -> Result<bool> {
    const auto inserted = there.batches().insert_batch(new_batch("ann", "b", 1));
    return inserted ? Result<bool>(inserted->existed) : inserted.error();
  };
  demand_standby(all.database());
  do {  // a slow machine may not reach its commit in so short a time
    CHECK_FALSE(found(*stores[0]).ok());
    end_waiting();
    std::this_thread::sleep_for(10ms);
  } while (number_in(all.database(), "SELECT count(*) FROM jobs") == 0);
  CHECK_FALSE(found(*stores[1]).ok());
  demand_no_standby();
  Result<bool> at_last = found(*stores[1]);
  while (!at_last) at_last = found(*stores[1]);
  CHECK(*at_last);
}

TEST_CASE("trouble: sixteen callers rarely deadlock, and none fails") {
  PostgresForTests stores;
  const auto other = stores.open("other");
  std::mutex mutex;
  std::multiset<std::string> ended;
  std::set<std::string> errors;
  const auto checked = [&](const auto& result) {
    if (result) return;
    const std::lock_guard lock(mutex);
    errors.insert(result.error().message);
  };
  for_a_while(800ms, 16, [&](int thread, int turn) {
    AllStores* there = other.get();
    JobStore& jobs = thread % 2 == 0 ? stores.jobs() : there->jobs();
    BatchStore& batches = thread % 2 == 0 ? stores.batches() : there->batches();
    const std::string id = std::to_string(thread) + "-" + std::to_string(turn);
    const JobKey key{"ann", id};
    switch (thread % 8) {
      case 0: {
        NewBatch batch = new_batch("ann", id, 20);
        for (std::size_t i = 0; i < 20; ++i) batch.items[i].work = "work " + std::to_string((i * 7) % 20);
        checked(batches.insert_batch(batch));
        checked(batches.cancel_batch(key, {at(60), at(1060)}));
        checked(batches.forget_batch(key));
        return;
      }
      case 1: {
        checked(jobs.insert(new_job("ann", id)));
        if (turn % 3 == 0) checked(jobs.request_cancel(key, {at(60), at(1060)}));
        return;
      }
      case 2:
        checked(jobs.recover("w4", "x", {at(60), at(1060)}));
        return;
      case 3:
        checked(jobs.sweep_jobs({at(70), at(1060)}, 30));
        checked(batches.sweep_batches(at(130)));
        return;
      case 4: {
        const auto claimed = jobs.claim_some("w4", at(50), at(110), 10);
        checked(claimed);
        std::vector<Beat> beats;
        for (std::size_t i = 0; claimed && i < claimed->size(); ++i)
          beats.push_back({(*claimed)[i].token, meshgauge::server::store::Progress{1, 2, "s"}});
        checked(jobs.heartbeats(beats, at(120)));
        return;
      }
      case 5:
        checked(jobs.insert(new_job("ann", id)));
        checked(jobs.request_cancel(key, {at(60), at(1060)}));
        return;
      default:
        work_once(jobs, "w" + std::to_string(thread), mutex, ended);
    }
  });
  for (const std::string& error : errors) FAIL_CHECK(error);
  // The database breaks a deadlock, and the call is repeated. That must stay rare among some thousand calls.
  CHECK(number_in(stores.database(), "SELECT deadlocks FROM pg_stat_database WHERE datname = current_database()") <= 5);
}

TEST_CASE("trouble: with more callers than connections all are served") {
  PostgresForTests stores;
  DistributedSettings settings = stores.settings("other");
  settings.max_connections = 2;
  settings.call_timeout = 60s;
  const auto few = got(AllStores::open_distributed(settings));
  std::atomic<int> failed{0};
  for_a_while(300ms, 12, [&](int thread, int turn) {
    if (!few->jobs().insert(new_job("ann", std::to_string(thread) + "-" + std::to_string(turn)))) ++failed;
  });
  CHECK(failed == 0);
  CHECK(number_in(stores.database(),
                  "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND backend_type = 'client "
                  "backend' AND query LIKE 'INSERT INTO jobs%'") <= 2);
}

TEST_CASE("trouble: touches of many meshes are one statement, at any latency") {
  PostgresForTests stores;
  DistributedSettings settings = stores.settings("other");
  settings.max_unrecorded = 5000;
  const auto other = got(AllStores::open_distributed(settings));
  const auto connection = PgConnection::open(stores.database());
  connection->execute(
      "INSERT INTO meshes SELECT 'ann', convert_to(n::text, 'UTF8'), 1, '', '', 0, 0, 0 FROM generate_series(1, 4000) "
      "AS n; CREATE TABLE updates (one boolean); CREATE FUNCTION note() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN "
      "INSERT INTO updates VALUES (true); RETURN NULL; END $$; CREATE TRIGGER note AFTER UPDATE ON meshes FOR EACH "
      "STATEMENT EXECUTE FUNCTION note()");
  for (int n = 1; n <= 4000; ++n)
    other->meshes().touch_mesh({"ann", std::to_string(n)}, at(50), at(n % 2 == 0 ? 200 : 50));
  got(other->jobs().flush());
  CHECK(number_in(stores.database(), "SELECT count(*) FROM updates") <= 10);  // some may have been written before
  CHECK(number_in(stores.database(), "SELECT count(*) FROM meshes WHERE last_used = 1700000050000") == 4000);
  CHECK(number_in(stores.database(), "SELECT count(*) FROM meshes WHERE expires = 1700000200000") == 2000);
}

TEST_CASE("trouble: a removal reports that it removed, though the answer to its commit was lost") {
  PostgresForTests stores;
  const std::string waiting =
      "FROM pg_stat_activity WHERE wait_event = 'SyncRep' AND datname = '" + name_of(stores.database()) + "'";
  got(stores.meshes().put_mesh({{"ann", "m"}, 10, "", "", at(0), at(0), at(100)}, {100}));
  insert(stores.batches(), new_batch("ann", "b", 1));
  got(stores.batches().cancel_batch({"ann", "b"}, {at(50), at(100)}));
  std::function<Result<bool>()> remove;
  const char* left = nullptr;
  SUBCASE("a mesh") {
    remove = [&] { return stores.meshes().delete_mesh({"ann", "m"}); };
    left = "SELECT count(*) FROM meshes";
  }
  SUBCASE("a batch") {
    remove = [&] { return stores.batches().forget_batch({"ann", "b"}); };
    left = "SELECT count(*) FROM batches";
  }
  REQUIRE(number_in(stores.database(), left) == 1);
  demand_standby(stores.database());
  std::optional<Result<bool>> removed;
  std::thread remover([&] { removed = remove(); });
  bool committed = false;
  for (int tries = 0; tries < 3000 && !committed; ++tries) {
    PostgresServer::shared().execute("SELECT pg_terminate_backend(pid) " + waiting);  // committed, without an answer
    std::this_thread::sleep_for(5ms);
    committed = number_in(stores.database(), left) == 0;
  }
  demand_no_standby();
  remover.join();
  REQUIRE(committed);
  CHECK(got(*removed));
  CHECK_FALSE(got(remove()));
}
