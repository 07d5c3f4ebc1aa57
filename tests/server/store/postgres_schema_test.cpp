#include "server/store/postgres/schema.h"

#include <algorithm>
#include <thread>
#include <vector>

#include "job_steps.h"

using meshgauge::Error;
using meshgauge::ErrorCode;
using meshgauge::Result;
using namespace meshgauge::server::store;

namespace {

// An empty database and a connection to it.
class RawDatabase {
 public:
  RawDatabase() : name_(PostgresServer::shared().new_empty_database()), connection_(PgConnection::open(name_)) {}
  ~RawDatabase() {
    connection_.reset();
    PostgresServer::shared().drop(name_);
  }
  const std::string& name() const { return name_; }
  PgConnection& connection() { return *connection_; }
  std::int64_t number(const char* sql) {
    PgRows row = connection_->query(sql);
    REQUIRE(row.next());
    return row.number(0);
  }

 private:
  const std::string name_;
  std::unique_ptr<PgConnection> connection_;
};

const std::vector<const char*> kOne{"CREATE TABLE a (x bigint); INSERT INTO a VALUES (7)"};
const std::vector<const char*> kTwo{kOne[0],
                                    "ALTER TABLE a ADD COLUMN y bigint NOT NULL DEFAULT 8; UPDATE a SET x = x + 1"};
const std::vector<const char*> kBroken{kOne[0], kTwo[1], "UPDATE a SET x = 0; INSERT INTO nowhere VALUES (1)"};

std::span<const char* const> first_steps(std::size_t steps) { return pg_schema_steps().first(steps); }

bool mentions(const Error& error, const std::string& text) { return error.message.find(text) != std::string::npos; }

}  // namespace

TEST_CASE("PostgreSQL schema: an older database is brought forward, once") {
  RawDatabase database;
  got(pg_migrate(database.connection(), kOne));
  CHECK(to_string(got(pg_migrate(database.connection(), kTwo))) == "the schema was brought from version 1 to 2");
  CHECK(to_string(got(pg_migrate(database.connection(), kTwo))) == "the schema is of version 2 already");
  CHECK(database.number("SELECT x FROM a") == 8);
  CHECK(database.number("SELECT y FROM a") == 8);
}

TEST_CASE("PostgreSQL schema: a failed step leaves the version before it") {
  RawDatabase database;
  got(pg_migrate(database.connection(), kOne));
  CHECK_THROWS_AS(got(pg_migrate(database.connection(), kBroken)), PgFailure);
  CHECK(database.number("SELECT version FROM meshgauge_schema") == 1);
  CHECK(database.number("SELECT x FROM a") == 7);
}

TEST_CASE("PostgreSQL schema: a later version and another program's database are refused") {
  RawDatabase database;
  SUBCASE("later") {
    got(pg_migrate(database.connection(), kTwo));
    const auto migrated = pg_migrate(database.connection(), kOne);
    REQUIRE_FALSE(migrated.ok());
    CHECK(mentions(migrated.error(), "written by a later version of meshgauge (schema 2; this one knows 1)"));
    CHECK(database.number("SELECT x FROM a") == 8);
  }
  SUBCASE("later, by opening it") {
    got(migrate_database(database.name()));
    database.connection().execute("UPDATE meshgauge_schema SET version = 1000");
    PostgresSettings settings;
    settings.database = database.name();
    const auto store = PostgresStore::open(settings);
    REQUIRE_FALSE(store.ok());
    CHECK(mentions(store.error(), "later version"));
  }
  SUBCASE("another program's") {
    database.connection().execute("CREATE TABLE jobs (x bigint)");
    const auto migrated = migrate_database(database.name());
    REQUIRE_FALSE(migrated.ok());
    CHECK(mentions(migrated.error(), "is not one of meshgauge"));
  }
  SUBCASE("no other program's") {
    CHECK(migrate_database("host=/nowhere dbname=x").error().code == ErrorCode::storage_unavailable);
  }
}

