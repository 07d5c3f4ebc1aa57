// Large batches: their end blocks no other call, and its cost is that of their items.
#include <mutex>
#include <thread>

#include "batch_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;

namespace {

const Moment kLater{at(60), at(1060)};

// Claims as many workers would, in one statement.
void end_all(const PostgresForTests& stores) {
  PgConnection::open(stores.database())
      ->execute("UPDATE jobs SET state = 2, finished = created, expires = created + 1000000, reusable = true");
}

std::int64_t number_in(PgConnection& connection, const char* sql) {
  PgRows row = connection.query(sql);
  REQUIRE(row.next());
  return row.number(0);
}

}  // namespace

TEST_CASE("large batches: removed within a call's time, though PostgreSQL's estimates are small") {
  PostgresForTests stores;
  const auto connection = PgConnection::open(stores.database());
  insert(stores.batches(), new_batch("ann", "small", 3));
  end_all(stores);
  connection->execute("ALTER TABLE jobs SET (autovacuum_enabled = false)");
  connection->execute("ALTER TABLE batch_items SET (autovacuum_enabled = false)");
  connection->execute("ANALYZE");
  insert(stores.batches(), new_batch("ann", "b", 10'000));
  insert(stores.batches(), new_batch("ann", "c", 10'000));
  end_all(stores);
  DistributedSettings settings = stores.settings("hasty");
  settings.call_timeout = 1s;
  const auto hasty = got(AllStores::open_distributed(settings));
  CHECK(got(hasty->batches().forget_batch({"ann", "b"})));
  CHECK(number_in(*connection, "SELECT count(*) FROM jobs") == 10'003);
  CHECK(got(hasty->batches().sweep_batches(at(10))) == 2);
  CHECK(number_in(*connection, "SELECT count(*) FROM jobs") == 0);
}

TEST_CASE("large batches: cancelling skips locked jobs and blocks no other call") {
  PostgresForTests stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 600));
  const Token first = claimed_token(jobs, {"ann", "b/0"});
  const Token last = claimed_token(jobs, {"ann", "b/599"});
  const auto connection = PgConnection::open(stores.database());
  std::thread canceller;
  {
    PgTransaction transaction(*connection);
    connection->query("SELECT FROM jobs WHERE id = 'b/300' FOR UPDATE");
    canceller = std::thread([&] { CHECK(got(stores.batches().cancel_batch({"ann", "b"}, kLater))); });
    const auto count = [&] { return batch_in(stores.batches(), {"ann", "b"}).counts; };
    while (count().cancelled < 597) std::this_thread::sleep_for(5ms);
    CHECK(count().queued == 1);
    CHECK(count().running == 2);
    CHECK(claim_ids(jobs, 10).empty());
    CHECK(got(finish(jobs, first, ending())));
    while (got(heartbeat(jobs, last, at(170), {})) != Heartbeat::cancel) std::this_thread::sleep_for(5ms);
  }  // rolled back
  canceller.join();
  const BatchCounts counts = batch_in(stores.batches(), {"ann", "b"}).counts;
  CHECK(counts.cancelled == 598);
  CHECK(counts.done == 1);
  CHECK(counts.running == 1);
}

TEST_CASE("large batches: the process on duty finishes the cancelling of a process that died") {
  PostgresForTests stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 300));
  NewBatch wanted = new_batch("ann", "c", 2);
  wanted.items[0].work = "work of b/299";
  insert(stores.batches(), wanted);
  const Token runs = claimed_token(jobs, {"ann", "b/1"});
  PgConnection::open(stores.database())->execute("UPDATE batches SET cancel_requested = true WHERE id = 'b'");
  got(jobs.recover(std::nullopt, "no sign of life", kLater));
  CHECK(batch_in(stores.batches(), {"ann", "b"}).counts.cancelled == 298);
  CHECK(got(heartbeat(jobs, runs, at(170), {})) == Heartbeat::cancel);
  CHECK(job_in(jobs, {"ann", "b/299"}).state == JobState::queued);  // the other batch waits for it
  CHECK(batch_in(stores.batches(), {"ann", "c"}).counts.queued == 2);
}

TEST_CASE("outages: errors name no details, the report has the whole text, once") {
  PostgresServer server;
  const TestFolder folder;
  DistributedSettings settings;
  settings.database = server.new_database();
  settings.data_folder = folder / "data";
  settings.call_timeout = 500ms;
  std::mutex mutex;
  std::vector<std::string> lines;
  settings.report = [&](const std::string& line) {
    const std::lock_guard lock(mutex);
    lines.push_back(line);
  };
  const auto stores = got(AllStores::open_distributed(settings));
  // A slow machine may not get an answer in so short a time, nor notice that the server is away.
  const auto told = [&] {
    const Result<Done> checked = stores->jobs().check();
    return checked ? "" : checked.error().message;
  };
  while (!told().empty()) std::this_thread::sleep_for(20ms);
  {
    const std::lock_guard lock(mutex);
    lines.clear();
  }
  server.stop();
  for (int in_turn = 0; in_turn < 2;) in_turn = told() == "the database cannot be reached" ? in_turn + 1 : 0;
  for (int i = 0; i < 50; ++i) {
    CHECK(told() == "the database cannot be reached");
    CHECK(stores->blobs().check().error().message == "the database cannot be reached");
  }
  server.start();
  while (!told().empty()) std::this_thread::sleep_for(20ms);
  const std::lock_guard lock(mutex);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].starts_with("the database cannot be used: "));
  CHECK(lines[0].size() > 40);
  CHECK(lines[1] == "the database is back");
}
