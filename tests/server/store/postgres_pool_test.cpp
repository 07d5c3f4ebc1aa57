// The pool of connections: few, and not always available.
#include <atomic>
#include <set>
#include <thread>

#include "job_steps.h"
#include "tests/eventually.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

// A role with a limit of connections, during the lifetime of the object.
class Frugal {
 public:
  Frugal(const PostgresForTests& stores, int connections) : database_(stores.database()) {
    const auto connection = PgConnection::open(database_);
    connection->execute("CREATE ROLE frugal LOGIN; GRANT ALL ON ALL TABLES IN SCHEMA public TO frugal");
    allow(connections);
  }
  ~Frugal() { PgConnection::open(database_)->execute("DROP OWNED BY frugal; DROP ROLE frugal"); }
  Frugal(const Frugal&) = delete;
  Frugal& operator=(const Frugal&) = delete;

  void allow(int connections) {
    PgConnection::open(database_)->execute("ALTER ROLE frugal CONNECTION LIMIT " + std::to_string(connections));
  }
  // Ends the role's connections, except one with a lock: the process on duty has one.
  void end_those_without_lock() {
    PgConnection::open(database_)->execute(
        "SELECT pg_terminate_backend(pid, 20000) FROM pg_stat_activity AS each WHERE usename = 'frugal' AND NOT EXISTS "
        "(SELECT FROM pg_locks WHERE pg_locks.pid = each.pid AND locktype = 'advisory')");
  }
  std::string connection_string() const {
    std::string own = database_;
    return own.replace(own.find("user=tests"), 10, "user=frugal");
  }

 private:
  const std::string database_;
};

}  // namespace

TEST_CASE("connections: a statement that the server alone knows blocks no other") {
  PostgresForTests stores;
  const auto connection = PgConnection::open(stores.database());
  connection->execute("PREPARE s0 AS SELECT 1");  // as when the memory ends after the server's answer
  const auto two = [&] {
    PgRows row = connection->query("SELECT 2::int8");
    row.next();
    return row.number(0);
  };
  CHECK_THROWS_AS((void)two(), PgFailure);
  CHECK(two() == 2);
}

TEST_CASE("connections: a late caller takes no connection from others") {
  constexpr int kAllTheTime = 100;  // times the call_timeout
  PostgresForTests stores;
  PoolSettings settings{stores.database(), 2, 300ms};
  bool late = false;
  SUBCASE("with little time left for an answer") {
    late = true;
    settings.fair_time = 1h;
  }
  SUBCASE("but a server that had its time may be gone") { settings.fair_time = 0ms; }
  PgPool pool(settings);
  const auto pid = [](PgConnection& connection) {
    PgRows row = connection.query("SELECT pg_backend_pid()");
    row.next();
    return row.number(0);
  };
  std::set<std::int64_t> pids;
  Result<std::int64_t> inner = 0;
  const auto both = [&](PgConnection& connection) {
    inner = pool.run(Promise::fleeting, pid, kAllTheTime);
    return pid(connection);
  };
  pids.insert(got(pool.run(Promise::fleeting, both, 2 * kAllTheTime)));
  pids.insert(got(inner));
  REQUIRE(pids.size() == 2);
  const SteadyTime trouble = pool.newest_trouble();
  const auto unanswered = pool.run(Promise::fleeting, [](PgConnection& connection) {
    connection.query("SELECT pg_sleep(600)");
    return Done{};
  });
  CHECK_FALSE(unanswered.ok());
  CHECK((pool.newest_trouble() == trouble) == late);
  CHECK(pids.contains(got(pool.run(Promise::fleeting, pid, kAllTheTime))) == late);
}

TEST_CASE("connections: a server without free connections is not away, and callers share those that are open") {
  PostgresForTests stores;
  Frugal role(stores, 1);
  PgPool pool({role.connection_string(), 8, 20s, {}});
  const auto work = [](PgConnection& connection) {
    connection.query("SELECT pg_sleep(0.02)");
    return Done{};
  };
  got(pool.run(Promise::fleeting, work));
  const SteadyTime trouble = pool.newest_trouble();
  std::atomic<int> failed{0};
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 4; ++caller) {
    callers.emplace_back([&] {
      for (int turn = 0; turn < 10; ++turn) {
        if (!pool.run(Promise::fleeting, work)) ++failed;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  CHECK(failed == 0);
  CHECK(pool.newest_trouble() == trouble);
}

TEST_CASE("connections: a caller that got none learns why") {
  PostgresForTests stores;
  Frugal role(stores, 1);
  std::string reported;
  PgPool pool({role.connection_string(), 8, 3s, [&](const std::string& line) { reported += line; }});
  Result<Done> inner = Done{};
  const auto outer = pool.run(
      Promise::fleeting,
      [&](PgConnection& connection) {
        connection.query("SELECT 1");
        inner = pool.run(Promise::fleeting, [](PgConnection&) { return Done{}; });
        return Done{};
      },
      20);
  got(outer);
  REQUIRE_FALSE(inner.ok());
  CHECK(inner.error().code == ErrorCode::storage_unavailable);
  CHECK(reported.find("too many connections for role \"frugal\"") != std::string::npos);
  CHECK(inner.error().message.find("frugal") == std::string::npos);
}

TEST_CASE("connections: a process without one leaves the duty to another") {
  PostgresForTests stores;
  Frugal role(stores, -1);
  DistributedSettings settings = stores.settings("frugal");
  settings.database = role.connection_string();
  settings.call_timeout = 500ms;
  auto first = got(AllStores::open_distributed(settings));
  REQUIRE(eventually([&] { return first->jobs().on_duty(); }));
  CHECK_FALSE(stores.jobs().on_duty());
  role.allow(0);
  role.end_those_without_lock();
  CHECK_FALSE(first->jobs().check().ok());
  CHECK(eventually([&] { return stores.jobs().on_duty(); }));
  CHECK_FALSE(first->jobs().on_duty());
  role.allow(-1);
  CHECK(eventually([&] { return first->jobs().check().ok(); }));
  CHECK(stores.jobs().on_duty());
  first.reset();
}