TEST_CASE("PostgreSQL schema: of many processes that start at once one migrates") {
  RawDatabase database;
  std::vector<std::thread> threads;
  std::vector<std::string> said(8);
  for (std::string& text : said) {
    threads.emplace_back([&] {
      const auto migrated = migrate_database(database.name());
      text = migrated ? to_string(*migrated) : migrated.error().message;
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::string newest = std::to_string(pg_schema_steps().size());
  CHECK(std::count(said.begin(), said.end(), "the schema was brought from version 0 to " + newest) == 1);
  CHECK(std::count(said.begin(), said.end(), "the schema is of version " + newest + " already") == 7);
}

TEST_CASE("PostgreSQL schema: a migration that waits for a reader does not block others for long") {
  RawDatabase database;
  got(pg_migrate(database.connection(), kOne));
  const auto reader = PgConnection::open(database.name());
  reader->execute("BEGIN; SELECT x FROM a");  // like a backup
  std::thread migration([&] { got(pg_migrate(*PgConnection::open(database.name()), kTwo)); });
  const auto waiting = "SELECT count(*) FROM pg_locks WHERE relation = 'a'::regclass AND NOT granted";
  while (database.number(waiting) == 0) std::this_thread::yield();
  CHECK_NOTHROW(database.number("SELECT x FROM a"));  // waits for 3 s, as all our sessions do
  reader->execute("COMMIT");
  migration.join();
  CHECK(database.number("SELECT y FROM a") == 8);
}

TEST_CASE("PostgreSQL schema: rows of every earlier version are read") {
  for (std::size_t version = 1; version < pg_schema_steps().size(); ++version) {
    RawDatabase database;
    got(pg_migrate(database.connection(), first_steps(version)));
    database.connection().execute(
        "INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, fingerprint, trace, created, "
        "expires_if_never_run) VALUES ('ann', '1', 0, 'a', 'b', '', '{}', 5, 5, 'f', '', 1, 9000000000000); "
        "INSERT INTO meshes VALUES ('ann', 'a', 77, '', '', 1, 1, 9000000000000)");
    if (version >= 7) database.connection().execute("UPDATE jobs SET client = owner");  // as this version inserts it
    PostgresSettings settings;
    settings.database = database.name();
    const std::unique_ptr<PostgresStore> store = got(PostgresStore::open(settings));
    CHECK(job_in(*store, {"ann", "1"}).cost == 5);
    CHECK(got(store->stored("ann")).bytes == 77);
    CHECK(got(store->stored("ann")).meshes == 1);
    if (version < 6) CHECK(got(store->origin()).born == TimePoint(std::chrono::milliseconds(1)));  // 6 has its own
    const auto claimed =
        got(store->claim_some("w", at(50), at(110), 1, JobStore::Suspects::too, JobStore::Clients::all));
    REQUIRE(claimed.size() == 1);
    CHECK(claimed[0].job.client == "ann");
    CHECK(got(finish(*store, claimed[0].token, ending())));
  }
}

// Schema 4 had comparisons in shards: a whole, and a row for each part of it.
TEST_CASE("PostgreSQL schema: a job in shards is measured in one piece") {
  RawDatabase database;
  got(pg_migrate(database.connection(), first_steps(4)));
  database.connection().execute(R"sql(
    INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, fingerprint, trace, created,
                      expires_if_never_run, parent, awaits, finished, expires)
    SELECT owner::bytea, id::bytea, state, 'a', 'b', '', convert_to(options, 'UTF8'), 5, rank, 'f', '', 1,
           9000000000000, parent::bytea, awaits, CASE WHEN state >= 2 THEN 2 END, CASE WHEN state >= 2 THEN 9000000000000 END
    FROM (VALUES ('ann', '1', 0, '{"threads":2, "shards": 3}', 5, '', 2),
                 ('ann', '1.0', 2, '{"threads":2, "shards": 3}', 5, '1', 0),
                 ('ann', '1.1', 1, '{"threads":2, "shards": 3}', 5, '1', 0),
                 ('ann', '1.2', 0, '{"threads":2, "shards": 3}', 5, '1', 0),
                 ('bob', '2', 0, '{ "shards" : 64 , "gate": {"units": "é\"shards\":2\\"}}', 6, '', 0),
                 ('cat', '3', 0, '{"shards":1}', 7, '', 0),
                 ('dan', '4', 0, 'shards', 8, '', 0)) AS given (owner, id, state, options, rank, parent, awaits)
  )sql");
  PostgresSettings settings;
  settings.database = database.name();
  const std::unique_ptr<PostgresStore> store = got(PostgresStore::open(settings));
  CHECK(database.number("SELECT count(*) FROM jobs") == 4);
  CHECK(got(store->counts()).queued == 4);
  CHECK(got(store->unended("ann", at(50))) == 1);
  const auto options_of = [&](const char* owner, const char* id) { return job_in(*store, {owner, id}).options; };
  CHECK(options_of("ann", "1") == R"({"threads":2})");
  CHECK(options_of("bob", "2") == R"({  "gate": {"units": "é\"shards\":2\\"}})");
  CHECK(options_of("cat", "3") == "{}");
  CHECK(options_of("dan", "4") == "shards");
  const auto claimed = got(store->claim_some("w", at(50), at(110), 1, JobStore::Suspects::too, JobStore::Clients::all));
  REQUIRE(claimed.size() == 1);
  CHECK(claimed[0].job.key == JobKey{"ann", "1"});
  CHECK(got(finish(*store, claimed[0].token, ending())));
}

TEST_CASE("PostgreSQL schema: bounds of the version before have no known engine") {
  RawDatabase database;
  PostgresSettings settings;
  settings.database = database.name();
  const std::unique_ptr<PostgresStore> store = got(PostgresStore::open(settings));
  insert(*store, new_job("ann", "1"));
  const Token token = claimed_token(*store, {"ann", "1"});
  CHECK(got(heartbeat(*store, token, at(170), {2, 8, "reduce", "v1"})) == Heartbeat::go_on);
  CHECK(got(store->hand_back(token, "", kNow)) == JobState::queued);
  database.connection().execute("RESET meshgauge.bounds_by");  // as a process of that version
  database.connection().execute(
      "UPDATE jobs SET state = 1, tries = tries + 1, worker = 'old', lower = NULL, upper = NULL, stage = NULL; UPDATE "
      "jobs SET lower = 9, upper = 10, stage = 'build'");
  got(store->recover("old", "", kNow));
  CHECK(job_in(*store, {"ann", "1"}).progress == meshgauge::server::store::Progress{9, 10, "build", ""});
  const Token again = claimed_token(*store, {"ann", "1"});
  CHECK(got(heartbeat(*store, again, at(170), {1, 9.5, "reduce", "v1"})) == Heartbeat::go_on);
  CHECK(job_in(*store, {"ann", "1"}).progress == meshgauge::server::store::Progress{1, 9.5, "reduce", "v1"});
}

TEST_CASE("PostgreSQL: several schemas of one database are separate") {
  RawDatabase database;
  database.connection().execute("CREATE SCHEMA one; CREATE SCHEMA two");
  const auto store_in = [&](const std::string& schema) {
    PostgresSettings settings;
    settings.database = database.name() + " options='-c search_path=" + schema + "'";
    return got(PostgresStore::open(settings));
  };
  const auto one = store_in("one");
  const auto two = store_in("two");
  insert(*one, new_job("ann", "1"));
  CHECK(got(one->counts()).queued == 1);
  CHECK(got(two->counts()).queued == 0);
}
