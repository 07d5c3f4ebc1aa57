#include "server/store/schema.h"

#include <fstream>
#include <vector>

#include "implementations.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

class Database {
 public:
  Database() { std::ofstream(path()).flush(); }
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
  const Database database;
  Connection connection = database.connect();
  got(migrate(connection, kOne));
  CHECK(connection.pragma("user_version") == 1);
  got(migrate(connection, kTwo));
  got(migrate(connection, kTwo));
  CHECK(connection.pragma("user_version") == 2);
  CHECK(number(connection, "SELECT x FROM a") == 8);
  CHECK(number(connection, "SELECT y FROM a") == 8);
}

TEST_CASE("schema: a step that fails leaves the version before it") {
  const Database database;
  {
    Connection connection = database.connect();
    CHECK_FALSE(migrate(connection, kBroken).ok());
  }
  Connection connection = database.connect();
  CHECK(connection.pragma("user_version") == 2);
  CHECK(number(connection, "SELECT x FROM a") == 8);
}

TEST_CASE("schema: a later version and another program's database are refused") {
  const Database database;
  Connection connection = database.connect();
  SUBCASE("later") {
    got(migrate(connection, kTwo));
    const Result<Done> migrated = migrate(connection, kOne);
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
    const Result<Done> migrated = migrate(connection, kOne);
    REQUIRE_FALSE(migrated.ok());
    CHECK(migrated.error().message.find("is not one of meshgauge") != std::string::npos);
  }
}

TEST_CASE("schema: commits are synced, and keys refer to what is there") {
  const Database database;
  Connection connection = database.connect();
  CHECK(connection.pragma("synchronous") == 2);
  CHECK(connection.pragma("foreign_keys") == 1);
  CHECK(connection.pragma("busy_timeout") >= 1000);
  Query mode(connection, "PRAGMA journal_mode");
  REQUIRE(mode.next());
  CHECK(mode.text(0) == "wal");
}
