#include "server/store/writer.h"

#include <atomic>
#include <cerrno>
#include <fstream>
#include <set>
#include <stdexcept>
#include <thread>

#include <sqlite3.h>

#include "implementations.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

class Table {
 public:
  Table() {
    std::ofstream(path()).flush();
    auto connection = std::make_unique<Connection>(path(), Connection::Use::write);
    connection->execute("CREATE TABLE t (x INTEGER PRIMARY KEY)");
    writer_ = std::make_unique<Writer>(std::move(connection));
  }

  Writer& writer() { return *writer_; }
  std::string path() const { return folder_ / "a.sqlite"; }
  Result<std::uint64_t> add(std::int64_t x) {
    return writer_->write(
        [x](Connection& connection) { return Query(connection, "INSERT INTO t VALUES (?)", x).run(); });
  }
  std::int64_t count() {
    Readers readers(path());
    return got(readers.read([](Connection& connection) {
      Query query(connection, "SELECT count(*) FROM t");
      query.next();
      return query.number(0);
    }));
  }

 private:
  TestFolder folder_;
  std::unique_ptr<Writer> writer_;
};

}  // namespace

TEST_CASE("writer: a failed write undoes itself alone") {
  Table table;
  constexpr int kThreads = 16;
  constexpr int kEach = 30;
  std::atomic<int> failed{0};
  std::vector<std::thread> threads;
  for (int thread = 0; thread < kThreads; ++thread) {
    threads.emplace_back([&, thread] {
      for (int i = 0; i < kEach; ++i) {
        const std::int64_t x = thread * kEach + i;
        const bool good = x % 3 != 0;
        const Result<std::uint64_t> added = table.writer().write([&](Connection& connection) {
          const std::uint64_t rows = Query(connection, "INSERT INTO t VALUES (?)", x).run();
          if (x % 6 == 0) Query(connection, "INSERT INTO t VALUES (?)", x).run();  // twice: refused
          if (x % 6 == 3) throw std::runtime_error("a bug");
          return rows;
        });
        if (added.ok() != good) failed.fetch_add(1000);
        if (!added && added.error().code == ErrorCode::internal) failed.fetch_add(1);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(failed.load() == kThreads * kEach / 3);
  CHECK(table.count() == kThreads * kEach * 2 / 3);
}

TEST_CASE("writer: waiting writes share a transaction") {
  Table table;
  constexpr int kThreads = 20;
  std::atomic<int> coming{0};
  std::atomic<int> done{0};
  std::thread holder([&] {
    // While this one is in its transaction, the others begin to wait.
    const Result<int> held = table.writer().write([&](Connection& connection) {
      Query(connection, "INSERT INTO t VALUES (-1)").run();
      while (coming.load() < kThreads) std::this_thread::yield();
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      return 0;
    });
    if (held) done.fetch_add(1);
  });
  std::vector<std::int64_t> seen_outside(kThreads, -1);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < seen_outside.size(); ++i) {
    threads.emplace_back([&, i] {
      coming.fetch_add(1);
      const Result<int> added = table.writer().write([&](Connection& connection) {
        Query(connection, "INSERT INTO t VALUES (?)", i).run();
        seen_outside[i] = table.count();
        return 0;
      });
      if (added) done.fetch_add(1);
    });
  }
  holder.join();
  for (std::thread& thread : threads) thread.join();
  CHECK(done.load() == kThreads + 1);
  CHECK(table.count() == kThreads + 1);
  // A row is visible only after its commit: writers that saw the same number of rows shared a transaction.
  const std::set<std::int64_t> transactions(seen_outside.begin(), seen_outside.end());
  CHECK(transactions.size() < kThreads / 2);
}

TEST_CASE("writer: a database locked by another process is an error until it is free") {
  Table table;
  Connection other(table.path(), Connection::Use::write);
  other.execute("BEGIN IMMEDIATE");
  const Result<std::uint64_t> added = table.add(1);
  REQUIRE_FALSE(added.ok());
  CHECK(added.error().code == ErrorCode::storage_unavailable);
  CHECK(added.error().message.find("locked") != std::string::npos);
  other.execute("ROLLBACK");
  CHECK(got(table.add(1)) == 1);
}

TEST_CASE("sqlite: a read that failed may pass, a damaged database does not") {
  const SQLite::Exception malformed("database disk image is malformed", SQLITE_CORRUPT);  // of both
  CHECK(to_error(malformed, EIO).code == ErrorCode::storage_unavailable);
  CHECK(to_error(malformed, EIO).message == "the database cannot be read: Input/output error");
  CHECK(to_error(malformed).code == ErrorCode::storage_damaged);
  CHECK(to_error(malformed, 0, with_path("x.sqlite")).message ==
        "the database 'x.sqlite' is damaged: database disk image is malformed");
}

TEST_CASE("readers: more threads than connections, and an error loses no connection") {
  Table table;
  got(table.add(5));
  Readers readers(table.path());
  for (std::size_t i = 0; i < 2 * Readers::kMost; ++i) {
    const auto read = readers.read([](Connection& connection) {
      Query query(connection, "SELECT nothing FROM nowhere");
      return query.next();
    });
    CHECK_FALSE(read.ok());
    const auto written = readers.read([](Connection& connection) { return Query(connection, "DELETE FROM t").run(); });
    CHECK_FALSE(written.ok());
  }
  std::atomic<int> right{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 30; ++i) {
    threads.emplace_back([&] {
      const auto read = readers.read([](Connection& connection) {
        Query query(connection, "SELECT x FROM t");
        query.next();
        return query.number(0);
      });
      if (read && *read == 5) right.fetch_add(1);
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(right.load() == 30);
}
