// PostgreSQL over libpq: a connection that blocks no longer than its deadline, keeps its prepared statements, and
// throws a PgFailure that says whether to try again. One thread at a time may use a connection.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/store/postgres/values.h"
#include "server/store/sql.h"

struct pg_conn;  // libpq's PGconn

namespace meshgauge::server::store {

using SteadyTime = std::chrono::steady_clock::time_point;

struct PgFailure {
  std::string state;  // SQLSTATE; empty: the connection itself failed
  std::string message;
  bool connection_lost = false;  // lost or unusable: another connection is needed
  bool may_pass = false;         // the same statement may succeed if it is sent again
};

// The error for callers of the store.
Error to_error(const PgFailure& failure);

class PgConnection {
 public:
  // Joins the job of a row `item` of batch_items; all columns are NULL when the job is gone (rows.h). OFFSET 0, here
  // and in other statements, makes PostgreSQL find the rows one by one by the index of their keys, whatever number of
  // rows it estimates.
  static constexpr Sql kJobOfItem{R"sql(
      LEFT JOIN LATERAL (SELECT * FROM jobs WHERE owner = item.owner AND id = item.job OFFSET 0) AS jobs ON true)sql"};

  // Connects to a server that can be written to. Blocks up to the connection string's connect_timeout for each host, 2
  // s by default.
  static std::unique_ptr<PgConnection> open(const std::string& database);

  // Calls that pass the deadline lose the connection. There is none at first.
  void set_deadline(SteadyTime deadline) { deadline_ = deadline; }

  // Executes one statement, prepared at its first use. Precondition: `sql` lives as long as the program.
  template <class... Values>
  PgRows query(const char* sql, const Values&... values) {
    return query(sql, PgValues(values...));
  }
  PgRows query(const char* sql, const PgValues& values);
  PgRows execute(const std::string& sql);  // one or several statements without parameters; returns the rows of the last

  // Makes all earlier commits durable, of other connections, too; in a transaction when that is committed. For a caller
  // that finds its work done: its own commit writes nothing, so it waits for no disk and no standby, and the commit
  // that did the work may not have waited.
  void put_barrier() { query("SELECT pg_logical_emit_message(true, 'meshgauge', '')"); }

  bool usable() const;
  bool in_transaction() const;
  int socket() const;

  // Returns the notifications that have arrived, without blocking. Notices that the connection has ended.
  struct Notification {
    std::string channel, payload;
  };
  std::vector<Notification> notifications();

 private:
  struct Closed {
    void operator()(pg_conn* connection) const;
  };

  explicit PgConnection(pg_conn* connection);

  PgRows finish(bool sent);
  void read_all();
  const std::string& prepared(const char* sql, const PgValues& values);
  void wait(short events);
  [[noreturn]] void lost(const std::string& why);

  std::unique_ptr<pg_conn, Closed> connection_;
  SteadyTime deadline_ = SteadyTime::max();
  SteadyTime plans_until_{};
  bool lost_ = false;
  bool unreplicated_ = false;  // a commit stopped waiting for the standby
  std::unordered_map<std::string_view, std::string> names_;
  std::uint64_t prepared_ = 0;  // statements, also those that failed
};

// A transaction; rolled back by the destructor unless commit() was called.
class PgTransaction {
 public:
  explicit PgTransaction(PgConnection& connection) : connection_(connection) { connection.execute("BEGIN"); }
  PgTransaction(const PgTransaction&) = delete;
  PgTransaction& operator=(const PgTransaction&) = delete;
  ~PgTransaction();
  void commit();

 private:
  PgConnection& connection_;
};

}  // namespace meshgauge::server::store
