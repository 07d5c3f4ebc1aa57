#include "server/store/schema.h"

#include <fstream>
#include <vector>

#include "implementations.h"
#include "job_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

class RawDatabase {
 public:
  RawDatabase() { std::ofstream(path()).flush(); }
  std::string path() const { return folder_ / "a.sqlite"; }
  Connection connect() const { return Connection(path(), Connection::Use::write); }

 private:
  TestFolder folder_;
};

std::int64_t number(Connection& connection, const char* sql) {
  Query query(connection, sql);
  REQUIRE(query.next());
  return query.number(0);
}

const std::vector<const char*> kOne{"CREATE TABLE a (x INTEGER); INSERT INTO a VALUES (7)"};
const std::vector<const char*> kTwo{kOne[0],
                                    "ALTER TABLE a ADD COLUMN y INTEGER NOT NULL DEFAULT 8; UPDATE a SET x = x + 1"};
const std::vector<const char*> kBroken{kOne[0], kTwo[1], "UPDATE a SET x = 0; INSERT INTO nowhere VALUES (1)"};

}  // namespace

TEST_CASE("schema: an older database is brought forward, once") {
  const RawDatabase database;
  Connection connection = database.connect();
  CHECK(to_string(got(migrate(connection, kOne))) == "the schema was brought from version 0 to 1");
  CHECK(connection.pragma("user_version") == 1);
  CHECK(to_string(got(migrate(connection, kTwo))) == "the schema was brought from version 1 to 2");
  CHECK(to_string(got(migrate(connection, kTwo))) == "the schema is of version 2 already");
  CHECK(connection.pragma("user_version") == 2);
  CHECK(number(connection, "SELECT x FROM a") == 8);
  CHECK(number(connection, "SELECT y FROM a") == 8);
}

TEST_CASE("schema: a step that fails leaves the version before it") {
  const RawDatabase database;
  {
    Connection connection = database.connect();
    CHECK_FALSE(migrate(connection, kBroken).ok());
  }
  Connection connection = database.connect();
  CHECK(connection.pragma("user_version") == 2);
  CHECK(number(connection, "SELECT x FROM a") == 8);
}

TEST_CASE("schema: a later version and another program's database are refused") {
  const RawDatabase database;
  Connection connection = database.connect();
  SUBCASE("later") {
    got(migrate(connection, kTwo));
    const auto migrated = migrate(connection, kOne);
    REQUIRE_FALSE(migrated.ok());
    CHECK(migrated.error().message.find("written by a later version of meshgauge (schema 2; this one knows 1)") !=
          std::string::npos);
    CHECK(number(connection, "SELECT x FROM a") == 8);
  }
  SUBCASE("another program's, without a name") {
    connection.execute("CREATE TABLE b (x INTEGER)");
    CHECK_FALSE(migrate(connection, kOne).ok());
  }
  SUBCASE("another program's") {
    connection.execute("PRAGMA application_id = 1");
    const auto migrated = migrate(connection, kOne);
    REQUIRE_FALSE(migrated.ok());
    CHECK(migrated.error().message.find("is not one of meshgauge") != std::string::npos);
  }
}

TEST_CASE("schema: the migration of an older database is reported, the creation of a new one is not") {
  const RawDatabase database;
  std::vector<std::string> lines;
  const Report report = [&](const std::string& line) { lines.push_back(line); };
  {
    Connection connection = database.connect();
    got(migrate(connection, schema_steps().first(1)));
  }
  got(SqliteStore::open({database.path(), 50, nullptr, report}));
  got(SqliteStore::open({database.path(), 50, nullptr, report}));
  const std::string newest = std::to_string(schema_steps().size());
  CHECK(lines == std::vector<std::string>{"the schema was brought from version 1 to " + newest});
  got(SqliteStore::open({database.path() + ".new", 50, nullptr, report}));
  CHECK(lines.size() == 1);
}

TEST_CASE("schema: rows of every earlier version are read") {
  for (std::size_t version = 1; version < schema_steps().size(); ++version) {
    const RawDatabase database;
    {
      Connection connection = database.connect();
      got(migrate(connection, schema_steps().first(version)));
      connection.execute(
          "INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, fingerprint, trace, "
          "created, "
          "expires_if_never_run, lower, upper, stage) VALUES ('ann', '1', 0, 'a', 'b', '', '{}', 5, 5, 'f', '', 1, "
          "9000000000000, 1, 2, 'reduce')");
      connection.execute("INSERT INTO meshes VALUES ('ann', 'm', 7, '', '', 2, 2, 9000000000000)");
      if (version >= 6) connection.execute("UPDATE jobs SET client = owner");  // as this version inserts it
    }
    const std::unique_ptr<SqliteStore> store = got(SqliteStore::open({database.path(), 50}));
    CHECK(got(store->stored("ann")).meshes == 1);
    if (version < 5) CHECK(got(store->origin()).born == TimePoint(std::chrono::milliseconds(1)));  // 5 has its own
    const auto claimed =
        got(store->claim_some("w", at(50), at(110), 1, JobStore::Suspects::too, JobStore::Clients::all));
    REQUIRE(claimed.size() == 1);
    CHECK(claimed[0].job.client == "ann");
    CHECK(claimed[0].job.progress == meshgauge::server::store::Progress{1, 2, "", ""});
    CHECK(got(finish(*store, claimed[0].token, {JobState::done, "{}", "", at(120), at(1120)})));
  }
}

TEST_CASE("schema: options that asked for shards are read without them") {
  const RawDatabase database;
  const char* const options[] = {R"({"threads":2, "shards": 3})",
                                 R"({ "shards" : 64 , "gate": {"units": "\"shards\":2"}})",
                                 R"({"shards":1})",
                                 R"({"threads":2})",
                                 R"("shards")",
                                 R"({"shards")"};
  const char* const left[] = {
      R"({"threads":2})", R"({"gate":{"units":"\"shards\":2"}})", "{}", R"({"threads":2})", R"("shards")",
      R"({"shards")"};
  {
    Connection connection = database.connect();
    got(migrate(connection, schema_steps().first(3)));
    for (std::size_t i = 0; i < std::size(options); ++i) {
      Query(connection,
            "INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, fingerprint, trace, "
            "created, expires_if_never_run) VALUES ('ann', ?, 0, 'a', 'b', '', ?, 5, 5, 'f', '', 1, 9000000000000)",
            std::to_string(i), options[i])
          .run();
    }
  }
  const std::unique_ptr<SqliteStore> store = got(SqliteStore::open({database.path(), 50}));
  for (std::size_t i = 0; i < std::size(options); ++i) {
    CHECK(job_in(*store, {"ann", std::to_string(i)}).options == left[i]);
  }
}

TEST_CASE("schema: commits are synced, and keys refer to what is there") {
  const RawDatabase database;
  Connection connection = database.connect();
  CHECK(connection.pragma("synchronous") == 2);
  CHECK(connection.pragma("foreign_keys") == 1);
  CHECK(connection.pragma("busy_timeout") >= 1000);
  Query mode(connection, "PRAGMA journal_mode");
  REQUIRE(mode.next());
  CHECK(mode.text(0) == "wal");
}
